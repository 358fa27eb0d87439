"""Where pictures are rendered to: always the buffer that isn't on screen."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Sequence
from dataclasses import dataclass

from kogao_core.face import Face
from kogao_core.geometry import Affine, Box
from kogao_core.pipeline import Rendering, render
from kogao_core.protection import NOTHING, Protection
from kogao_core.recipe import Recipe
from kogao_core.warp import Canvas

from .document import State
from .pyramid import Pyramid, Rgb8, to_photo


@dataclass(frozen=True, eq=False)
class Frame:
    """One picture for the screen.

    Parameters
    ----------
    revision : int
        Which state of the document it shows; larger is newer.
    rendering : Rendering
        In px of its own: a level of the photo, or a part of one.
    levels : sequence of uint8 arrays
        The picture and, for a whole photo, its halvings, in the screen's colours.
    to_photo : Affine
        From px of `rendering` to px of the photo.
    took_ms : float
        Time from the start of the job to the finished picture.
    whole : bool
        True for the whole photo by the recipe's own kernel, False for a gesture's preview.
    """

    revision: int
    rendering: Rendering
    levels: Sequence[Rgb8]
    to_photo: Affine
    took_ms: float
    whole: bool

    @property
    def scale(self) -> float:
        """Photo px per px of the rendering."""
        return self.to_photo.scale


@dataclass(frozen=True, slots=True)
class View:
    """The part of the photo on screen: a box, in px of a pyramid level."""

    level: int
    box: Box


@dataclass(frozen=True, slots=True, eq=False)
class _Job:
    """What to render, in px of the picture that it is rendered from."""

    faces: Sequence[Face]
    recipe: Recipe
    protection: Protection


class _Buffer:
    """A canvas over one picture, and the result with its halvings."""

    def __init__(self, source: Pyramid) -> None:
        self._canvas = Canvas(source.levels[0])
        self._result = source.over(self._canvas.pixels)

    def render(self, job: _Job) -> tuple[Rendering, Sequence[Rgb8]]:
        canvas, protection = self._canvas, job.protection
        rendering = render(
            canvas.source, job.faces, job.recipe, protection=protection, canvas=canvas
        )
        self._result.refresh(rendering.changed)
        return rendering, self._result.shown


class _Pair:
    """Two buffers over one picture: one on screen, one to write to.

    A buffer in which a rendering failed is given up: who knows how far its halvings had come.
    """

    def __init__(self, source: Pyramid) -> None:
        self._source = source
        self._front: _Buffer | None = None
        self._back: _Buffer | None = None

    def render(self, job: _Job) -> tuple[Rendering, Sequence[Rgb8]]:
        back, self._back = self._back or _Buffer(self._source), None
        result = back.render(job)
        self._back = back
        return result

    def swap(self) -> None:
        self._front, self._back = self._back, self._front


class FullSurface:
    """Renders the whole photo at full resolution, as it would be saved.

    `render` belongs to a worker, `shown` to the GUI thread while no worker runs.

    Parameters
    ----------
    photo : Pyramid
        The photo as 8-bit RGB.
    """

    def __init__(self, photo: Pyramid) -> None:
        self._pair = _Pair(photo)

    def render(self, revision: int, state: State) -> Frame:
        """Return a frame in the buffer off screen."""
        start = time.perf_counter()
        rendering, levels = self._pair.render(_Job(state.active, state.recipe, state.protection))
        return Frame(revision, rendering, levels, to_photo(0), _since_ms(start), whole=True)

    def shown(self) -> None:
        """Note that the last frame has gone on screen."""
        self._pair.swap()


class PreviewSurface:
    """Renders the visible part at about the screen's resolution, for as long as a gesture moves.

    Parameters
    ----------
    photo : Pyramid
        The photo as 8-bit RGB.
    """

    def __init__(self, photo: Pyramid) -> None:
        self._photo = photo
        self._view: View | None = None
        self._pair: _Pair | None = None
        self._protection = self._mapped = NOTHING

    def render(self, revision: int, state: State, view: View) -> Frame:
        """Return a frame of `view`, sampled bilinearly, in the buffer off screen."""
        start = time.perf_counter()
        if self._pair is None or self._view != view:
            self._pair, self._view = _Pair(self._photo.part(view.level, view.box)), view
            self._protection = self._mapped = NOTHING
        back = to_photo(view.level, (view.box.left, view.box.top))
        rendering, levels = self._pair.render(self._quick(state, back.inverse))
        return Frame(revision, rendering, levels, back, _since_ms(start), whole=False)

    def _quick(self, state: State, there: Affine) -> _Job:
        if state.protection is not self._protection:
            # The warp redoes only what changes as long as the strokes are the very same.
            self._protection, self._mapped = state.protection, state.protection.mapped(there)
        recipe = dataclasses.replace(state.recipe.at_scale(there.scale), interpolation="bilinear")
        return _Job([face.mapped(there) for face in state.active], recipe, self._mapped)

    def shown(self) -> None:
        """Note that the last frame has gone on screen."""
        if self._pair is not None:
            self._pair.swap()


def _since_ms(start: float) -> float:
    return (time.perf_counter() - start) * 1e3
