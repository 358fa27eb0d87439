"""Convert parts of a project file from and to JSON. `unit` is the unit of lengths in px."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Sequence
from typing import Any, Final, get_args

import numpy as np

from kogao_core.additions.brush import LEAST_FALLOFF, BrushKind, BrushStroke, Brushwork
from kogao_core.additions.limits import MOST_CORNERS, MOST_LANDMARKS
from kogao_core.base.geometry import Array, Line
from kogao_core.base.json_reader import BadFile, Node
from kogao_core.base.language import Text
from kogao_core.faces.face import FOREHEAD_POINTS, Anchor, Face
from kogao_core.field.mask import MOST_RUNS, Mask
from kogao_core.field.protection import Protection, Stroke
from kogao_core.recipe.recipe import Recipe

MOST_FACES: Final = 1000
_MOST_POINTS: Final = 10_000
_MOST_MASKS: Final = 16
_MOST_MASK_PX: Final = 3 * 10**8
_RUN: Final = re.compile(r"([1-9][0-9]{0,8})([a-e])")
_LONGEST_RUNS: Final = 10 * MOST_RUNS
# Points may be dragged off the photo, but rarely farther than the photo's size.
_FARTHEST: Final = 64.0
_LEAST_LENGTH: Final = 1e-9
_FACE_FIELDS: Final = (
    *("outline", "eyes", "mouth", "targets", "frame", "score", "confidence"),
    *("source", "recipe", "forehead", "on"),
)


def face_dict(face: Face, unit: int) -> dict[str, Any]:
    """Convert a face to plain JSON values. An automatic target becomes null."""
    pinned, targets = face.pinned_anchor, face.targets
    origin = None if pinned is None else [value / unit for value in pinned.origin_px]
    anchor = None if pinned is None else {"origin": origin, "spacing": pinned.spacing_px / unit}
    return {
        "outline": _in_units(face.outline, unit),
        "eyes": _in_units(face.eyes, unit),
        "mouth": _in_units(face.mouth, unit),
        "targets": None if targets is None else [_aim(target, unit) for target in targets],
        "frame": anchor,
        "score": face.score,
        "confidence": None if face.confidence is None else face.confidence.tolist(),
        "source": face.source,
        "recipe": None if face.recipe is None else face.recipe.to_dict(),
        "forehead": None if face.forehead is None else _in_units(face.forehead, unit),
    }


def faces(nodes: Sequence[Node], unit: int) -> tuple[Face, ...]:
    """Read the faces of a sheet."""
    for name in ("outline", "targets", "confidence"):
        if sum(node.count(name) for node in nodes) > MOST_LANDMARKS:
            raise BadFile(
                "the file's faces have more than {most_landmarks} landmarks together",
                most_landmarks=MOST_LANDMARKS,
            )
    return tuple(face(node, unit) for node in nodes)


def face(node: Node, unit: int) -> Face:
    """Read a face written by `face_dict`."""
    node.only(_FACE_FIELDS)
    outline = _points(node.field("outline"), unit, _MOST_POINTS)
    targets, anchor = node.field("targets"), node.field("frame")
    confidence, own = node.field("confidence"), node.field("recipe")
    forehead = node.field("forehead")
    try:
        return Face(
            outline=outline,
            eyes=_points(node.field("eyes"), unit, 4),
            mouth=_points(node.field("mouth"), unit, 2),
            score=node.field("score").number(0.0, 1.0),
            targets=None if targets.value is None else _targets(targets, unit),
            pinned_anchor=None if anchor.value is None else _anchor(anchor, unit),
            source=node.field("source").text(40),
            recipe=None if own.value is None else recipe(own),
            confidence=None if confidence.value is None else _shares(confidence),
            forehead=None if forehead.value is None else _points(forehead, unit, FOREHEAD_POINTS),
        )
    except BadFile:
        raise
    except ValueError as error:  # Face rejects the values
        node.refuse(Text("is not a face: {error}", error=error))


def recipe(node: Node) -> Recipe:
    """Read a recipe."""
    try:
        return Recipe.from_dict(node.value)
    except (ValueError, TypeError) as error:
        node.refuse(Text("is not a recipe: {error}", error=str(error)))


def protection_dict(protection: Protection, unit: int) -> dict[str, Any]:
    """Convert protected regions to plain JSON values."""
    strokes = [
        {"points": _in_units(stroke.points_px, unit), "radius": stroke.radius_px / unit}
        for stroke in protection.drawn
    ]
    masks = [
        {"width": mask.steps.shape[1], "height": mask.steps.shape[0], "runs": mask.runs()}
        for mask in protection.masks
    ]
    return {"strokes": strokes, **({"masks": masks} if masks else {})}


def protection(node: Node, unit: int, width: int, height: int) -> Protection:
    """Read protected regions of a photo written by `protection_dict`."""
    strokes = _strokes(node.only(("strokes", "masks")).field("strokes"))
    masks = node.field("masks")
    found = [] if masks.value is None else masks.items(_MOST_MASKS)
    return Protection(
        (
            *(_stroke(stroke, unit) for stroke in strokes),
            *(_mask(mask, width, height) for mask in found),
        )
    )


def _mask(node: Node, width: int, height: int) -> Mask:
    node.only(("width", "height", "runs"))
    columns, rows = (node.field(name).whole(1, 2**16) for name in ("width", "height"))
    runs = _RUN.findall(node.field("runs").text(_LONGEST_RUNS))
    lengths = [int(length) for length, _ in runs]
    if sum(lengths) != columns * rows or sum(lengths) > _MOST_MASK_PX:
        node.refuse(Text("doesn't fill its size"))
    steps = np.repeat(np.array(["abcde".index(step) for _, step in runs], np.uint8), lengths)
    return Mask.of(steps.reshape(rows, columns), width, height)


def _strokes(node: Node) -> list[Node]:
    strokes = node.items(MOST_CORNERS)
    corners = sum(stroke.count("points") for stroke in strokes)
    if corners > MOST_CORNERS:
        node.refuse(
            Text(
                "has {corners} corners together; at most {most_corners} are allowed",
                corners=corners,
                most_corners=MOST_CORNERS,
            )
        )
    return strokes


def brushwork_list(brushwork: Brushwork, unit: int) -> list[dict[str, Any]]:
    """Convert push and restore strokes to plain JSON values."""
    return [
        {
            "kind": stroke.kind,
            "points": _in_units(stroke.points_px, unit),
            "radius": stroke.radius_px / unit,
            "strength": stroke.strength,
            "falloff": stroke.falloff,
            "pressure": None if stroke.pressure is None else stroke.pressure.tolist(),
        }
        for stroke in brushwork.strokes
    ]


def brushwork(node: Node, unit: int) -> Brushwork:
    """Read strokes written by `brushwork_list`."""
    return Brushwork(tuple(_brush_stroke(stroke, unit) for stroke in _strokes(node)))


def lines_list(lines: Sequence[Line], unit: int) -> list[list[list[float]]]:
    """Convert straight lines to plain JSON values."""
    return [_in_units(np.array(line), unit) for line in lines]


def lines(node: Node, unit: int) -> tuple[Line, ...]:
    """Read lines written by `lines_list`."""
    found = [_points(item, unit, 2) for item in node.items(MOST_CORNERS)]
    if any(len(line) != 2 for line in found):
        node.refuse(Text("must contain lines of two points each"))
    return tuple(as_line(line) for line in found)


def as_line(ends: Array) -> Line:
    """Create a line from end points of shape (2, 2)."""
    (x, y), (u, v) = ends.tolist()
    return (x, y), (u, v)


def _stroke(node: Node, unit: int) -> Stroke:
    node.only(("points", "radius"))
    points = _points(node.field("points"), unit, _MOST_POINTS)
    if not len(points):
        node.refuse(Text("needs at least one point"))
    return Stroke(points, node.field("radius").number(0.0, 1.0) * unit)


def _brush_stroke(node: Node, unit: int) -> BrushStroke:
    node.only([field.name.removesuffix("_px") for field in dataclasses.fields(BrushStroke)])
    pressure = node.field("pressure")
    kind = node.field("kind").text(16, get_args(BrushKind))
    try:
        return BrushStroke(
            "push" if kind == "push" else "restore",
            _points(node.field("points"), unit, _MOST_POINTS),
            node.field("radius").number(0.0, 1.0) * unit,
            node.field("strength").number(0.0, 1.0),
            node.field("falloff").number(LEAST_FALLOFF, 1.0),
            None if pressure.value is None else _shares(pressure),
        )
    except BadFile:
        raise
    except ValueError as error:  # BrushStroke rejects the values
        node.refuse(Text("is not a stroke: {error}", error=error))


def _in_units(points: Array, unit: int) -> list[list[float]]:
    shares: list[list[float]] = (points / unit).tolist()
    return shares


def _aim(target: Array, unit: int) -> list[float] | None:
    x, y = (target / unit).tolist()
    return None if np.isnan(x) else [x, y]


def _points(node: Node, unit: int, most: int) -> Array:
    return np.array([_point(item, unit) for item in node.items(most)]).reshape(-1, 2)


def _point(node: Node, unit: int) -> tuple[float, float]:
    pair = [item.number(-_FARTHEST, _FARTHEST) * unit for item in node.items(2)]
    if len(pair) != 2:
        node.refuse(Text("must be two numbers"))
    return pair[0], pair[1]


def _targets(node: Node, unit: int) -> Array:
    nowhere = (np.nan, np.nan)
    items = node.items(_MOST_POINTS)
    rows = [nowhere if item.value is None else _point(item, unit) for item in items]
    return np.array(rows).reshape(-1, 2)


def _shares(node: Node) -> Array:
    return np.array([item.number(0.0, 1.0) for item in node.items(_MOST_POINTS + 6)])


def _anchor(node: Node, unit: int) -> Anchor:
    node.only(("origin", "spacing"))
    origin = _point(node.field("origin"), unit)
    return Anchor(origin, node.field("spacing").number(_LEAST_LENGTH, _FARTHEST) * unit)
