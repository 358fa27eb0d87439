"""Draw the figures of rim, head, outline and pivot, `docs/figures/*.svg`, with the engine itself.

``python docs/figures.py`` after one of these modules has changed; a test compares the files.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final

import numpy as np

from kogao_core.additions.head import HeadMotion, motion_of
from kogao_core.additions.outline import OutlineMotion
from kogao_core.additions.pivot import attract_pivots
from kogao_core.additions.rim import Rim, unit_vectors
from kogao_core.base.geometry import Array
from kogao_core.faces.landmarks.sources import template_face
from kogao_core.faces.targets import aim
from kogao_core.field.protection import Protection
from kogao_core.recipe.recipe import Recipe

FOLDER: Final = Path(__file__).parent / "figures"
_SIDE: Final = 360  # px
_FACE: Final = template_face((180, 205), 100)
_ANGLES: Final = np.linspace(-np.pi, np.pi, 73)
_INK, _BLUE, _RED, _GREY = "#222", "#1763c7", "#c4372b", "#999"


def figures() -> dict[str, str]:
    """Return the SVG text of each figure by name."""
    return {"rim": _rim(), "head": _head(), "outline": _outline(), "pivot": _pivot()}


def _rim() -> str:
    rim = _head_motion().rim
    curves = [_curve(rim, np.full_like(_ANGLES, rho), _GREY) for rho in (0.25, 0.5, 0.75, 1.5)]
    point = rim.center_px + 1.5 * rim.radius_px(np.array([2.0])) * unit_vectors(
        np.array([2.0]), rim.across
    )
    ray = _line(np.vstack([rim.center_px, point]), _BLUE)
    labels = _label(rim.center_px, "c") + _label(point[0], "p: rho = 1.5")
    return _svg([*curves, _curve(rim, np.ones_like(_ANGLES), _INK), ray, labels, _landmarks()])


def _head() -> str:
    motion = _head_motion()
    rim, (keep, fade) = motion.rim, motion._fade(_ANGLES)
    grid = np.stack(np.meshgrid(np.arange(20, 350, 30), np.arange(20, 350, 30)), -1).reshape(-1, 2)
    ends = grid - motion.at(grid.astype(np.float64)) * 4.0
    arrows = [_line(np.array(each), _BLUE) for each in zip(grid, ends, strict=True)]
    curves = [_curve(rim, np.ones_like(_ANGLES), _INK), _curve(rim, keep, _RED)]
    labels = _label(motion.pairs.center_px, "pivot") + _text(
        (8, 350), "black: rim; red: keep; grey: keep + fade"
    )
    return _svg([*arrows, *curves, _curve(rim, keep + fade, _GREY), labels, _landmarks()])


def _outline() -> str:
    motion = motion_of(_FACE, aim(_FACE, recipe := Recipe(percent=15.0, scope="face")), recipe)
    assert isinstance(motion, OutlineMotion)
    rho = np.linspace(0.0, 2.5, 126)
    most = motion.rim.angles[[np.hypot(*motion.rim.moves_px.T).argmax()]]
    side, radius = unit_vectors(most, motion.rim.across), motion.rim.radius_px(most)
    moves = np.hypot(*motion.at(motion.rim.center_px + rho[:, None] * radius * side).T)
    plot = np.column_stack([30 + rho * 120, 320 - 280 * moves / moves.max()])
    axis = _line(np.array([(30, 320), (340, 320)]), _INK) + _line(
        np.array([(150, 30), (150, 320)]), _GREY
    )
    labels = _text((145, 340), "1") + _text((320, 340), "rho") + _text((36, 30), "|d| / max |d|")
    return _svg([axis, _line(plot, _BLUE), labels])


def _pivot() -> str:
    pairs = aim(_FACE, Recipe())
    stroke = np.array([(100.0, 150.0), (95.0, 250.0)])
    strokes = Protection().with_stroke(stroke, radius_px=6.0).strokes
    (moved,) = attract_pivots([pairs], [_FACE], strokes)
    ways = [_line(np.vstack([pairs.center_px, moved.center_px]), _RED)]
    ways += [_line(np.vstack([place, moved.center_px]), _GREY) for place in stroke]
    labels = _label(pairs.center_px, "p") + _label(moved.center_px, "p'") + _label(stroke[0], "q")
    return _svg([_line(stroke, _BLUE, 8), *ways, labels, _landmarks()])


def _head_motion() -> HeadMotion:
    motion = motion_of(_FACE, aim(_FACE, Recipe(percent=8.0)), Recipe(percent=8.0))
    assert isinstance(motion, HeadMotion)
    return motion


def _curve(rim: Rim, rho: Array, colour: str) -> str:
    far = (rho * rim.radius_px(_ANGLES))[:, None]
    return _line(rim.center_px + far * unit_vectors(_ANGLES, rim.across), colour)


def _line(points: Array, colour: str, width: float = 1.5) -> str:
    places = " ".join(f"{x:.0f},{y:.0f}" for x, y in points)
    style = f'fill="none" stroke="{colour}" stroke-width="{width}"'
    return f'<polyline points="{places}" {style}/>\n'


def _landmarks() -> str:
    return "".join(f'<circle cx="{x:.0f}" cy="{y:.0f}" r="2"/>\n' for x, y in _FACE.points)


def _label(point: Array, text: str) -> str:
    x, y = point
    return f'<circle cx="{x:.0f}" cy="{y:.0f}" r="4" fill="{_RED}"/>\n' + _text((x + 7, y), text)


def _text(place: Sequence[float], text: str) -> str:
    return f'<text x="{place[0]:.0f}" y="{place[1]:.0f}" font-size="14">{text}</text>\n'


def _svg(parts: Sequence[str]) -> str:
    size = f'width="{_SIDE}" height="{_SIDE}" viewBox="0 0 {_SIDE} {_SIDE}"'
    ground = '<rect width="100%" height="100%" fill="white"/>\n'
    head = f'<svg xmlns="http://www.w3.org/2000/svg" {size} font-family="sans-serif">\n'
    return head + ground + "".join(parts) + "</svg>\n"


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    for name, text in figures().items():
        (FOLDER / f"{name}.svg").write_text(text, encoding="utf-8")
