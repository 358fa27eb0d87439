"""The recipe's sliders and choices, and what they amount to."""

from __future__ import annotations

import math
from typing import Final

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtWidgets import (
    QAbstractButton,
    QButtonGroup,
    QCheckBox,
    QComboBox,
    QFormLayout,
    QHBoxLayout,
    QSizePolicy,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from kogao_core import fit
from kogao_core.pipeline import Rendering

from ..document import DEFAULT, State
from ..i18n import tr
from ..surfaces import Frame
from ..theme import GRID_PX
from .controls import Fold, Scale, ValueSlider, column_of, heading, muted_label
from .gauge import NaturalnessGauge
from .owner import OwnerLine

_PER_OCTAVE: Final = 50
_THRESHOLD_STEPS_PER_PX: Final = 64


class RecipePanel(QWidget):
    """Warp distance, centre, lattice; fit, domain, threshold and interpolation folded away.

    Signals
    -------
    edited(str, object)
        A field of the recipe and its new value, while the gesture lasts.
    rested
        The gesture's end.
    follow
        The face shall go by the photo's recipe again.
    """

    edited = Signal(str, object)
    rested = Signal()
    follow = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.percent = self._slider("percent", tr("&Warp distance"), _percent(), _percent_tip(), 1)
        self.lattice = self._slider("lattice", tr("&Lattice"), _lattice(), _lattice_tip(), 2)
        self.threshold = self._slider(
            "threshold_px", tr("Th&reshold"), _threshold(), _threshold_tip(), 0
        )
        self.centre = _CentreChoice()
        self.centre.chosen.connect(lambda number: self._choose("center", number))
        self.guard = QCheckBox(tr("&Guard: hold back what would fold"))
        self.guard.toggled.connect(lambda on: self._choose("guard", on))
        self.one_to_one, self.residual = muted_label(), muted_label()
        self.choices = {
            "fit": self._choice("fit", tr("Fit"), _fits()),
            "domain": self._choice("domain", tr("Domain"), _domains()),
            "interpolation": self._choice("interpolation", tr("Interpolation"), _kernels()),
        }
        self.fold = Fold(tr("Fit, thresh&old…"), self._details())
        self.owner = OwnerLine()
        self.owner.follow.connect(self.follow)
        column = column_of(self, spacing=3 * GRID_PX)
        column.addWidget(self.owner)
        column.addWidget(self.percent)
        self.gauge = NaturalnessGauge()
        readings = QVBoxLayout()
        readings.setSpacing(0)
        readings.addWidget(self.gauge)
        readings.addWidget(self.one_to_one)
        readings.addWidget(self.residual)
        column.addLayout(readings)
        column.addWidget(self.centre)
        column.addWidget(self.lattice)
        column.addWidget(self.fold)

    def show_state(self, state: State, chosen: int | None = None) -> None:
        """Show the recipe of the chosen face, or the photo's and what it means for the first."""
        recipe = state.recipe_of(chosen)
        self.owner.show_state(state, chosen)
        self.gauge.show_state(state)
        self.percent.show_value(recipe.percent)
        self.lattice.show_value(recipe.lattice)
        self.threshold.show_value(recipe.threshold_px)
        self.centre.show_number(int(recipe.center))
        for field, box in self.choices.items():
            with QSignalBlocker(box):
                box.setCurrentIndex(box.findData(getattr(recipe, field)))
        with QSignalBlocker(self.guard):
            self.guard.setChecked(recipe.guard)
        self._show_distances(state, chosen)

    def show_frame(self, frame: Frame) -> None:
        """Show whether the warp folds, and how far landmarks end from their targets."""
        if not frame.rendering.pairs:
            self.one_to_one.clear()
            self.residual.clear()
            return
        text, sound = _verdict(frame.rendering)
        self.one_to_one.setText(text)
        if self.one_to_one.property("warn") != (not sound):
            self.one_to_one.setProperty("warn", not sound)
            self.one_to_one.style().polish(self.one_to_one)
        left = frame.rendering.residual
        self.residual.setText(
            tr(
                "residual {mean:.2f} px, contour up to {contour:.2f} px",
                mean=left.mean_px * frame.scale,
                contour=left.contour_max_px * frame.scale,
            )
        )

    def abort(self) -> None:
        """Let go of every slider, as Escape does."""
        for slider in (self.percent, self.lattice, self.threshold):
            slider.slider.abort()

    def _show_distances(self, state: State, chosen: int | None) -> None:
        active = (index for index in range(len(state.faces)) if index not in state.off)
        index = next(active, None) if chosen is None else chosen
        if index is None:
            self.percent.note.clear()
            self.lattice.note.clear()
            return
        face, pairs = state.faces[index], state.pairs[index]
        moved = pairs.warp_distance_px
        spacing = fit.spacing_px(pairs, face.frame, state.recipe_of(index))
        self.percent.note.setText(tr("{px:.1f} px on average", px=moved))
        per_warp = f"{spacing / moved:.1f}" if moved > 0.0 else "∞"
        self.lattice.note.setText(
            tr(
                "{px:.0f} px · {r:.2f} × landmark spacing\n{w} × warp distance",  # noqa: RUF001
                px=spacing,
                r=spacing / face.frame.spacing_px,
                w=per_warp,
            )
        )

    def _slider(
        self, field: str, title: str, scale: Scale, tip: str, note_lines: int
    ) -> ValueSlider:
        slider = ValueSlider(title, scale, tip, note_lines)
        slider.edited.connect(lambda value: self.edited.emit(field, value))
        slider.rested.connect(self.rested)
        slider.reset.connect(lambda: self._choose(field, getattr(DEFAULT, field)))
        return slider

    def _choice(self, field: str, title: str, options: list[tuple[str, str]]) -> QComboBox:
        box = QComboBox()
        box.setAccessibleName(title)
        box.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
        box.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        for text, value in options:
            box.addItem(text, value)
        box.currentIndexChanged.connect(lambda: self._choose(field, box.currentData()))
        return box

    def _choose(self, field: str, value: object) -> None:
        self.edited.emit(field, value)
        self.rested.emit()

    def _details(self) -> QWidget:
        details = QWidget()
        form = QFormLayout()
        form.setSpacing(2 * GRID_PX)
        form.addRow(tr("F&it"), self.choices["fit"])
        form.addRow(muted_label(tr("These hold for the whole photo:")))
        form.addRow(tr("Do&main"), self.choices["domain"])
        form.addRow(tr("I&nterpolation"), self.choices["interpolation"])
        column = column_of(details, spacing=3 * GRID_PX)
        column.addLayout(form)
        column.addWidget(self.threshold)
        column.addWidget(self.guard)
        return details


class _CentreChoice(QWidget):
    """Four buttons in a row: the candidates of figure 7a."""

    chosen = Signal(int)

    def __init__(self) -> None:
        super().__init__()
        name = heading(tr("&Centre"))
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(GRID_PX)
        row.addWidget(name)
        row.addStretch()
        self._group = QButtonGroup(self)
        for number in range(1, 5):
            button = QToolButton()
            button.setText(str(number))
            button.setCheckable(True)
            button.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
            button.setProperty("segment", "true")
            button.setAccessibleName(tr("Centre {n}", n=number))
            button.setToolTip(_centre_tip(number))
            self._group.addButton(button, number)
            row.addWidget(button)
        name.setBuddy(self._group.button(1))
        self._group.idClicked.connect(self.chosen)

    def show_number(self, number: int) -> None:
        """Show which candidate is chosen."""
        self._group.button(number).setChecked(True)

    @property
    def buttons(self) -> list[QAbstractButton]:
        """The four buttons, candidate 1 first."""
        return self._group.buttons()


def _verdict(rendering: Rendering) -> tuple[str, bool]:
    """Return whether the warp is one-to-one, in words, and whether all is as asked for."""
    check, kept = rendering.one_to_one, min(rendering.shares)
    det = check.min_det
    if check.folds:
        cells = len(check.folded_cells)
        return tr("⚠ folds in {n} cells, J ≥ {det:.2f}", n=cells, det=det), False
    if not check.edges_proven:
        return tr("⚠ thin folds at the threshold can't be ruled out, J ≥ {det:.2f}", det=det), False
    if kept < 1.0:
        text = tr("⚠ held back to {n:.0f} % of the move, J ≥ {det:.2f}", n=100 * kept, det=det)
        return text, False
    return tr("one-to-one ✓ J ≥ {det:.2f}", det=det), True


def _percent() -> Scale:
    return Scale(
        0, 150, 10, lambda n: n / 10, lambda v: round(v * 10), lambda v: tr("{v:.1f} % of D", v=v)
    )


def _lattice() -> Scale:
    # Twice as coarse is as far to the right as twice as fine is to the left.
    return Scale(
        -2 * _PER_OCTAVE,
        2 * _PER_OCTAVE,
        10,
        lambda n: 2.0 ** (n / _PER_OCTAVE),
        lambda v: round(math.log2(v) * _PER_OCTAVE),
        lambda v: tr("R {v:.2f}", v=v),
    )


def _threshold() -> Scale:
    per_px = _THRESHOLD_STEPS_PER_PX
    return Scale(
        0, 2 * per_px, 8, lambda n: n / per_px, lambda v: round(v * per_px), _threshold_text
    )


def _threshold_text(value: float) -> str:
    lossless = value <= DEFAULT.threshold_px
    return tr("{v:.2f} px, lossless", v=value) if lossless else tr("{v:.2f} px", v=value)


def _percent_tip() -> str:
    return tr("How far landmarks move, in % of D, their distance to the centre (section 3.2)")


def _lattice_tip() -> str:
    return tr("Spacing of the control lattice: small is local, large is smooth (section 3.3)")


def _threshold_tip() -> str:
    return tr("Pixels that would move less stay as they are (section 4.2)")


def _centre_tip(number: int) -> str:
    shares = ("10 : 0", "8 : 2", "6 : 4", "4.7 : 5.3")
    return tr("Distance to the eyes : to the mouth = {share} (figure 7a)", share=shares[number - 1])


def _fits() -> list[tuple[str, str]]:
    return [
        (tr("Exact: on every target"), "exact"),
        (tr("Approximation: the paper's"), "approximation"),
        (tr("Multilevel: refined steps"), "multilevel"),
    ]


def _domains() -> list[tuple[str, str]]:
    return [
        (tr("Whole image"), "image"),
        (tr("Control points"), "control-points"),
        (tr("Threshold"), "threshold"),
    ]


def _kernels() -> list[tuple[str, str]]:
    return [
        (tr("Bilinear"), "bilinear"),
        (tr("Cubic"), "cubic"),
        (tr("Lanczos 4"), "lanczos4"),
    ]
