"""Offline documentation of the installed version."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, Final

from PySide6.QtCore import Qt, QUrl
from PySide6.QtGui import QDesktopServices, QImage, QKeySequence, QShortcut, QTextDocument
from PySide6.QtWidgets import QLineEdit, QPushButton, QTextBrowser, QWidget

from kogao_core.base import assets
from kogao_core.base.language import language

from ..i18n import sentence, tr
from ..theme import GRID_PX
from ..widgets.controls import ChoiceBox, column_of, row_of
from ..widgets.dialogs import Dialog
from .feature import Context, Feature

_FIRST: Final = "editor.md"
_SIZE_PX: Final = (880, 660)
_PICTURE_PX: Final = 680
_TITLE: Final = re.compile(r"^# (.*)$", re.MULTILINE)
_NOT_IN_ANCHORS: Final = re.compile(r"[^\w\- ]")


class Pages(QTextBrowser):
    """Markdown pages of a folder; external links open in the browser."""

    def __init__(self, folder: Path) -> None:
        super().__init__()
        self.folder = folder
        self.setOpenLinks(False)
        self.anchorClicked.connect(self.follow)
        self.setAccessibleName(tr("Documentation"))

    def follow(self, link: QUrl) -> None:
        """Follow a link to a page or a heading; open other links in the browser."""
        url = self.source().resolved(link)
        if not url.isLocalFile():
            QDesktopServices.openUrl(url)
        elif Path(url.toLocalFile()).is_file():
            self.setSource(url, QTextDocument.ResourceType.MarkdownResource)
            self._seek(url.fragment())

    def loadResource(self, kind: int, name: QUrl | str) -> Any:
        """Load a page, or a picture scaled to at most the text width."""
        loaded = super().loadResource(kind, name)
        if kind != QTextDocument.ResourceType.ImageResource.value:
            return loaded
        picture = QImage(self.source().resolved(QUrl(name)).toLocalFile())
        smooth = Qt.TransformationMode.SmoothTransformation
        wide = picture.width() > _PICTURE_PX
        return picture.scaledToWidth(_PICTURE_PX, smooth) if wide else picture

    def _seek(self, anchor: str) -> None:
        """Scroll to a heading by GitHub's anchor: Qt creates no anchors from Markdown."""
        block = self.document().begin()
        while anchor and block.isValid():
            if block.blockFormat().headingLevel() and _anchor(block.text()) == anchor:
                place = self.document().documentLayout().blockBoundingRect(block)
                self.verticalScrollBar().setValue(round(place.top()))
            block = block.next()


def _anchor(heading: str) -> str:
    return _NOT_IN_ANCHORS.sub("", heading).strip().lower().replace(" ", "-")


class HelpDialog(Dialog):
    """Documentation pages with a list, a Back button and a search line."""

    def __init__(self, folder: Path, parent: QWidget) -> None:
        super().__init__(tr("Documentation"), parent, _SIZE_PX)
        self.pages = Pages(folder)
        self.back = QPushButton(tr("&Back"))
        self.back.setAutoDefault(False)
        self.back.clicked.connect(self.pages.backward)
        self.pages.backwardAvailable.connect(self.back.setEnabled)
        self.list = ChoiceBox()
        self.list.setAccessibleName(tr("Pages"))
        for path in _pages(folder):
            self.list.addItem(_title(path), path.as_posix())
        self.list.activated.connect(self._turn)
        self.pages.sourceChanged.connect(self._mark)
        self.words = QLineEdit()
        self.words.setAccessibleName(tr("Find in this page"))
        self.words.setPlaceholderText(tr("Find in this page"))
        self.words.setClearButtonEnabled(True)
        self.words.returnPressed.connect(self._find)
        self.back.setEnabled(False)
        QShortcut(QKeySequence.StandardKey.Find, self, self.words.setFocus)
        QShortcut(QKeySequence.StandardKey.Back, self, self.pages.backward)
        row = row_of(self.back, self.list, None, self.words)
        column_of(self, row, self.pages, margin=2 * GRID_PX, spacing=2 * GRID_PX)
        first = next(path for path in _pages(folder) if path.name == _FIRST)
        self.pages.follow(QUrl.fromLocalFile(str(first)))
        self.pages.setFocus()

    def _turn(self) -> None:
        self.pages.follow(QUrl.fromLocalFile(self.list.currentData()))

    def _mark(self, page: QUrl) -> None:
        self.list.setCurrentIndex(self.list.findData(page.toLocalFile()))

    def _find(self) -> None:
        """Search the words, and start again at the top after the last match."""
        words = self.words.text()
        if words and not self.pages.find(words):
            cursor = self.pages.textCursor()
            cursor.movePosition(cursor.MoveOperation.Start)
            self.pages.setTextCursor(cursor)
            self.pages.find(words)


def _pages(folder: Path) -> list[Path]:
    """Return the pages in the current language, then the English pages."""
    return [*sorted((folder / language()).glob("*.md")), *sorted(folder.glob("*.md"))]


def _title(path: Path) -> str:
    found = _TITLE.search(path.read_text(encoding="utf-8"))
    return found[1] if found else path.stem


class Documentation(Feature):
    """Shows the installed documentation."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self.bind("documentation", self.open)

    def open(self) -> None:
        """Show the documentation in a separate window."""
        self.window.bar.clear()
        try:
            folder = assets.documentation()
        except assets.AssetMissing as problem:
            self.say(sentence(problem))
            return
        dialog = self.window.findChild(HelpDialog) or HelpDialog(folder, self.window)
        dialog.present()
