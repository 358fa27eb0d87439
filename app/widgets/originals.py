"""Preferences page with the stored originals of overwritten photos."""

from __future__ import annotations

from PySide6.QtWidgets import QListWidget, QListWidgetItem, QPushButton, QWidget

from kogao_core.base.language import Text
from kogao_core.base.wording import printable
from kogao_core.photo.originals import Originals, StoredOriginal

from ..i18n import tr
from .controls import column_of, muted_label

_LIST_PX = 120


class OriginalsPage(QWidget):
    """Lists the stored originals with sizes, and deletes the selected originals."""

    def __init__(self, store: Originals) -> None:
        super().__init__()
        self._store = store
        self._shown: list[StoredOriginal] = []
        self.summary = muted_label(wraps=True)
        self.list = QListWidget()
        self.list.setSelectionMode(QListWidget.SelectionMode.ExtendedSelection)
        self.list.setAccessibleName(tr("Stored originals"))
        self.list.setMinimumHeight(_LIST_PX)
        self.forget = QPushButton(tr("&Delete selected originals"))
        self.forget.setToolTip(tr("The photos stay; their changes can't be undone any more"))
        self.forget.clicked.connect(self._forget)
        self.list.itemSelectionChanged.connect(self._enable)
        column_of(self, self.summary, self.list, self.forget)
        self._show()

    def _show(self) -> None:
        self._shown = [one for one in self._store.all() if one.file.is_file()]
        self.list.clear()
        for one in self._shown:
            size = one.file.stat().st_size / 1e6
            item = QListWidgetItem(f"{(one.photo or one.file).name}  {size:.1f} MB")
            item.setText(printable(item.text()))
            item.setToolTip(printable(str(one.photo or one.file)))
            self.list.addItem(item)
        total = sum(one.file.stat().st_size for one in self._shown)
        number = Text.counted(len(self._shown), "{n} original", "{n} originals")
        where = printable(str(self._store.folder))
        text = tr("{count}, {size:.1f} MB, in {folder}", count=number, size=total / 1e6,
                  folder=where)  # fmt: skip
        self.summary.setText(text)
        self._enable()

    def _enable(self) -> None:
        self.forget.setEnabled(bool(self.list.selectedItems()))

    def _forget(self) -> None:
        for item in self.list.selectedItems():
            self._shown[self.list.row(item)].remove()
        self._show()
