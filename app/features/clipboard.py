"""The result as a picture on the clipboard, and photos that were copied as files."""

from __future__ import annotations

import tempfile
from pathlib import Path

from PySide6.QtGui import QGuiApplication, QImage

from kogao_core.photo.export import Export

from ..i18n import sentence, tr
from ..widgets.dialogs import files_in
from .disclosure import SaveOptions
from .feature import Context, Feature
from .files import save_copy


class Clipboard(Feature):
    """Copies the result, and opens copied files as a drop does."""

    def __init__(self, context: Context, options: SaveOptions) -> None:
        super().__init__(context)
        self._options = options
        self._drawing = self.lane(self._drawn, lambda problem: self.say(sentence(problem)))
        self.bind("copy-result", self.copy)
        self.bind("open-copied", self.open)

    def copy(self) -> None:
        """Copy the result, in sRGB: other programs rarely read a profile there."""
        self.document.commit()
        photo, state, finder = self.document.photo, self.document.committed, self.live.finder
        drawn, disclosure = self.live.lent(), self._options.current
        assert photo is not None  # the command is off without a photo

        def draw() -> QImage:
            with tempfile.TemporaryDirectory() as folder:
                place = Path(folder, "result.png")
                save_copy(photo, state, disclosure, place, finder, drawn, export=Export(srgb=True))
                return QImage(str(place))

        self.working.emit(tr("Copying the result…"))
        self._drawing.submit(draw)

    def _drawn(self, picture: QImage) -> None:
        QGuiApplication.clipboard().setImage(picture)
        self.did.emit(tr("Result copied"))

    def open(self) -> None:
        copied = QGuiApplication.clipboard().mimeData()
        if copied.hasUrls():
            self.window.dropped.emit(files_in(copied))
        else:
            self.say(tr("The clipboard holds no photo file; copy a file, or drop it here."))
