"""The faces of the photo: detection, manual placement, selection and switching off."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Sequence
from itertools import zip_longest
from pathlib import Path

import numpy as np
from PySide6.QtCore import (
    QItemSelectionModel,
    QModelIndex,
    QPersistentModelIndex,
    QSignalBlocker,
    QSize,
    Qt,
    Signal,
)
from PySide6.QtGui import QIcon, QPainter
from PySide6.QtWidgets import (
    QListWidget,
    QListWidgetItem,
    QStyle,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QWidget,
)

from kogao_core.additions.lens import (
    STRETCH_SEEN_PERCENT,
    distance_m,
    distance_note,
    stretch_percent,
)
from kogao_core.base.geometry import Box
from kogao_core.faces.doubt import Reason, Verdict, verdicts
from kogao_core.faces.face import Face, LandmarkSource, in_reading_order
from kogao_core.faces.landmarks import template_face
from kogao_core.faces.names import names_of
from kogao_core.projects.interchange import faces_of
from kogao_core.projects.landmark_files import SUFFIXES

from ..ahead import FaceSearch
from ..document import State
from ..i18n import reason, sentence, tr, translated
from ..pyramid import PicturePyramid
from ..render.pictures import face_icon
from ..theme import GRID_PX
from ..widgets.controls import column_of, heading
from ..widgets.dialogs import ask_path
from ..widgets.docks import Dock
from ..widgets.messages import BarAction
from .feature import Context, Feature
from .recipe import RecipeEditing

_TEMPLATE_SHARE = 0.35  # of the photo's shorter side
_THUMBNAIL_PX = 40
_WIDTH_PX = 168
# Check mark, margins and gaps of a row, px.
_ROUND_TEXT_PX = 72
_ROW_PX = 52
# One word about a face, whether the word asks for a look, and whether it has settings of its own.
_WORD, _ASKS, _OWN = (Qt.ItemDataRole.UserRole + n for n in range(3))
_ALL_ROWS = 1  # the row of all faces precedes the rows of single faces


class Faces(Feature):
    """Detects faces and lists the faces."""

    name = "faces"
    # (faces: int): the search has ended, with this number of faces.
    found = Signal(int)
    # (why: str): the search has failed; before `found`.
    not_found = Signal(str)
    # (search: FaceSearch): a face is found while the search goes on; from a worker.
    _came = Signal(object)

    def __init__(self, context: Context, recipe: RecipeEditing, source: LandmarkSource) -> None:
        super().__init__(context)
        self._source = source
        # Setting time of the automatic method (Table 2), s, and whether the time includes
        # loading of networks.
        self.finding_s: float | None = None
        self.finding_was_cold = False
        self.names: tuple[str, ...] = ()  # of the faces, from the photo's metadata
        self._named: tuple[Face, ...] = ()  # faces for which the names were read
        self._finding = self.lane(self._take, self._not_found)
        self._importing = self.lane(self._import, lambda problem: self.say(sentence(problem)))
        self._search = FaceSearch(source)
        self._came.connect(self._show_found)
        self.bind("find", self.find)
        self.bind("place", self.place_template)
        self.bind("import-landmarks", self._ask_import)
        self.panel: FacesPanel = FacesPanel()
        self.dock = Dock(tr("Faces panel"), Qt.DockWidgetArea.LeftDockWidgetArea)
        self.panel.switched.connect(self.switch)
        self.panel.chosen.connect(lambda faces: recipe.choose(*faces))
        self.document.opened.connect(self._open)
        self.document.recoloured.connect(self._show_anew)
        self.document.watch(self._show, "faces", "off", "optics", "recipe", value=self._listed)
        self.view.watch(self._show, "face", "also")

    def _listed(self) -> tuple[object, ...]:
        state = self.document.state
        return state.faces, state.off, state.focal_mm

    # -- the search ------------------------------------------------------------------------------

    def use(self, source: LandmarkSource) -> None:
        """Replace the landmark source and detect faces again."""
        self._source = source
        self.find()

    def search(self) -> FaceSearch:
        """Return a new search with the current source."""
        return FaceSearch(self._source)

    def find(self) -> None:
        self.window.bar.clear()
        self.look(FaceSearch(self._source, first=False))

    def look(self, search: FaceSearch | None = None) -> None:
        """Detect faces in the open photo; keep edits made during the search."""
        photo = self.document.photo
        if photo is None:
            return
        self.stop()
        self._search = search = search or FaceSearch(self._source)
        if not self.document.touched:
            self.live.wait()
        self.working.emit(tr("Looking for faces…"))
        search.came = lambda: self._came.emit(search)
        # Show the faces found before the signals were connected.
        self._show_found(search)
        self._finding.submit(lambda: search.run(photo))

    def stop(self) -> None:
        """Cancel the running search and ignore later results."""
        self._search.stop()
        super().stop()

    def _show_found(self, search: FaceSearch) -> None:
        """Show new detections, unless the faces have been edited."""
        found = tuple(in_reading_order(search.found))
        if search is not self._search or found == search.shown:
            return
        if (
            not self.document.touched
            and self.document.state.sheet("automatic").faces == search.shown
        ):
            search.shown = found
            self.document.start_with(found)
        self.working.emit(tr("Looking for faces… {n} so far", n=len(found)))

    def _take(self, faces: list[Face]) -> None:
        self.finding_s, self.finding_was_cold = self._search.took_s, self._search.cold
        in_hand = (
            self.document.touched or self.view.face is not None or self.view.selected is not None
        )
        if not faces:
            self._offer_placing(tr("No face was found in this photo."))
        elif self._search.first and in_hand:
            self.document.add_found([one for one in faces if one not in self._search.shown])
        elif self.document.touched:
            state = self.document.state.with_found(faces, self.document.image)
            self.document.step(state, tr("Find faces"))
        else:
            self.document.start_with(faces)
        self._tell_doubts()
        self._end_search(len(faces))

    def _not_found(self, problem: Exception) -> None:
        self._offer_placing(sentence(problem))
        self.not_found.emit(reason(problem))
        self._end_search(0)

    def _end_search(self, faces: int) -> None:
        self.live.go_on()
        self.working.emit("")
        self.found.emit(faces)

    def _tell_doubts(self) -> None:
        """Explain why no face is changed, if every face is doubtful."""
        state, photo = self.document.state, self.document.photo
        judged = verdicts(state.faces, self.document.image)
        is_doubted = all(verdict.reason is not None for verdict in judged)
        if not judged or not is_doubted or len(state.off) < len(judged):
            return
        text = sentence(judged[0].told(1))
        if len(judged) > 1:
            text = tr("Every face in this photo is doubtful and left alone; the list says why.")

        def applies() -> bool:
            now = self.document.state
            return self.document.photo is photo and 0 < len(now.faces) == len(now.off)

        every = BarAction(tr("Make smaller all the same"), self._all_on)
        self.say(text, every, wrong=False, applies=applies)

    def _all_on(self) -> None:
        state = dataclasses.replace(self.document.state, off=frozenset())
        self.document.step(state, tr("Switch a face"))

    # -- placing by hand -------------------------------------------------------------------------

    def _offer_placing(self, text: str) -> None:
        place = BarAction(tr("Place a face by hand"), self.place_template)
        another = BarAction(tr("Open a photo…"), self.actions["open"].trigger)
        photo, search, before = self.document.photo, self._search, self.document.state

        def applies() -> bool:  # until a face is added
            state, here = self.document.state, self.document.photo is photo
            more = len(state.faces) > len(before.faces) or state.draft is not before.draft
            return here and self._search is search and not more

        self.say(text, place, another, applies=applies)

    def place_template(self) -> None:
        """Place a mean face in the middle of the photo, ready to drag."""
        image = self.document.image
        if not image.area:
            return
        middle = np.array([image.width, image.height]) / 2.0
        width = _TEMPLATE_SHARE * min(image.width, image.height)
        self.place(template_face(middle, width))
        done = BarAction(tr("It fits"), self.end_placing)
        text = tr(
            "Drag the frame onto the face; a corner turns and sizes it. Then drag single points."
        )
        self.say(text, done, wrong=False, applies=lambda: self.view.placing is not None)

    def place(self, face: Face) -> None:
        """Add a face and show a frame for dragging."""
        state = self.document.state
        more = dataclasses.replace(state, faces=(*state.faces, face))
        self.document.step(more, tr("Place a face"))
        self.view.set(placing=len(state.faces))

    def end_placing(self) -> None:
        """Hide the frame: the face is placed."""
        self.view.set(placing=None)

    # -- landmark files --------------------------------------------------------------------------

    def _ask_import(self) -> None:
        filters = [tr("Landmarks ({endings})", endings=" ".join(f"*{end}" for end in SUFFIXES))]
        title, at = tr("Import landmarks"), self.document.path
        ask_path(self.window, title, self.import_file, filters=filters, at=at and at.parent)

    def import_file(self, path: Path) -> None:
        """Replace all faces by the faces of a landmark file, as `--points` reads them."""
        self.window.bar.clear()
        if photo := self.document.photo:
            self._importing.submit(lambda: faces_of(photo, path))

    def _import(self, faces: list[Face]) -> None:
        state = dataclasses.replace(self.document.state, faces=tuple(faces), off=frozenset())
        self.document.step(state, tr("Import landmarks"))

    # -- the list --------------------------------------------------------------------------------

    def switch(self, index: int, on: bool) -> None:
        state = self.document.state
        off = state.off - {index} if on else state.off | {index}
        self.document.step(dataclasses.replace(state, off=off), tr("Switch a face"))

    def _open(self) -> None:
        self.stop()
        self.finding_s = None
        self._show_anew()

    def _show_anew(self) -> None:
        if self.document.pyramid is not None:
            self.panel.open(self.document.pyramid)
            self._show()

    def _show(self) -> None:
        document, faces = self.document, self.document.state.faces
        if document.photo is not None and not document.in_gesture and faces is not self._named:
            self.names, self._named = names_of(document.photo, faces).names, faces
        self.panel.show_state(document.state, self.view.face, self.view.also, self.names)


class FacesPanel(QWidget):
    """A row for all faces, then one row per face with check box, thumbnail and score."""

    # (face: int, on: bool): the check box of a face.
    switched = Signal(int, bool)
    # ((face: int or None, others: sequence of int)): the selected rows.
    chosen = Signal(object)

    def __init__(self) -> None:
        super().__init__()
        self._pyramid: PicturePyramid | None = None
        self._image = Box(0, 0, 0, 0)
        self._known: tuple[Face, ...] = ()
        self.list = QListWidget()
        self.list.setAccessibleName(tr("Faces"))
        self.list.setIconSize(QSize(_THUMBNAIL_PX, _THUMBNAIL_PX))
        self.list.setItemDelegate(_FaceRow(self.list))
        self.list.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.list.itemChanged.connect(self._tell_switch)
        self.list.setSelectionMode(QListWidget.SelectionMode.ExtendedSelection)
        self.list.itemSelectionChanged.connect(self._tell_choice)
        title = heading(tr("Face&s"))
        title.setBuddy(self.list)
        for widget in (title, self.list):
            widget.setToolTip(
                tr(
                    "Click a face to set it alone, with Ctrl or Shift several; its box switches it "
                    "on and off"
                )
            )
        column_of(self, title, self.list, margin=8)
        words = (
            tr("Face {n}", n=88),
            tr("by hand"),
            tr("check"),
            tr("in part"),
            *_doubts().values(),
        )
        text = max(map(self.list.fontMetrics().horizontalAdvance, words))
        self.setFixedWidth(max(_WIDTH_PX, _THUMBNAIL_PX + text + _ROUND_TEXT_PX))

    def open(self, photo: PicturePyramid) -> None:
        """Use another photo for the thumbnails."""
        self._pyramid, self._known = photo, ()
        self._image = Box.of(photo.levels[0])
        with QSignalBlocker(self.list):
            self.list.clear()

    def item(self, face: int) -> QListWidgetItem:
        return self.list.item(face + _ALL_ROWS)

    def show_state(
        self,
        state: State,
        chosen: int | None = None,
        also: Collection[int] = (),
        names: Sequence[str] = (),
    ) -> None:
        """Show the faces; keep thumbnails during a drag. `names`: of faces, or ""."""
        with QSignalBlocker(self.list):
            if self._reordered(state.faces) or not self.list.count():
                self._begin_rows()
            self._add_rows(state.faces[self.list.count() - _ALL_ROWS :])
            self._known = state.faces
            judged = verdicts(state.faces, self._image)
            for index, (face, verdict) in enumerate(zip(state.faces, judged, strict=True)):
                off = index in state.off
                check = Qt.CheckState.Unchecked if off else Qt.CheckState.Checked
                item = self.item(index)
                item.setCheckState(check)
                name = next(iter(names[index : index + 1]), "")
                item.setText(name or tr("Face {n}", n=index + 1))
                item.setData(_WORD, next(iter(_doubted(face, verdict)), ""))
                item.setData(_ASKS, bool(verdict.look_at or verdict.reason))
                item.setData(_OWN, face.recipe is not None)
                more = *_score(face), *_own(face), *_stretched(face, state), *_distance(face, state)
                item.setToolTip("\n".join([_tip(index, verdict), *more]))
                item.setData(
                    Qt.ItemDataRole.AccessibleTextRole,
                    ", ".join([item.text(), *_score(face), *_doubted(face, verdict), *_own(face)]),
                )
            row = 0 if chosen is None else chosen + _ALL_ROWS
            self.list.setCurrentRow(row, QItemSelectionModel.SelectionFlag.ClearAndSelect)
            for index in also:
                self.item(index).setSelected(True)

    def _reordered(self, faces: tuple[Face, ...]) -> bool:
        """Return whether thumbnails would no longer match the faces."""
        there = set(self._known)
        pairs = zip_longest(faces, self._known)
        return any(now is not known and (now in there or now is None) for now, known in pairs)

    def _begin_rows(self) -> None:
        self.list.clear()
        everyone = QListWidgetItem(tr("All faces"))
        everyone.setToolTip(tr("The settings of the photo"))
        self.list.addItem(everyone)

    def _add_rows(self, faces: tuple[Face, ...]) -> None:
        for face in faces:
            icon = QIcon()
            if self._pyramid is not None:
                icon = face_icon(self._pyramid, face, _THUMBNAIL_PX, self.devicePixelRatioF())
            self.list.addItem(QListWidgetItem(icon, ""))

    def _tell_switch(self, item: QListWidgetItem) -> None:
        on = item.checkState() == Qt.CheckState.Checked
        self.switched.emit(self.list.row(item) - _ALL_ROWS, on)

    def _tell_choice(self) -> None:
        rows = [index.row() for index in self.list.selectedIndexes()]
        now = self.list.currentRow()
        if rows and now < _ALL_ROWS:
            self.chosen.emit((None, ()))
        elif rows:
            faces = [row - _ALL_ROWS for row in rows if row >= _ALL_ROWS]
            now -= _ALL_ROWS
            self.chosen.emit((now if now in faces else faces[-1], faces))


class _FaceRow(QStyledItemDelegate):
    """A row: picture, name over one word, a dot for settings of its own, and the switch."""

    def initStyleOption(
        self, option: QStyleOptionViewItem, index: QModelIndex | QPersistentModelIndex
    ) -> None:
        """Place the switch at the right, and fade a face that is off."""
        super().initStyleOption(option, index)
        # From right to left, the check box comes first at the right.
        option.direction = Qt.LayoutDirection.RightToLeft
        option.decorationPosition = QStyleOptionViewItem.Position.Right
        option.displayAlignment = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        if index.data(_OWN):
            option.text += " \N{BULLET}\N{LEFT-TO-RIGHT MARK}"
        if index.data(_WORD):
            option.text += "\N{LINE SEPARATOR}\N{NO-BREAK SPACE}"
        if option.checkState == Qt.CheckState.Unchecked and index.row():
            option.state &= ~QStyle.StateFlag.State_Enabled

    def paint(
        self,
        painter: QPainter,
        option: QStyleOptionViewItem,
        index: QModelIndex | QPersistentModelIndex,
    ) -> None:
        """Write the word below the name, in the warning colour if it asks for a look."""
        super().paint(painter, option, index)
        row, part = QStyleOptionViewItem(option), QStyle.SubElement.SE_ItemViewItemText
        self.initStyleOption(row, index)
        place = row.widget.style().subElementRect(part, row, row.widget)
        painter.setFont(row.font)
        ink = row.palette.brightText() if index.data(_ASKS) else row.palette.placeholderText()
        painter.setPen(ink.color())
        left = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter
        painter.drawText(place.adjusted(GRID_PX, 0, 0, 0), left, f"\n{index.data(_WORD) or ''}")

    def sizeHint(
        self, option: QStyleOptionViewItem, index: QModelIndex | QPersistentModelIndex
    ) -> QSize:
        line = option.fontMetrics.height()
        return QSize(0, max(_ROW_PX, 2 * line + 3 * GRID_PX) if index.row() else 2 * line)


def _doubts() -> dict[Reason, str]:
    return {
        "unsure": tr("unsure"),
        "on its head": tr("on its head"),
        "turned": tr("turned away"),
        "cut": tr("cut off"),
        "hidden": tr("hidden"),
    }


def _doubted(face: Face, verdict: Verdict) -> list[str]:
    """Return the words about a face, the most important first."""
    check = [tr("check")] if verdict.look_at else []
    reason = [] if verdict.reason is None else [_doubts()[verdict.reason]]
    part = [tr("in part")] if verdict.why and not (check or reason) else []
    by_hand = [tr("by hand")] if face.source == "manual" else []
    return [*check, *reason, *part, *by_hand]


def _score(face: Face) -> list[str]:
    """Return the certainty of the detector."""
    certain = tr("found with {n:.0f} % certainty", n=100 * face.score)
    return [] if face.source == "manual" else [certain]


def _own(face: Face) -> list[str]:
    """Return the amount of a face with settings of its own."""
    own = face.recipe
    return [] if own is None else [tr("own settings, {n:g} %", n=own.percent)]


def _stretched(face: Face, state: State) -> list[str]:
    """Return the stretch by the lens in %, if known and visible; else an empty list."""
    focal = state.focal_mm
    percent = 0.0 if focal is None else stretch_percent(face, focal, state.image)
    return [tr("lens: {n:.1f} %", n=percent)] if percent >= STRETCH_SEEN_PERCENT else []


def _distance(face: Face, state: State) -> list[str]:
    """Return the camera distance of a face, if the focal length is known."""
    focal = state.focal_mm
    return [] if focal is None else [sentence(distance_note(distance_m(face, focal, state.image)))]


def _tip(index: int, verdict: Verdict) -> str:
    """Return the tooltip of a row: usage, the reason for switching off, or a warning."""
    if verdict.reason is None:
        tip = tr("Face {n}: select to change it alone, uncheck to leave it as it is", n=index + 1)
        return f"{tip}\n{sentence(verdict.why)}" if verdict.why else tip
    return tr(
        "Face {n} starts switched off: {why}. Check it to make it smaller all the same.",
        n=index + 1,
        why=translated(verdict.why),
    )
