"""A user who edits at random, through the editor's own controllers."""

from __future__ import annotations

import numpy as np
from kogao_app.canvas.handles import position
from kogao_app.editor import Editor
from kogao_app.view_state import Handle

from kogao_core.background.find import BackgroundFinder, held_of
from kogao_core.faces.face import Face
from kogao_core.pipeline import render

_MOST_STROKES = 8


class RandomUser:
    """Moves sliders, drags points, protects, switches modes, undoes and redoes.

    The editor shows a photo with a face; `by_hand` is placed in manual mode.
    """

    def __init__(self, editor: Editor, by_hand: Face, seed: int) -> None:
        self._editor, self._by_hand = editor, by_hand
        self._rng = np.random.default_rng(seed)
        self._kinds = (
            *((self._slide, 0.30), (self._drag, 0.27), (self._nudge, 0.05), (self._undo, 0.14)),
            *((self._redo, 0.07), (self._protect, 0.05), (self._push, 0.02), (self._erase, 0.03)),
            *((self._switch_mode, 0.04), (self._choose, 0.03)),
        )
        self.counts: dict[str, int] = {}

    def edit(self) -> None:
        """Make one edit: a gesture with its previews, or a step through the history."""
        shares = [share for _, share in self._kinds]
        which = self._rng.choice(len(shares), p=np.divide(shares, sum(shares)))
        kind = self._kinds[which][0]
        name = kind.__name__.strip("_")
        self.counts[name] = self.counts.get(name, 0) + 1
        kind()

    @property
    def _state(self):
        return self._editor.document.state

    def _between(self, low: float, high: float) -> float:
        return float(self._rng.uniform(low, high))

    def _slide(self) -> None:
        field, low, high = (("percent", 0.0, 9.0), ("lattice", 0.4, 3.0))[self._rng.integers(2)]
        for _ in range(4):
            self._editor.recipe.set_field(field, round(self._between(low, high), 2))
        if self._rng.random() < 0.1:
            self._editor.points.abort()
        self._editor.document.commit()

    def _choose(self) -> None:
        self._editor.recipe.choose(0 if self._state.faces and self._rng.random() < 0.5 else None)

    def _handle(self) -> Handle | None:
        if not self._state.faces:
            return None
        kind = ("outline", "target", "eye")[self._rng.integers(3)]
        most = 4 if kind == "eye" else len(self._state.faces[0].outline)
        return Handle(kind, 0, int(self._rng.integers(most)))

    def _drag(self) -> None:
        handle, editing = self._handle(), self._editor.points
        if handle is None:
            return
        x, y = position(self._state, handle)
        step = 0.004 * self._editor.document.image.width
        editing.grab(handle, x, y)
        for _ in range(4):
            editing.drag(x + self._between(-step, step), y + self._between(-step, step))
        editing.release()
        if handle.kind == "target" and self._rng.random() < 0.5:
            editing.make_automatic()

    def _nudge(self) -> None:
        handle, editing = self._handle(), self._editor.points
        if handle is not None:
            x, y = position(self._state, handle)
            editing.grab(handle, x, y)
            editing.release()
            editing.nudge(*self._rng.integers(-3, 4, 2).tolist())
            self._editor.document.commit()

    def _undo(self) -> None:
        for _ in range(self._rng.integers(1, 4)):
            self._editor.history.undo()

    def _redo(self) -> None:
        for _ in range(self._rng.integers(1, 4)):
            self._editor.history.redo()

    def _stroke(self) -> None:
        protecting, image = self._editor.protect, self._editor.document.image
        x, y = self._between(0, image.width), self._between(0, image.height)
        protecting.begin(x, y)
        for _ in range(4):
            x, y = x + self._between(-0.05, 0.05) * image.width, y + self._between(0, 0.05) * y
            protecting.extend(x, y, self._rng.random() < 0.3)
        protecting.end()

    def _protect(self) -> None:
        protecting = self._editor.protect
        if len(self._state.protection.strokes) > _MOST_STROKES:
            protecting.clear()
        protecting.take(("brush", "line")[self._rng.integers(2)])
        self._stroke()
        protecting.take("points")

    def _push(self) -> None:
        pushing, protecting = self._editor.push, self._editor.protect
        if len(self._state.brushwork.strokes) > _MOST_STROKES:
            pushing.clear()
        protecting.take(("push", "restore")[self._rng.integers(2)])
        x, y = self._between(0, self._editor.document.image.width), self._between(0, 500)
        pushing.begin(x, y)
        pushing.extend(x + self._between(-20, 20), y + self._between(-20, 20))
        pushing.end()
        protecting.take("points")

    def _erase(self) -> None:
        self._editor.protect.take("eraser")
        self._stroke()
        self._editor.protect.take("points")

    def _switch_mode(self) -> None:
        other = "manual" if self._state.mode == "automatic" else "automatic"
        self._editor.manual.switch(other)
        if not self._state.faces:
            self._editor.faces.place(self._by_hand)
            self._editor.faces.end_placing()


def equals_a_fresh_render(editor: Editor) -> bool:
    """Tell whether the picture on screen is what a fresh render of the state gives, to the bit."""
    state, photo = editor.document.state, editor.document.pyramid.levels[0]
    held = held_of(editor.document.photo.pixels, state.done, BackgroundFinder())
    fresh = render(
        *(photo, state.active, state.recipe),
        protection=state.protection,
        held=held,
        brushwork=state.brushwork,
    ).pixels
    return np.array_equal(editor.view.frame.rendering.pixels, fresh)
