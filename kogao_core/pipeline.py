"""Render a warped photo: targets, lattice, guard, background, brush, domain, warp."""

from __future__ import annotations

import dataclasses
import os
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from kogao_core.additions.brush import UNTOUCHED, Brushwork
from kogao_core.additions.guard import Limit
from kogao_core.additions.limits import check_corners, check_strokes
from kogao_core.background.holding import NOTHING_HELD, Held
from kogao_core.base.display import preview
from kogao_core.base.geometry import Box, Image, check_image, check_type
from kogao_core.base.language import Text
from kogao_core.base.threads import one_blas_thread
from kogao_core.faces.face import Face
from kogao_core.faces.targets import FacePairs
from kogao_core.field.fade import threshold_of
from kogao_core.field.field import Field, Residual, residual
from kogao_core.field.measures import achieved_percent, protected_shares
from kogao_core.field.one_to_one import OneToOne, check_one_to_one
from kogao_core.field.protection import NOTHING, Protection
from kogao_core.paper.domain import Domain, pixel_counts
from kogao_core.photo.model import Photo
from kogao_core.projects import evidence
from kogao_core.projects.evidence import Evidence
from kogao_core.recipe.recipe import Recipe
from kogao_core.recipe.settings import DomainName
from kogao_core.resample.canvas import FLAGS, Canvas, reduced, size_of, warp_alike
from kogao_core.steps import STEPS, WarpDraft

# The stages in order, with visible names; all time measurements use these keys.
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


