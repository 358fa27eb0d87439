"""Express a read retouch in the settings of a recipe, and several as one style."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final, cast

import numpy as np

from kogao_core.base.geometry import Affine, Array, Box, Image
from kogao_core.base.language import Text
from kogao_core.faces.face import Face
from kogao_core.field.field import shown_at
from kogao_core.field.measures import measures
from kogao_core.pipeline import render
from kogao_core.reading.displacement import Reading, read_faces
from kogao_core.recipe.recipe import SETTINGS, SHAPE, Recipe
from kogao_core.recipe.settings import ScopeName

CONTROLS: Final = ("percent", *SHAPE)
# Width of a face, and side of the blank square, px, in which settings are tried.
_FACE_PX: Final = 60.0
_SIDE_PX: Final = 300
_STEPS: Final = 3
_TRIED: Final = 2.0  # change of a setting that tells what the setting does
# A control that changes the fit by less, in widths of the face, is left out.
_HARDLY: Final = 4e-4
_BESIDE: Final = 0.5  # weight of features, ears and hairline beside the outline
_DOUBT: Final = 0.3
NOTHING_PERCENT: Final = 0.15  # mean move of an outline that counts as none, % of its width


@dataclass(frozen=True, slots=True)
class Match:
    """A read retouch of one face, and the nearest settings."""

    reading: Reading
    recipe: Recipe
    unexplained_percent: float  # mean distance of the outline from the read one, % of its width

    @property
    def face(self) -> Face:
        """The face with the read outline as targets, and the nearest settings."""
        reading = self.reading
        return dataclasses.replace(reading.face, targets=reading.outline, recipe=self.recipe)

    def to_dict(self) -> dict[str, Any]:
        settings = {name: getattr(self.recipe, name) for name in CONTROLS}
        settings["unexplained_percent"] = round(self.unexplained_percent, 3)
        return {**self.reading.to_dict(), "settings": settings}

    def report(self, number: int) -> list[Text]:
        """Return the lines of the report; faces are counted from 1."""
        reading, last = self.reading, len(self.reading.face.outline) - 1
        if reading.moved_percent < NOTHING_PERCENT:
            return [Text("face {number}: nothing moved", number=number)]
        return [
            Text(
                "face {number}: the outline moved by {moved:.2f} % of the face width, give or take "
                "{doubt:.2f} %",
                number=number,
                moved=reading.moved_percent,
                doubt=reading.moved_doubt_percent,
            ),
            Text(
                "width at the cheeks {cheeks:+.1f} %, at the jaw {jaw:+.1f} %",
                cheeks=reading.narrower(round(0.15 * last)),
                jaw=reading.narrower(round(0.35 * last)),
            ),
            Text(
                "nearest settings: {settings}; they leave {left:.2f} % of the face width",
                settings=self.recipe.amount,
                left=self.unexplained_percent,
            ),
        ]


def match(before: Image, after: Image, faces: Sequence[Face]) -> list[Match]:
    """Read how `after` moved the faces of `before`, and fit settings. Raises NotRead."""
    return [fit_controls(one, Box.of(before)) for one in read_faces(before, after, faces)]


def fit_controls(reading: Reading, image: Box) -> Match:
    """Fit the controls to a reading by Gauss-Newton steps, in each scope; return the better fit.

    The photo's box is `image`.
    """
    scale = _FACE_PX / measures(reading.face).width_px
    small = Affine.similarity(scale, 0.0, (_SIDE_PX - 1) / 2.0 - scale * reading.face.middle)
    face = dataclasses.replace(reading.face.mapped(small), targets=None, recipe=None)
    points, wanted = small(reading.points), small(reading.moved) - small(reading.points)
    corners = np.round(small([(image.left, image.top), (image.right, image.bottom)])).astype(int)
    whole = Box(*corners.ravel().tolist())
    blank = np.zeros((_SIDE_PX, _SIDE_PX), np.uint8)
    outline = len(face.outline)
    weights = np.repeat(1.0 / (1.0 + reading.doubt / _DOUBT), 2)
    weights[2 * outline :] *= _BESIDE
    low, high = np.array([SETTINGS[name].within for name in CONTROLS], np.float64).T
    fits = []
    for scope in SETTINGS["scope"].choices:
        start = Recipe(hold_background=False, scope=cast(ScopeName, scope))

        def moves(values: Array, start: Recipe = start) -> Array:
            field = render(blank, [face], _with(start, values), whole=whole).field
            return shown_at(field, points) - points

        tried = [moves(one).ravel() / _TRIED for one in _TRIED * np.eye(len(CONTROLS))]
        effects = np.column_stack(tried) * weights[:, None]
        used = _needed(effects, wanted.ravel() * weights)
        values, here = np.zeros(len(CONTROLS)), np.zeros_like(wanted)
        for _ in range(_STEPS):
            left = (wanted - here).ravel() * weights
            values[used] += np.linalg.lstsq(effects[:, used], left, rcond=None)[0]
            values = np.clip(np.round(values, 1), low, high)
            here = moves(values)
        away = np.linalg.norm((wanted - here)[:outline], axis=1).mean()
        recipe = dataclasses.replace(_with(start, values), hold_background=True)
        cost = float(np.mean(((wanted - here).ravel() * weights) ** 2))
        fits.append((cost, recipe, float(100.0 * away / _FACE_PX)))
    return Match(reading, *min(fits, key=lambda one: one[0])[1:])


def _needed(effects: Array, wanted: Array) -> list[int]:
    """Return the controls that explain a move; shapes that hardly add are left out."""

    def cost(columns: list[int]) -> float:
        part = effects[:, columns]
        left = wanted - part @ np.linalg.lstsq(part, wanted, rcond=None)[0]
        return float(np.sqrt(np.mean(left**2)))

    used = list(range(effects.shape[1]))
    most = cost(used) + _HARDLY * _FACE_PX
    while len(used) > 1:
        fewer = [[one for one in used if one != gone] for gone in used[1:]]
        best = min(fewer, key=cost)
        if cost(best) > most:
            break
        used = best
    return used


def _with(recipe: Recipe, values: Array) -> Recipe:
    settings: dict[str, Any] = dict(zip(CONTROLS, values.tolist(), strict=True))
    return dataclasses.replace(recipe, **settings)


def style(recipes: Sequence[Recipe]) -> tuple[Recipe, dict[str, float]]:
    """Return the median of each control as a recipe, and half the spread of its middle half."""
    table = np.array([[getattr(one, name) for name in CONTROLS] for one in recipes])
    low, middle, high = np.percentile(table, (25.0, 50.0, 75.0), axis=0)
    scope = max(SETTINGS["scope"].choices, key=[one.scope for one in recipes].count)
    start = Recipe(scope=cast(ScopeName, scope))
    spread = ((high - low) / 2.0).round(2).tolist()
    return _with(start, np.round(middle, 1)), dict(zip(CONTROLS, spread, strict=True))
