"""Editing of recipes, for the photo and for single faces, with copy and paste."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Collection, Mapping

from PySide6.QtCore import Signal
from PySide6.QtGui import QGuiApplication

from kogao_core.recipe.recipe import Recipe

from ...canvas.tools.gesture import Gesture, PointerEvent
from ...i18n import tr
from ...view_state import Handle
from ..feature import Context, Feature
from ..points import Points
from . import fields
from .panel import RecipePanel

_LONGEST_TEXT = 10_000


class RecipeEditing(Feature):
    """Edits the recipe of the selected faces, or of the photo without a selection."""

    name = "recipe"
    # (): a control has changed a field, also during a gesture.
    moved = Signal()

    def __init__(self, context: Context, points: Points) -> None:
        super().__init__(context)
        self._mode = self.document.state.mode
        self.panel: RecipePanel = RecipePanel(self.set_field, self.document.commit, self.say)
        self.panel.owner.button.clicked.connect(self.follow_photo)
        self.document.aborted.connect(self.panel.abort)
        for eye in self.panel.eyes.values():
            self.document.opened.connect(eye.forget)
        points.took.connect(self._take)
        points.center_taken.connect(self._take_center)
        points.escaped.connect(lambda: self.choose(None))
        self.window.canvas.tools["shape"] = self._shape
        self.window.canvas.picked.connect(self.choose)
        self.window.arranged.connect(lambda workspace: self._show_words(workspace.plain))
        self.view.watch(self._show, "face", "also")
        self.view.watch(self._show_gauge, "face", "frame")
        self.view.watch(self._show_frame, "frame")
        self.bind("copy-settings", self.copy)
        self.bind("paste-settings", self.paste)
        self.bind("follow-photo", self.follow_photo)
        self.bind("more-settings", self.panel.toggle_more)
        self.enable_with_photo(self.panel.allow)
        self._told: tuple[object, ...] = ()
        self.document.watch(self._follow)

    def begin_with(self, recipe: Recipe) -> None:
        """Set the recipe for new photos and the default values of sliders."""
        self.document.first_recipe = recipe
        self.panel.show_first(recipe)

    def choose(self, face: int | None, also: Collection[int] = ()) -> None:
        """Select a face for editing, with further faces; None selects the photo's settings."""
        others = frozenset(also) - {face}
        if (face, others) != (self.view.face, self.view.also):
            self.document.commit()
            changes: dict[str, object] = {"face": face, "also": others}
            selected = self.view.selected
            if face is not None and selected is not None and selected.face != face:
                changes |= {"selected": None, "hovered": None}
            self.view.set(**changes)

    def set_field(self, field: str, value: object) -> None:
        """Preview a new value of a field; an unchanged value starts no gesture."""
        now = self.document.state.recipe_of(self.view.face)
        changes = _along(field, value)
        same = all(getattr(now, name) == it for name, it in changes.items())
        if same and not self.document.in_gesture and not self.view.also:
            # No undo step, but clear a message about a refused value.
            self.window.bar.move_on()
            return
        state = self.document.state
        for face in (self.view.face, *self.view.also):
            state = state.with_choices(face, **changes)
        before = self.document.committed.recipe_of(self.view.face)
        self.document.preview(state, fields.title(field), self._change(before, changes))
        self.moved.emit()

    def _change(self, before: Recipe, changes: Mapping[str, object]) -> str:
        """Return the text of an undo step: the first change."""
        changed = [name for name, value in changes.items() if getattr(before, name) != value]
        name = changed[0] if changed else next(iter(changes))
        return fields.change(name, getattr(before, name), changes[name], plain=self.panel.plain)

    def follow_photo(self) -> None:
        """Remove the separate recipes of the selected faces; without a selection, of all faces."""
        state, chosen = self.document.state, {self.view.face, *self.view.also}
        own = {i for i, face in enumerate(state.faces) if face.recipe and chosen & {None, i}}
        for index in own:
            state = state.with_face(index, dataclasses.replace(state.faces[index], recipe=None))
        if own:
            self.document.step(state, tr("Use the photo's settings"))

    def use(self, recipe: Recipe, text: str) -> None:
        """Apply a full recipe to the photo or the selected faces; skip an unchanged recipe."""
        state, chosen = self.document.state, self.view.face
        now = state.recipe if chosen is None else state.faces[chosen].recipe
        if recipe == now and not self.view.also:
            return
        if chosen is None:
            state = dataclasses.replace(state, recipe=recipe)
        else:
            for face in (chosen, *self.view.also):
                own = dataclasses.replace(state.faces[face], recipe=recipe)
                state = state.with_face(face, own)
        self.document.step(state, text)

    def copy(self) -> None:
        """Copy the settings to the clipboard as JSON text."""
        self.window.bar.clear()
        recipe = self.document.state.recipe_of(self.view.face)
        QGuiApplication.clipboard().setText(json.dumps(recipe.to_dict(), indent=1))
        self.did.emit(tr("Settings copied"))

    def paste(self) -> None:
        """Apply the settings from the clipboard."""
        text = QGuiApplication.clipboard().text()
        try:
            recipe = Recipe.from_dict(json.loads(text[:_LONGEST_TEXT]))
        # The clipboard may contain any text, such as deeply nested brackets.
        except (ValueError, TypeError, RecursionError):
            self.say(tr("The clipboard holds no settings; copy some first."))
            return
        self.use(recipe, tr("Paste settings"))

    def _take(self, face: int) -> None:
        # If single faces are being edited, select this face.
        if self.view.face is not None:
            self.choose(face)

    def _shape(self, _: Handle | None, event: PointerEvent) -> Gesture:
        """Drag a curve on the face: the slider of its part follows."""
        curve, row = self.window.canvas.curve_at(event.point_px) or (None, 0)
        if curve is None:
            return
        start, step, field = event.point_px, curve.steps_px[row], curve.field
        first = getattr(self.document.state.recipe_of(self.view.face), field)
        self.view.set(shaping=field)
        slider = self.panel.sliders[field].slider
        event = yield
        while not event.released:
            value = first + (event.point_px - start) @ step / (step @ step)
            self.set_field(field, slider.scale.value(slider.bounded(value)))
            event = yield
        self.document.commit()

    def _take_center(self, face: int, number: int) -> None:
        own = self.document.state.faces[face].recipe is not None or self.view.face == face
        changes, before = _along("center", number), self.document.state.recipe_of(face)
        state = self.document.state.with_choices(face if own else None, **changes)
        self.document.step(state, fields.title("center"), self._change(before, changes))

    def _follow(self) -> None:
        chosen, state = self.view.face, self.document.state
        # Face numbers differ between modes.
        gone = state.mode != self._mode or (chosen is not None and chosen >= len(state.faces))
        self._mode = state.mode
        if gone or any(face >= len(state.faces) for face in self.view.also):
            self.view.set(face=None, also=frozenset())
        now = state.faces, state.off, state.recipe
        if now != self._told:
            self._told = now
            self._show()
        self._mark_readings()

    def _show(self) -> None:
        self.panel.show_state(self.document.state, self.view.face, self.view.also)

    def _show_gauge(self) -> None:
        self.panel.gauge.show_frame(self.view.frame, self.document.state, self.view.face)

    def _show_words(self, plain: bool) -> None:
        self.panel.show_words(plain=plain)
        self._show()
        self._show_frame()

    def _mark_readings(self) -> None:
        self.panel.mark_readings(final=self.live.is_final(self.view.frame))

    def _show_frame(self) -> None:
        self.panel.show_frame(self.view.frame)
        self._mark_readings()


def _along(field: str, value: object) -> dict[str, object]:
    """Return a change with the scope it needs: a centre is of the face alone."""
    return ({"scope": "face"} if field == "center" else {}) | {field: value}