@dataclass(frozen=True, eq=False, kw_only=True)
class Rendering:
    """A warped photo and all intermediate results.

    Parameters
    ----------
    pixels : array
        The result: the photo's depth and, unless reduced, the photo's shape. With a
        `Canvas`, its buffer.
    pairs : tuple of FacePairs
        Landmarks, targets and centre of each face.
    field : Field
        The backward displacement.
    limits : tuple of Limit
        For each face, the share that the guard keeps and the position of the largest reduction.
    unheld : Field
        The displacement before lines and neighbours were held.
    domain : Domain
        The processed pixels.
    changed : list of Box
        Regions where `pixels` may differ from the pixels before this rendering.
    recipe : Recipe
        The settings.
    note : str
        A sentence on moves reduced at the photo's edge; empty if there are none.
    timings_ms : dict
        Time by stage.
    brush_shares : tuple of float
        Smallest share of each brush stroke that the guard keeps, 0 to 1.
    photo_sha256 : str
        SHA-256 of the photo's file; "" if `render` got an array.

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
    pairs: tuple[FacePairs, ...]
    field: Field
    limits: tuple[Limit, ...]
    unheld: Field
    domain: Domain
    changed: list[Box]
    recipe: Recipe
    note: str = ""
    timings_ms: dict[str, float] = dataclasses.field(default_factory=dict)
    brush_shares: tuple[float, ...] = ()
    photo_sha256: str = ""

    @property
    def shares(self) -> tuple[float, ...]:
        """The smallest share of each face's displacement that the guard keeps, 0 to 1."""
        return tuple(limit.share for limit in self.limits)

    @property
    def limited_points(self) -> tuple[int, ...]:
        """For each face, the landmark nearest to the guard's largest reduction, from 1."""
        places = (limit.place_px or (0.0, 0.0) for limit in self.limits)
        return tuple(
            int(np.hypot(*(pair.target_px - place).T).argmin()) + 1
            for pair, place in zip(self.pairs, places, strict=True)
        )

    @cached_property
    def one_to_one(self) -> OneToOne:
        """Smallest sampled det J and folded cells, measured on first use."""
        with one_blas_thread():
            return check_one_to_one(self.field)

    @cached_property
    def residual(self) -> Residual:
        """Distance from the requested displacement, px, without brush and protection."""
        own = self.field.lattices[: len(self.pairs)]
        fitted = dataclasses.replace(self.field, lattices=own, protection=NOTHING)
        with one_blas_thread():
            return residual(fitted, self.pairs)

    @cached_property
    def protected_shares(self) -> tuple[tuple[float, ...], ...]:
        """The share of each landmark's move that protection keeps, 0 to 1, for each face."""
        with one_blas_thread():
            return protected_shares(self.field, self.pairs)

    def warped(self, picture: Image) -> Image:
        """Warp another picture of the whole photo by the same field, such as a gain map for HDR.

        Parameters
        ----------
        picture : array of shape (h, w) or (h, w, C)
            A picture of any size, upright; depth and channels as in `render`.

        Returns
        -------
        array
            The warped picture, same shape and depth, resampled once; unmoved pixels are unchanged.

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
        """The threshold T in use, px: less than the recipe's if the fade could have folded."""
        return threshold_of(self.recipe, self.field)

    @cached_property
    def achieved(self) -> tuple[float, ...]:
        """How far each face's landmarks move towards the face's centre, % of D (`measures`)."""
        with one_blas_thread():
            return achieved_percent(self.field, self.pairs)

    @cached_property
    def pixel_counts(self) -> dict[DomainName, int]:
        """Pixels of the three domains of section 4, counted on first use."""
        with one_blas_thread():
            return pixel_counts(self.field.lattices, self.domain.image, self.threshold_px)

    def evidence(self, photo_sha256: str = "") -> Evidence:
        """Collect points, lattices, displacement, det J, masks, recipe and versions.

        Parameters
        ----------
        photo_sha256 : str
            SHA-256 of the photo's file, to be stored if `render` got an array.

        Returns
        -------
        Evidence
            Arrays of the photo's size, 13 bytes per pixel.

        Examples
        --------
        >>> import kogao_core as kogao
        >>> photo = kogao.read(kogao.sample())
        >>> face = kogao.template_face((450, 480), 400)
        >>> evidence = kogao.render(photo.pixels, [face], kogao.Recipe(percent=5)).evidence()
        >>> evidence.points_px.shape, evidence.centers_px.shape
        ((21, 2), (1, 2))
        """
        with one_blas_thread():
            return evidence.gathered(
                self.field, self.pairs, self.domain.image, self.recipe, self.threshold_px,
                self.pixels, photo_sha256 or self.photo_sha256,
            )  # fmt: skip

    def save_evidence(self, path: str | os.PathLike[str], photo_sha256: str = "") -> None:
        """Write the intermediate results to an ``.npz`` file; `load_evidence` reads the file.

        Parameters
        ----------
        path : str or path
            The file; an existing file is replaced.
        photo_sha256 : str
            SHA-256 of the photo's file, to be stored if `render` got an array.

        Examples
        --------
        >>> import numpy as np
        >>> import kogao_core as kogao
        >>> photo = kogao.read(kogao.sample())
        >>> face = kogao.template_face((450, 480), 400)
        >>> kogao.render(photo.pixels, [face], kogao.Recipe(percent=5)).save_evidence("five.npz")
        >>> np.load("five.npz")["displacement_px"].shape
        (900, 900, 2)
        """
        evidence.save(self.evidence(photo_sha256), path)

    def _repr_png_(self) -> bytes:
        """Return the result as a PNG for notebooks."""
        return preview(self.pixels)


@dataclass(frozen=True, eq=False, kw_only=True)
class Measurement:
    """All figures of a rendering."""

    one_to_one: OneToOne
    residual: Residual
    achieved: tuple[float, ...]  # of each face, % of D
    protected_shares: tuple[tuple[float, ...], ...]  # of each landmark of each face, 0 to 1
    pixel_counts: dict[DomainName, int]  # empty unless counted


def measure(rendering: Rendering, *, counts: bool) -> Measurement:
    """Compute the figures of a rendering on the caller's thread.

    `counts`: also count the pixels of the domains, which takes longer than the warp.
    """
    return Measurement(
        one_to_one=rendering.one_to_one,
        residual=rendering.residual,
        achieved=rendering.achieved,
        protected_shares=rendering.protected_shares,
        pixel_counts=rendering.pixel_counts if counts else {},
    )


def _check_types(photo: object, faces: object, *others: object) -> None:
    check_image(photo)
    if not isinstance(faces, Sequence) or not all(isinstance(face, Face) for face in faces):
        raise TypeError("faces must be a sequence of Face, such as [face]")
    for value, kind in zip(others, (Recipe, Protection, Brushwork), strict=True):
        check_type(value, kind, f"such as kogao.{kind.__name__}()")


