"""The paper end to end: targets, lattice, domain, warp. One pure function serves everything."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from itertools import repeat
from typing import Final

from kogao_core.background.holding import NOTHING_HELD, Held, hold
from kogao_core.base.display import preview
from kogao_core.base.geometry import Box, Image
from kogao_core.base.language import Text
from kogao_core.base.threads import one_blas_thread
from kogao_core.faces.face import Face
from kogao_core.faces.targets import Pairs, aim
from kogao_core.recipe.recipe import Recipe
from kogao_core.recipe.settings import DomainName
from kogao_core.warp import domain as domains
from kogao_core.warp.brush import UNTOUCHED, Brushwork, brushed
from kogao_core.warp.canvas import FLAGS, Canvas, reduced, size_of, warp_alike
from kogao_core.warp.domain import pixel_counts
from kogao_core.warp.field import Field, Residual, residual
from kogao_core.warp.fit import problems_of, solve
from kogao_core.warp.frame import cut_note, slid
from kogao_core.warp.guard import hold_back
from kogao_core.warp.lens import Heads
from kogao_core.warp.limits import check_corners, check_strokes
from kogao_core.warp.measures import achieved_percent
from kogao_core.warp.one_to_one import OneToOne, check_one_to_one
from kogao_core.warp.protection import NOTHING, Protection, falloff_of
from kogao_core.warp.surround import surrounds_of

# The stages in their order, and what people call them; every clock in the program reads these.
STAGES: Final = {
    "targets": Text("targets"),
    "lattice": Text("lattice"),
    "guard": Text("guard"),
    "background": Text("background"),
    "brush": Text("brush"),
    "domain": Text("domain"),
    "copy": Text("copy"),
    "warp": Text("warp"),
}


class Stopwatch:
    """Wall-clock time by stage name, in ms."""

    def __init__(self) -> None:
        self.laps_ms: dict[str, float] = {}

    @contextmanager
    def lap(self, stage: str) -> Iterator[None]:
        """Add the time of the ``with`` block to `stage`."""
        start = time.perf_counter()
        try:
            yield
        finally:
            elapsed = (time.perf_counter() - start) * 1e3
            self.laps_ms[stage] = self.laps_ms.get(stage, 0.0) + elapsed


@dataclass(frozen=True, eq=False)
class Rendering:
    """A warped photo with everything that led to it.

    Parameters
    ----------
    pixels : array
        The result, same depth as the photo, and the same shape unless it was to be reduced. With a
        `Canvas`, its buffer.
    pairs : tuple of Pairs
        Landmarks, targets and centre of each face.
    field : Field
        The backward displacement.
    shares : tuple of float
        How much of each face's displacement the guard let through; below 1 it would have folded.
    unheld : Field
        The same before lines and neighbours were held.
    domain : Domain
        The pixels worked on.
    changed : list of Box
        Where `pixels` may differ from before this rendering.
    recipe : Recipe
        The choices.
    note : str
        What can't be done right at the photo's edge, in a sentence; empty where nothing is cut.
    timings_ms : dict
        Time by stage.
    brush_shares : tuple of float
        How much of each stroke of the brush the guard let through; below 1 it would have folded.

    Examples
    --------
    >>> import kogao_core as kogao
    >>> photo = kogao.read(kogao.sample())
    >>> face = kogao.template_face((450, 480), 400)
    >>> rendering = kogao.render(photo.pixels, [face], kogao.Recipe(percent=5))
    >>> [round(percent, 2) for percent in rendering.achieved]
    [5.0]
    >>> rendering.one_to_one.certified, rendering.shares
    (True, (1.0,))
    >>> list(rendering.timings_ms)
    ['targets', 'lattice', 'guard', 'background', 'brush', 'domain', 'copy', 'warp']
    """

    pixels: Image
    pairs: tuple[Pairs, ...]
    field: Field
    shares: tuple[float, ...]
    unheld: Field
    domain: domains.Domain
    changed: list[Box]
    recipe: Recipe
    note: str = ""
    timings_ms: dict[str, float] = dataclasses.field(default_factory=dict)
    brush_shares: tuple[float, ...] = ()

    @cached_property
    def one_to_one(self) -> OneToOne:
        """Smallest det J of the samples, and folded cells, measured on first use."""
        with one_blas_thread():
            return check_one_to_one(self.field)

    @cached_property
    def residual(self) -> Residual:
        """How far the field at the targets is from what they ask for, strokes aside."""
        own = self.field.lattices[: len(self.pairs)]
        with one_blas_thread():
            return residual(dataclasses.replace(self.field, lattices=own), self.pairs)

    def warped(self, picture: Image) -> Image:
        """Warp another picture of the whole photo by the same field, such as a gain map for HDR.

        Parameters
        ----------
        picture : array of shape (h, w) or (h, w, C)
            As `render` takes them, of any size, upright.

        Returns
        -------
        array
            Of its shape and depth, resampled once; where nothing moves it has the same bytes.

        Examples
        --------
        >>> import kogao_core as kogao
        >>> photo = kogao.read(kogao.sample())
        >>> face = kogao.template_face((450, 480), 400)
        >>> rendering = kogao.render(photo.pixels, [face], kogao.Recipe(percent=5))
        >>> half = photo.pixels[::2, ::2]
        >>> rendering.warped(half).shape, bool((rendering.warped(half) == half).all())
        ((450, 450, 3), False)
        """
        with one_blas_thread():
            return warp_alike(picture, self.field, self.domain, self.recipe.interpolation)

    @property
    def threshold_px(self) -> float:
        """The T that this went by: below the recipe's where its fade could have folded."""
        return domains.threshold_of(self.recipe, self.field)

    @cached_property
    def achieved(self) -> tuple[float, ...]:
        """How far the landmarks of each face come towards its centre, % of D (`measures`)."""
        with one_blas_thread():
            return achieved_percent(self.field, self.pairs)

    @cached_property
    def pixel_counts(self) -> dict[DomainName, int]:
        """Pixels of the three domains of section 4, counted on first use."""
        with one_blas_thread():
            return pixel_counts(self.field, self.domain.image, self.threshold_px)

    def _repr_png_(self) -> bytes:
        """Return the result as a notebook shows it."""
        return preview(self.pixels)


