"""Offline documentation of the installed version."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

from PySide6.QtCore import Qt, QUrl
from PySide6.QtGui import QImage, QTextDocument
from PySide6.QtWidgets import QTextBrowser

from kogao_core.base import assets
from kogao_core.base.language import language

from ..i18n import sentence, tr
from ..theme import GRID_PX
from ..widgets.controls import column_of
from ..widgets.dialogs import Dialog
from .feature import Context, Feature

_FIRST: Final = "editor.md"
_SIZE_PX: Final = (880, 660)
_PICTURE_PX: Final = 680


class Pages(QTextBrowser):
    """Markdown pages: most systems have no program that shows Markdown."""

    def __init__(self, page: Path) -> None:
        super().__init__()
        self.setOpenExternalLinks(True)
        self.setAccessibleName(tr("Documentation"))
        self.setSource(QUrl.fromLocalFile(str(page)))

    def loadResource(self, kind: int, name: QUrl | str) -> Any:
        """Load a page, or a picture scaled to at most the text width."""
        loaded = super().loadResource(kind, name)
        if kind != QTextDocument.ResourceType.ImageResource.value:
            return loaded
        picture = QImage.fromData(loaded)
        wide = picture.width() > _PICTURE_PX
        smooth = Qt.TransformationMode.SmoothTransformation
        return picture.scaledToWidth(_PICTURE_PX, smooth) if wide else picture


class Documentation(Feature):
    """Shows the installed documentation."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self.bind("documentation", self._show)

    def _show(self) -> None:
        self.window.bar.clear()
        try:
            folder = assets.documentation()
        except assets.AssetMissing as problem:
            self.say(sentence(problem))
            return
        pages = (folder / language() / _FIRST, folder / _FIRST)
        dialog = Dialog(tr("Documentation"), self.window, _SIZE_PX)
        shown = Pages(next(page for page in pages if page.is_file()))
        column_of(dialog, shown, dialog.closing(), margin=2 * GRID_PX, spacing=2 * GRID_PX)
        dialog.show()