def render(
    photo: Image | Photo,
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
    photo : array of shape (H, W) or (H, W, C), or Photo
        uint8, uint16 or float32, 1 to 4 channels, upright; not written to.
    faces : sequence of Face
        The faces to make smaller, in px of `photo`.
    recipe : Recipe
        The settings; a face's own settings (`Face.recipe`) take precedence.
    protection : Protection
        Regions that must not move.
    held : Held
        Lines to keep straight and neighbours to keep still where possible; ignored without
        `Recipe.hold_background`. `background.held` finds both.
    brushwork : Brushwork
        Push and restore strokes, applied after all other displacements.
    canvas : Canvas, optional
        A buffer over the same photo, warped in place instead of a fresh copy. The result is
        identical.
    threads : int, optional
        Number of resampling threads; by default as many as processors, up to 4.
    whole : Box, optional
        The rectangle of the complete photo, in px of `photo`, if `photo` is a crop. A head that
        follows the face stops at the photo's edge.
    longest_px : int
        Length of the result's longer side, px; reduced in the same resampling step. 0, or more
        than the photo's longer side: keep the size. A reduction ignores `canvas`.

    Returns
    -------
    Rendering
        At 0 % the pixels equal the photo's pixels.

    Raises
    ------
    TypeError
        If the photo is not an array, a face not a `Face` or the recipe not a `Recipe`.
    ValueError
        If the photo's depth or shape can't be warped, or the canvas is over another photo.
    OutOfBounds
        If faces, lattice, protection or strokes together exceed `limits`.

    Examples
    --------
    >>> import numpy as np
    >>> import kogao_core as kogao
    >>> grey = np.random.default_rng(1).integers(0, 256, (360, 480), np.uint8)
    >>> face = kogao.template_face((240, 180), 120)
    >>> rendering = kogao.render(grey, [face], kogao.Recipe(percent=6))
    >>> rendering.pixels.shape, bool((rendering.pixels == grey).all())
    ((360, 480), False)
    >>> bool((rendering.pixels[:, :20] == grey[:, :20]).all())
    True
    >>> kogao.render(grey, [face], kogao.Recipe(percent=0)).pixels.tobytes() == grey.tobytes()
    True
    """
    photo_sha256 = photo.sha256 if isinstance(photo, Photo) else ""
    photo = photo.pixels if isinstance(photo, Photo) else photo
    _check_types(photo, faces, recipe, protection, brushwork)
    if canvas is not None and canvas.source is not photo:
        raise ValueError("this canvas lies over another photo")
    check_corners(protection)
    check_strokes(brushwork)
    watch, image = Stopwatch(), Box.of(photo)
    draft = WarpDraft(
        faces=faces, recipe=recipe, photo=whole or image, image=image, protection=protection,
        held=held, brushwork=brushwork,
    )  # fmt: skip
    with one_blas_thread():
        for step in STEPS:
            with watch.lap(step.stage):
                draft = step.apply(draft)
        size = size_of(image, longest_px)
        pixels, changed = _drawn(photo, draft, canvas, size, threads, watch)
    return Rendering(
        pixels=pixels,
        pairs=draft.pairs,
        field=draft.field,
        limits=draft.limits,
        unheld=draft.field_before_holding,
        domain=draft.domain,
        changed=changed,
        recipe=recipe,
        note=draft.note,
        timings_ms=watch.laps_ms,
        brush_shares=draft.brush_shares,
        photo_sha256=photo_sha256,
    )


def _drawn(
    photo: Image,
    draft: WarpDraft,
    canvas: Canvas | None,
    size: tuple[int, int],
    threads: int | None,
    watch: Stopwatch,
) -> tuple[Image, list[Box]]:
    """Return the result's pixels and the boxes in which they may have changed."""
    kernel = draft.recipe.interpolation
    if size != (draft.image.width, draft.image.height):
        with watch.lap("warp"):
            moving = draft.domain.bounds
            return reduced(photo, draft.field, moving, size, FLAGS[kernel], threads), []
    with watch.lap("copy"):
        canvas = canvas or Canvas(photo)
    with watch.lap("warp"):
        changed = canvas.warp(draft.field, draft.domain, kernel, threads)
    return canvas.pixels, changed