def render(
    photo: Image,
    faces: Sequence[Face],
    recipe: Recipe,
    *,
    protection: Protection = NOTHING,
    held: Held = NOTHING_HELD,
    brushwork: Brushwork = UNTOUCHED,
    canvas: Canvas | None = None,
    threads: int | None = None,
    whole: Box | None = None,
    longest_px: int = 0,
) -> Rendering:
    """Warp the faces of a photo.

    Parameters
    ----------
    photo : array of shape (H, W) or (H, W, C)
        uint8, uint16 or float32, 1 to 4 channels, upright; not written to.
    faces : sequence of Face
        Which faces to make smaller, in px of `photo`.
    recipe : Recipe
        Every choice of the user; a face's own (`Face.recipe`) come before it.
    protection : Protection
        Places that must not move.
    held : Held
        Lines that stay straight and neighbours who stay put where they can, unless the recipe lets
        them go; `background.held` finds them.
    brushwork : Brushwork
        Strokes of push and restore over what all else makes of the photo.
    canvas : Canvas, optional
        A buffer over the same photo to work in place instead of on a fresh copy; the result is
        the same to the bit.
    threads : int, optional
        Threads that resample; as many as there are processors, up to 4, when absent.
    whole : Box, optional
        The rectangle of the whole photo, px of `photo`, where that is a part of one: a head that
        follows its face stops at the photo's edge.
    longest_px : int
        Reduce the result to this longer side, in the same resampling; 0, or more than the photo
        has, leaves its size. Nothing of `canvas` is used then.

    Returns
    -------
    Rendering
        At 0 % its pixels are the photo's bytes.

    Raises
    ------
    ValueError
        If the photo's depth or shape can't be warped, or the canvas is over another photo.
    OutOfBounds
        If faces, lattice, protection or strokes together ask for more than `limits` allows.

    Examples
    --------
    >>> import numpy as np
    >>> import kogao_core as kogao
    >>> grey = np.random.default_rng(1).integers(0, 256, (360, 480), np.uint8)
    >>> face = kogao.template_face((240, 180), 200)
    >>> rendering = kogao.render(grey, [face], kogao.Recipe(percent=6))
    >>> rendering.pixels.shape, bool((rendering.pixels == grey).all())
    ((360, 480), False)
    >>> bool((rendering.pixels[:, :20] == grey[:, :20]).all())
    True
    >>> kogao.render(grey, [face], kogao.Recipe(percent=0)).pixels.tobytes() == grey.tobytes()
    True
    """
    if canvas is not None and canvas.source is not photo:
        raise ValueError("this canvas lies over another photo")
    check_corners(protection)
    check_strokes(brushwork)
    watch = Stopwatch()
    with one_blas_thread():
        with watch.lap("targets"):
            edges = whole or Box.of(photo)
            heads = Heads.of(faces, recipe, edges)
            seen = heads.faces or faces
            asked = tuple(aim(*both) for both in zip(faces, repeat(recipe), seen))
            pairs = tuple(slid(pair, edges) for pair in asked) if recipe.guard else asked
            recipes = [recipe.of_face(face.recipe) for face in faces]
            beside = held.neighbours if recipe.hold_background else ()
            around = [pair.started for pair in pairs]
            alone = surrounds_of(seen, around, recipes, edges, protection, beside)
            surrounds = heads.around(alone, protection, beside)
        with watch.lap("lattice"):
            anchors = [face.anchor for face in faces]
            inside = edges if recipe.guard else None
            problems = problems_of(pairs, anchors, recipes, protection, surrounds, inside)
            field = Field(solve(problems, recipes), domains.fade_of(recipe), falloff_of(protection))
        with watch.lap("guard"):
            field, shares = hold_back(field) if recipe.guard else (field, (1.0,) * len(faces))
        with watch.lap("background"):
            unheld = field
            if recipe.hold_background:
                field = hold(field, problems, seen, held)
        brush_shares: tuple[float, ...] = ()
        with watch.lap("brush"):
            if brushwork.strokes:
                field, brush_shares = brushed(
                    field, brushwork, protection, edges, guarded=recipe.guard
                )
        with watch.lap("domain"):
            area = domains.reduce(field, Box.of(photo), recipe.domain)
        size = size_of(Box.of(photo), longest_px)
        if size != (photo.shape[1], photo.shape[0]):
            with watch.lap("warp"):
                flag = FLAGS[recipe.interpolation]
                pixels, changed = reduced(photo, field, area.bounds, size, flag, threads), []
        else:
            with watch.lap("copy"):
                canvas = canvas or Canvas(photo)
            with watch.lap("warp"):
                changed = canvas.warp(field, area, recipe.interpolation, threads)
            pixels = canvas.pixels
    return Rendering(
        *(pixels, pairs, field, shares, unheld, area, changed, recipe),
        cut_note(pairs, asked),
        watch.laps_ms,
        brush_shares,
    )
