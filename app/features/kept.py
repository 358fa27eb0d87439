"""A list of what Kogao keeps about photos, to delete by photo or as a whole."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Final

from PySide6.QtWidgets import QLabel, QTableWidget, QWidget

from kogao_core.base.wording import local_time
from kogao_core.projects.forgetting import KeptPhoto, forget, kept

from ..i18n import reason, tr, tr_count, translated
from ..theme import GRID_PX
from ..widgets.controls import column_of, row_of
from ..widgets.dialogs import Dialog, button, confirm, table
from . import recent
from .feature import Context, Feature
from .strip import Strip

_SIZE_PX: Final = (820, 420)


class KeptDialog(Dialog):
    """Shows a row for each photo; the buttons delete all about the selected photos, or all."""

    def __init__(self, feature: KeptFeature, photos: Sequence[KeptPhoto], parent: QWidget) -> None:
        super().__init__(tr("What Kogao keeps"), parent, _SIZE_PX)
        self._feature, self._photos = feature, photos
        head = (tr("Photo"), tr("Kept"), tr("Size"), tr("Newest"))
        rows = [
            (
                str(one.photo),
                ", ".join(map(translated, one.what)),
                tr("{kb:,.1f} kB", kb=one.size / 1e3),
                f"{local_time(one.newest_ns):%Y-%m-%d %H:%M}",
            )
            for one in photos
        ]
        self.list = table(tr("What Kogao keeps"), head, rows)
        self.list.setSelectionBehavior(QTableWidget.SelectionBehavior.SelectRows)
        note = QLabel(
            tr("All of it is in {folder}. Files beside photos stay.", folder=feature.storage.data)
        )
        note.setWordWrap(True)
        some = button(tr("&Delete all of the selected photos…"), lambda: self._ask(self.chosen()))
        every = button(tr("Delete &everything…"), lambda: self._ask(self._photos))
        below = row_of(some, every, None, self.closing())
        column_of(self, note, self.list, below, margin=4 * GRID_PX, spacing=2 * GRID_PX)

    def chosen(self) -> list[KeptPhoto]:
        return [self._photos[it.row()] for it in self.list.selectionModel().selectedRows()]

    def _ask(self, photos: Sequence[KeptPhoto]) -> None:
        if photos:
            text = tr_count(
                len(photos),
                "Delete what is kept about {n} photo, with its stored original?",
                "Delete what is kept about {n} photos, with their stored originals?",
            )
            confirm(self, text, tr("&Delete"), partial(self._delete, photos))

    def _delete(self, photos: Sequence[KeptPhoto]) -> None:
        self.accept()
        self._feature.delete(photos)


class KeptFeature(Feature):
    """Lists the data that Kogao keeps about photos, and deletes data in a worker."""

    def __init__(self, context: Context, strip: Strip) -> None:
        super().__init__(context)
        self._strip = strip
        self._listing = self.lane(self._show, self._fail)
        self._deleting = self.lane(self._deleted, self._fail)
        self.bind("kept", self.ask)

    def ask(self) -> None:
        self._listing.submit(partial(kept, self.storage.data))

    def delete(self, photos: Sequence[KeptPhoto]) -> None:
        """Delete what is kept about photos, then show the rest."""
        data, paths = self.storage.data, [one.photo for one in photos]
        for path in paths:
            recent.remove(self.settings, path)
        self._deleting.submit(lambda: (forget(paths, data), paths)[1])

    def _deleted(self, paths: Sequence[Path]) -> None:
        for path in paths:
            self._strip.look_again(path)
        self.ask()

    def _show(self, photos: Sequence[KeptPhoto]) -> None:
        KeptDialog(self, photos, self.window).open()

    def _fail(self, problem: Exception) -> None:
        self.say(tr("What is kept can't be read or deleted ({why}).", why=reason(problem)))
