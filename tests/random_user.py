"""A user who edits at random, through the editor's own controllers."""

from __future__ import annotations

from collections import Counter

import numpy as np
from kogao_app.canvas.handles import position
from kogao_app.editor import Editor
from kogao_app.view_state import Handle

from kogao_core.background.find import BackgroundFinder, held_of
from kogao_core.faces.face import Face
from kogao_core.pipeline import render

_MOST_STROKES = 8


class RandomUser:
    """Moves sliders, drags points, paints, switches modes, undoes and redoes.

    The editor shows a photo with a face; `by_hand` is placed in manual mode.
    """

    def __init__(self, editor: Editor, by_hand: Face, seed: int) -> None:
        self._editor, self._by_hand = editor, by_hand
        self._canvas = editor.window.canvas
        self._rng = np.random.default_rng(seed)
        self.counts: Counter[str] = Counter()

    def edit(self) -> None:
        """Make one edit: a gesture with its previews, or a step through the history."""
        kinds, shares = zip(
            *((self._slide, 0.30), (self._drag, 0.27), (self._nudge, 0.05), (self._step, 0.21)),
            *((self._paint, 0.10), (self._switch_mode, 0.04), (self._choose, 0.03)),
            strict=True,
        )
        kind = kinds[self._rng.choice(len(kinds), p=shares)]
        self.counts[kind.__name__] += 1
        kind()

    @property
    def _state(self):
        return self._editor.document.state

    def _near(self, place: np.ndarray, reach_px: float) -> np.ndarray:
        return place + self._rng.uniform(-reach_px, reach_px, 2)

    def _slide(self) -> None:
        field, low, high = (("percent", 0.0, 9.0), ("lattice", 0.4, 3.0))[self._rng.integers(2)]
        for _ in range(4):
            self._editor.recipe.set_field(field, round(float(self._rng.uniform(low, high)), 2))
        if self._rng.random() < 0.1:
            self._editor.points.abort()
        self._editor.document.commit()

    def _choose(self) -> None:
        self._editor.recipe.choose(0 if self._state.faces and self._rng.random() < 0.5 else None)

    def _grab(self) -> Handle | None:
        """Press a handle where it is, if there is one."""
        if not self._state.faces:
            return None
        kind = ("outline", "target", "eye")[self._rng.integers(3)]
        most = 4 if kind == "eye" else len(self._state.faces[0].outline)
        handle = Handle(kind, 0, int(self._rng.integers(most)))
        self._canvas.begin("points", handle, position(self._state, handle))
        return handle

    def _drag(self) -> None:
        handle = self._grab()
        if handle is None:
            return
        place = position(self._state, handle)
        for _ in range(4):
            self._canvas.move(self._near(place, 0.004 * self._editor.document.image.width))
        self._canvas.end(place)
        if handle.kind == "target" and self._rng.random() < 0.5:
            self._editor.points.make_automatic()

    def _nudge(self) -> None:
        handle = self._grab()
        if handle is not None:
            self._canvas.end(position(self._state, handle))
            self._editor.points.nudge(*self._rng.integers(-3, 4, 2).tolist())
            self._editor.document.commit()

    def _step(self) -> None:
        history = self._editor.history
        step = history.undo if self._rng.random() < 0.67 else history.redo
        for _ in range(self._rng.integers(1, 4)):
            step()

    def _paint(self) -> None:
        """Paint a stroke with a tool, or clear the strokes where there are many."""
        protecting, pushing = self._editor.protect, self._editor.push
        tool = ("brush", "line", "eraser", "push", "restore")[self._rng.integers(5)]
        painter, strokes = protecting, self._state.protection.strokes
        if tool in ("push", "restore"):
            painter, strokes = pushing, self._state.brushwork.strokes
        if len(strokes) > _MOST_STROKES:
            painter.clear()
        protecting.take(tool)
        image = self._editor.document.image
        place = self._rng.uniform((0, 0), (image.width, image.height))
        straight = painter is protecting and bool(self._rng.random() < 0.3)
        self._canvas.begin(tool, None, place)
        for _ in range(4):
            self._canvas.move(self._near(place, 0.05 * image.width), straight=straight)
        self._canvas.end(place)
        protecting.take("points")

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
