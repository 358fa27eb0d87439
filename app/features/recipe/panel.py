"""The panel with sliders and choices of the recipe, and readings of the result."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from functools import partial
from typing import Any, Final

from PySide6.QtCore import QSignalBlocker, Qt
from PySide6.QtWidgets import QCheckBox, QLabel, QSizePolicy, QVBoxLayout, QWidget

from kogao_core.additions import fit
from kogao_core.recipe.recipe import SETTINGS, SHAPE, Recipe
from kogao_core.recipe.settings import Setting

from ...document import DEFAULT, State
from ...i18n import tr, translated
from ...theme import GRID_PX
from ...view_state import RenderedFrame
from ...widgets.controls import ChoiceBox, Eye, Fold, WarningLabel, column_of, muted_label, row_of
from ...widgets.sliders import ValueSlider
from . import fields
from .fields import CenterChoice, LensChoice, OwnerLine, ScopeChoice
from .gauge import LINES, NaturalnessGauge

_LINES: Final = 2  # lines of an exact reading
_NONE: Final = "–"  # noqa: RUF001
# Fields with a fixed position; all other fields are in the last fold.
_NEEDED: Final = frozenset(setting.needs for setting in SETTINGS.values())
# The parts of a face that are changed most; the rest is in a second fold.
_FIRST: Final = ("width", "length", "jaw_width", "chin_length", "cheeks_width")
_REST: Final = tuple(name for name in SHAPE if name not in _FIRST)
_PLACED: Final = frozenset({"percent", "scope", "center", "lattice", "lens", "lens_amount", *SHAPE})


class RecipePanel(QWidget):
    """Warp distance, scope, lens and shape; centre, lattice, fit, threshold and more.

    In everyday words, only the amount and the naturalness gauge show; the rest is folded.
    """

    def __init__(
        self,
        edit: Callable[[str, object], object],
        commit: Callable[[], object],
        refuse: Callable[[str], object],
    ) -> None:
        super().__init__()
        self._edit, self._commit, self._refuse = edit, commit, refuse
        self._first = DEFAULT
        self.sliders: dict[str, ValueSlider] = {}
        self.choices: dict[str, ChoiceBox] = {}
        self.switches: dict[str, QCheckBox] = {}
        self.controls: dict[str, QWidget] = {}  # by field; enabled while the field has an effect
        self._allowed, self._recipe = False, DEFAULT
        self._is_new = True  # True: show every field at the next state
        self.percent = self._slider("percent", 1, lead=True)
        self.lattice = self._slider("lattice", 2)
        self.scope = ScopeChoice()
        self.scope.chosen.connect(lambda n: self._choose("scope", self.scope.names[n - 1]))
        self.lens = LensChoice()
        self.lens.chosen.connect(lambda lens: self._choose("lens", lens))
        self.lens_amount = self._slider("lens_amount")
        self.centre = CenterChoice()
        self.centre.chosen.connect(lambda number: self._choose("center", number))
        self.controls |= {"lens": self.lens, "scope": self.scope}
        self.one_to_one, self.residual = WarningLabel(wraps=True), muted_label(wraps=True)
        # Keep the place of empty readings, so that the controls below don't move.
        for label in (self.one_to_one, self.residual):
            label.setMinimumHeight(_LINES * label.fontMetrics().height())
            label.setToolTip(tr("≈: until the picture is there in full"))
        self.edge_note = muted_label(wraps=True)
        self._readings = "", ""
        self._on: list[int] = []
        self._lens_counts = False
        shape, sides = QWidget(), QWidget()
        column_of(shape, *map(self._slider, _FIRST), spacing=0)
        column_of(sides, *map(self._slider, _REST), spacing=0)
        self._chosen: int | None = None  # the face whose recipe is shown
        self.eyes = {field: self._eye(field) for field in SHAPE}
        self.shape = Fold(tr("Face shape"), shape, "shape")
        self.sides = Fold(tr("Forehead and sides"), sides, "sides")
        self.fold = Fold(tr("Fit, qualit&y…"), self._details(), "fit")
        self.plain = False
        self._fine = QWidget()
        self.more = Fold(tr("More"), self._fine, "more")
        self.more.button.toggled.connect(self._show_lens)
        self.owner = OwnerLine()
        self.gauge = NaturalnessGauge()
        self._lay_out()
        self.show_words(plain=False)
        self.show_first(DEFAULT)

    def _lay_out(self) -> None:
        readings = QVBoxLayout()
        readings.setSpacing(0)
        readings.addWidget(self.gauge)
        readings.addWidget(self.one_to_one)
        readings.addWidget(self.residual)
        choices = QVBoxLayout()
        choices.setSpacing(2 * GRID_PX)
        choices.addWidget(self.scope)
        choices.addWidget(self.centre)
        column_of(
            self,
            self.owner,
            self.percent,
            readings,
            choices,
            self.shape,
            self.sides,
            self.more,
            # Last: these come and go from photo to photo.
            self.lens,
            self.lens_amount,
            self.edge_note,
            spacing=3 * GRID_PX,
        )
        fine = self.lattice, self.fold
        column_of(self._fine, *fine, spacing=3 * GRID_PX)

    def show_first(self, recipe: Recipe) -> None:
        """Set the default values of the sliders from a recipe."""
        self._first = recipe
        for field, slider in self.sliders.items():
            slider.show_first(getattr(recipe, field))

    def allow(self, allowed: bool) -> None:
        """Enable the controls of fields with an effect, or disable all without a photo."""
        self._allowed = allowed
        self._enable()

    def _enable(self) -> None:
        for field, control in self.controls.items():
            control.setEnabled(self._allowed and SETTINGS[field].counts(self._recipe))
        self.centre.setEnabled(self._allowed)

    def show_words(self, *, plain: bool) -> None:
        """Label the controls in everyday words, or in the paper's terms and units."""
        self.plain, self._is_new = plain, True
        for field in ("percent", "lattice"):
            self.sliders[field].rename(*fields.wording(field, plain=plain))
        self.more.flatten(not plain)
        self._show_lens()
        for reading in (self.percent.note, self.lattice.note, self.residual):
            reading.setHidden(plain)
        lines = LINES if plain else _LINES
        self.one_to_one.setMinimumHeight(lines * self.one_to_one.fontMetrics().height())
        self.clear_readings()

    def toggle_more(self) -> None:
        """Unfold the advanced settings and focus the first, or fold the settings again."""
        title = self.more.button
        if not title.isHidden():
            title.toggle()
        shown = title.isHidden() or title.isChecked()
        (self.lattice.slider if shown else self.percent.slider).setFocus()

    def show_state(
        self, state: State, chosen: int | None = None, also: Collection[int] = ()
    ) -> None:
        """Show the recipe of the selected face, or of the photo."""
        recipe = state.recipe_of(chosen)
        self._on = [index for index in range(len(state.faces)) if index not in state.off]
        self.owner.show_state(state, chosen, also)
        before, self._recipe = self._recipe, recipe
        values = {field: getattr(recipe, field) for field in SETTINGS}
        changed = [n for n, v in values.items() if self._is_new or v != getattr(before, n)]
        for field in changed:
            self._show_field(field, values[field])
        for field in self.eyes if chosen != self._chosen else self.eyes.keys() & changed:
            self.eyes[field].show_value(values[field], chosen, is_off=not values[field])
        self._chosen = chosen
        self._lens_counts = self.lens.show_state(state, chosen)
        self._show_lens()
        if self._is_new or not _NEEDED.isdisjoint(changed):
            self._enable()
        self._is_new = False
        self._show_distances(state, chosen)

    def _show_field(self, field: str, value: Any) -> None:
        if field in self.sliders:
            self.sliders[field].show_value(value)
            for fold, names in ((self.shape, _FIRST), (self.sides, _REST)):
                if field in names:
                    fold.mark(any(getattr(self._recipe, name) for name in names))
        elif field in self.choices:
            box = self.choices[field]
            with QSignalBlocker(box):
                box.setCurrentIndex(box.findData(value))
        elif field in self.switches:
            with QSignalBlocker(self.switches[field]):
                self.switches[field].setChecked(value)
        elif field in ("center", "scope"):
            scope = self._recipe.scope
            self.scope.show_number(1 + self.scope.names.index(scope))
            self.centre.show_center(self._recipe.center, used=scope == "face", plain=self.plain)
        else:
            self.lens_amount.setHidden(value == "off")

    def show_frame(self, frame: RenderedFrame | None) -> None:
        """Show a frame's folds, what the guard kept of each face, and the residual."""
        if frame is None or not frame.rendering.pairs:
            self.clear_readings()
            return
        rendering = frame.rendering
        on = self._on if len(self._on) == len(rendering.shares) else range(len(rendering.shares))
        verdict, sound = _warning(frame, on) if self.plain else _verdict(frame)
        self.one_to_one.warn(not sound)
        self._note_edge(frame.rendering.note)
        left = frame.figures.residual
        residual = tr(
            "achieved {percent} % of D\nresidual {mean:.2f} px, contour up to {contour:.2f} px",
            percent=_range(frame.figures.achieved),
            mean=left.mean_px * frame.scale,
            contour=left.contour_max_px * frame.scale,
        )
        self._readings = verdict, residual

    def mark_readings(self, *, final: bool) -> None:
        """Show the readings as exact, or as approximate until the final frame."""
        for label, text in zip((self.one_to_one, self.residual), self._readings, strict=True):
            label.setText(text if final or not text else f"≈ {text}")
        warned = self.plain and bool(self._readings[0])
        self.one_to_one.setVisible(warned or not self.plain)
        # The warning takes the place of the figure, which holds for the full amount.
        self.gauge.seen.setHidden(warned)

    def clear_readings(self) -> None:
        """Clear the readings: no frame is shown."""
        self._readings = "", ""
        self._note_edge("")
        self.mark_readings(final=True)

    def _show_lens(self) -> None:
        self.lens.setVisible(self._lens_counts or not self.plain or self.more.button.isChecked())

    def _note_edge(self, note: str) -> None:
        self.edge_note.setText(translated(note))
        self.edge_note.setVisible(bool(note))

    def abort(self) -> None:
        """End the drags of all sliders, as Escape does."""
        for slider in self.sliders.values():
            slider.slider.abort()

    def _show_distances(self, state: State, chosen: int | None) -> None:
        if self.plain:
            return  # the notes are hidden
        active = (index for index in range(len(state.faces)) if index not in state.off)
        index = next(active, None) if chosen is None else chosen
        if index is None:
            self.percent.note.clear()
            self.lattice.note.clear()
            return
        face, pairs = state.faces[index], state.pairs[index]
        moved = pairs.warp_distance_px
        spacing = fit.spacing_px(pairs, face.anchor, state.recipe_of(index))
        self.percent.note.setText(tr("warp distance: {px:.1f} px on average", px=moved))
        per_warp = f"{spacing / moved:.1f}" if moved > 0.0 else _NONE
        self.lattice.note.setText(
            tr(
                "lattice {px:.0f} px · {r:.2f} × landmark spacing\n{w} × warp distance",  # noqa: RUF001
                px=spacing,
                r=spacing / face.anchor.spacing_px,
                w=per_warp,
            )
        )

    def _slider(self, field: str, note_lines: int = 0, *, lead: bool = False) -> ValueSlider:
        name, scale, tip = fields.label(field), fields.scale(field), fields.tip(field)
        slider = ValueSlider(name, scale, tip, note_lines, lead=lead)
        slider.edited.connect(partial(self._edit, field))
        slider.rested.connect(self._commit)
        slider.refused.connect(self._refuse)
        slider.reset.connect(lambda: self._choose(field, getattr(self._first, field)))
        self.sliders[field] = self.controls[field] = slider
        return slider

    def _eye(self, field: str) -> Eye:
        eye = self.sliders[field].add_eye()
        eye.switched.connect(lambda value: self._choose(field, value))
        return eye

    def _choice(self, field: str) -> QWidget:
        box, label = ChoiceBox(), QLabel(fields.label(field))
        box.setAccessibleName(translated(SETTINGS[field].title))
        box.setToolTip(fields.tip(field))
        box.setSizeAdjustPolicy(ChoiceBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
        box.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        for place, (text, tip, value) in enumerate(fields.options(field)):
            box.addItem(text, value)
            box.setItemData(place, tip, Qt.ItemDataRole.ToolTipRole)
        box.currentIndexChanged.connect(lambda: self._choose(field, box.currentData()))
        label.setBuddy(box)
        label.setToolTip(box.toolTip())
        row = QWidget()
        column_of(row, row_of(label, box))
        self.choices[field], self.controls[field] = box, row
        return row

    def _switch(self, field: str) -> QCheckBox:
        switch = QCheckBox(fields.label(field))
        switch.setToolTip(fields.tip(field))
        switch.toggled.connect(lambda on: self._choose(field, on))
        self.switches[field] = self.controls[field] = switch
        return switch

    def _choose(self, field: str, value: object) -> None:
        self._edit(field, value)
        self._commit()

    def _details(self) -> QWidget:
        details = QWidget()
        rest = [setting for name, setting in SETTINGS.items() if name not in _PLACED]
        own = [self._control(setting) for setting in rest if not setting.per_photo]
        note = muted_label(tr("These hold for the whole photo:"))
        shared = [self._control(setting) for setting in rest if setting.per_photo]
        column_of(details, *own, note, *shared, spacing=2 * GRID_PX)
        return details

    def _control(self, setting: Setting) -> QWidget:
        """Return the control for a field: slider, combo box or switch."""
        if setting.within is not None:
            return self._slider(setting.name)
        return (self._choice if setting.alternatives else self._switch)(setting.name)


def _range(percents: Sequence[float]) -> str:
    """Return the range of the values as text; a single number if all are equal."""
    low, high = f"{min(percents):.2f}", f"{max(percents):.2f}"
    return low if low == high else f"{low}\N{EN DASH}{high}"


def _warning(frame: RenderedFrame, on: Sequence[int]) -> tuple[str, bool]:
    """Return a warning in everyday words (empty if fine), and whether the result is as requested.

    `on` contains the indices of the rendered faces.
    """
    rendering = frame.rendering
    if _verdict(frame)[1]:
        return "", True
    if frame.figures.one_to_one.folds:
        return tr("⚠ The picture folds over itself; choose a smaller amount."), False
    kept = min(rendering.shares)
    held = [str(on[k] + 1) for k, share in enumerate(rendering.shares) if share < 1.0]
    if kept < 1.0 and len(rendering.shares) > 1:
        return tr(
            "⚠ Reduced in faces {numbers}, down to {percent:.0f} %.",
            numbers=", ".join(held),
            percent=100 * kept,
        ), False
    if kept < 1.0:
        return tr("⚠ Limited to {n:.0f} %: more would squeeze", n=100 * kept), False
    return tr("⚠ The picture may fold in small places; choose a smaller amount."), False


def _verdict(frame: RenderedFrame) -> tuple[str, bool]:
    """Return whether the warp is one-to-one, as text, and whether the result is as requested."""
    rendering, check = frame.rendering, frame.figures.one_to_one
    kept = min(rendering.shares)
    det = check.min_det
    if check.folds:
        cells = len(check.folded_cells)
        return tr("⚠ folds in {n} cells, sampled J ≥ {det:.2f}", n=cells, det=det), False
    if not check.edges_proven:
        return tr("⚠ thin folds at the threshold possible\nsampled J ≥ {det:.2f}", det=det), False
    if not check.settled:
        return tr("⚠ small folds possible\nsampled J ≥ {det:.2f}", det=det), False
    held = []
    if kept < 1.0:
        point = rendering.limited_points[rendering.shares.index(kept)]
        held.append(
            tr(
                "⚠ reduced to {n:.0f} % near point {point}, sampled J ≥ {det:.2f}",
                n=100 * kept,
                point=point,
                det=det,
            )
        )
    if rendering.threshold_px < rendering.recipe.threshold_px:
        held.append(tr("⚠ threshold not used: its edge could have folded"))
    if held:
        return "\n".join(held), False
    return tr("one-to-one ✓ sampled J ≥ {det:.2f}", det=det), True
