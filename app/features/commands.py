"""Command palette, About box and bug report."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from PySide6.QtCore import QEvent, QObject, QSysInfo, Qt, qVersion
from PySide6.QtGui import QAction, QGuiApplication, QKeyEvent
from PySide6.QtWidgets import QLineEdit, QListWidget, QListWidgetItem, QMessageBox, QWidget

from kogao_core import __version__
from kogao_core.base.language import Text
from kogao_core.cli import doctor, licences

from ..i18n import bare, tr, tr_count, translated
from ..render.colour import told_screen
from ..widgets.controls import column_of, muted_label
from ..widgets.dialogs import Dialog, question
from .feature import Context, Feature

_PALETTE_PX: Final = (440, 360)
_ROWS: Final = (Qt.Key.Key_Up, Qt.Key.Key_Down, Qt.Key.Key_PageUp, Qt.Key.Key_PageDown)
_SEARCHED: Final = Qt.ItemDataRole.UserRole
# Search terms from other programs, by action name.
_ALSO_CALLED: Final = {
    "compare-wipe": Text("before after split slider original"),
    "compare-side": Text("before after original"),
    "compare-difference": Text("before after change"),
    "hide-overlays": Text("points marks guides"),
    "fit": Text("whole zoom window"),
    "actual": Text("zoom pixels 1:1"),
    "undo": Text("history back revert"),
    "redo": Text("history forward again"),
    "save": Text("export write JPEG"),
    "export": Text("save resize web size quality"),
    "tool-push": Text("forward warp liquify smudge"),
    "tool-restore": Text("reconstruct liquify original"),
    "tool-brush": Text("freeze mask lock"),
    "tool-eraser": Text("thaw unmask"),
    "follow-photo": Text("reset clear"),
    "preferences": Text("settings options language theme"),
    "copy-settings": Text("sync"),
    "paste-settings": Text("sync"),
}


class Palette(Dialog):
    """Type to filter the list, Return to run the selected command, Escape to close."""

    def __init__(self, actions: Mapping[str, QAction], parent: QWidget) -> None:
        super().__init__(tr("Commands"), parent, _PALETTE_PX)
        self.words, self.list = QLineEdit(), QListWidget()
        self.words.setPlaceholderText(tr("What do you want to do?"))
        self.words.setAccessibleName(tr("Search commands"))
        self.words.installEventFilter(self)
        self.list.setAccessibleName(tr("Commands"))
        self.list.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self._actions = []
        for name, action in actions.items():
            if action.isEnabled() and action.text():
                self._actions.append(action)
                item = QListWidgetItem(_title(action), self.list)
                also = translated(_ALSO_CALLED.get(name, ""))
                item.setData(_SEARCHED, f"{item.text()} {action.statusTip()} {also}".casefold())
        self.nothing = muted_label(tr("No command found; try another word."), wraps=True)
        column_of(self, self.words, self.nothing, self.list, margin=8)
        self.words.textChanged.connect(self._narrow)
        self.words.returnPressed.connect(self._run)
        self.list.itemClicked.connect(self._run)
        self._narrow("")

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Forward navigation keys from the search line to the list."""
        if event.type() == QEvent.Type.KeyPress and isinstance(event, QKeyEvent):
            if event.key() not in _ROWS:
                return False
            self.list.keyPressEvent(event)
            self._tell()
            return True
        return super().eventFilter(watched, event)

    def _narrow(self, text: str) -> None:
        words, found = text.casefold().split(), []
        for row in range(self.list.count()):
            item = self.list.item(row)
            item.setHidden(not all(word in item.data(_SEARCHED) for word in words))
            if not item.isHidden():
                found.append(row)
        # Select a command with the search text in the name before a command with matching terms.
        named = (
            row for row in found if words and words[0] in self.list.item(row).text().casefold()
        )
        self.list.setCurrentRow(next(named, found[0] if found else -1))
        self.nothing.setHidden(bool(found))
        self._count = len(found)
        self._tell()

    def _tell(self) -> None:
        """Tell the selected command and the number of hits, as a description of the focus."""
        item = self.list.currentItem()
        hits = tr_count(self._count, "{n} command", "{n} commands")
        hit = self.nothing.text() if item is None else f"{item.text()}, {hits}"
        self.words.setAccessibleDescription(hit)

    def _run(self) -> None:
        row = self.list.currentRow()
        if row >= 0 and not self.list.item(row).isHidden():
            # Close first: the action may open a dialog.
            self.accept()
            self._actions[row].trigger()


def _title(action: QAction) -> str:
    name = bare(action.text()).rstrip("…")
    key = action.shortcut().toString()
    return f"{name}   {key}" if key else name


def about_box(parent: QWidget) -> QMessageBox:
    """Return the About box; `open` shows the box without blocking."""
    text = tr("Kogao {version}, an exact small-face editor", version=__version__)
    box = question(parent, text, QMessageBox.Icon.NoIcon)
    box.setWindowTitle(tr("About Kogao"))
    box.setTextFormat(Qt.TextFormat.PlainText)
    paper = tr(
        "After M. Seo, Y.-W. Chen and H. Aoki, “Automatic Transformation of “KOGAO” (Small Face) "
        "based on Fast B-spline Approximation”, 2011."
    )
    licence = tr(
        "Licensed under Apache-2.0. The details name everything it is built on and its licence."
    )
    box.setInformativeText(f"{paper}\n\n{licence}")
    box.setDetailedText(licences.text())
    box.setStandardButtons(QMessageBox.StandardButton.Close)
    return box


class Commands(Feature):
    """Shows the palette and the About box, and copies the bug report."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self.bind("palette", self._show_palette)
        self.bind("copy-report", self._copy_report)
        self.bind("about", lambda: about_box(self.window).open())

    def _show_palette(self) -> None:
        named = {name: action for name, action in self.actions.items() if name != "palette"}
        shown = *self.window.menus["presets"].actions(), *self.window.docks.toggles()
        more = (a for a in shown if a.text() and not a.menu() and a not in named.values())
        Palette({**named, **{a.text(): a for a in more}}, self.window).open()

    def _copy_report(self) -> None:
        system = f"{QSysInfo.prettyProductName()}, {QGuiApplication.platformName()}, {qVersion()}"
        window = tr("Window: {system}", system=system)
        text = f"{doctor.text(doctor.examine())}\n{window}\n{told_screen()}\n"
        QGuiApplication.clipboard().setText(text)
        self.say(tr("The report is on the clipboard."), wrong=False)
