"""Scenes whose results are stored, so that a change of any tuned constant is noticed.

``python tests/pinned.py`` (in the folder `tests`) writes the results of this version to
``labels/pinned.json``. Do that only after a deliberate change of the pictures, and say why.
"""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Final

import cv2
import heads
import numpy as np

from kogao_core.additions.brush import UNTOUCHED, Brushwork
from kogao_core.additions.lens import distance_m, distance_note, stretch_percent
from kogao_core.background.find import BackgroundFinder, held_of, measure
from kogao_core.base.assets import sample
from kogao_core.base.geometry import Affine, Box, Image
from kogao_core.faces.doubt import AllDoubted, choose, verdicts
from kogao_core.faces.face import Face
from kogao_core.faces.landmarks import MeshSource
from kogao_core.faces.landmarks.aam.source import AamSource
from kogao_core.faces.landmarks.edges import ALONG, MOVES, settle
from kogao_core.faces.landmarks.mesh import Mesh, MeshInput, Passes, _sure_corners, box_of
from kogao_core.faces.landmarks.sources import template_face
from kogao_core.field.protection import NOTHING, Protection
from kogao_core.photo import read
from kogao_core.pipeline import render
from kogao_core.projects.sidecar import Applied
from kogao_core.recipe.recipe import SETTINGS, Recipe

FILE: Final = Path(__file__).parent / "labels" / "pinned.json"
_GRID: Final = 14  # displacements are stored on so many positions per axis
_DIGITS: Final = 3
_TOLERANCES: Final = {
    "points": 0.3,
    "faces": 0.04,
    "displacement": 0.012,
    "turns": 0.05,
    "rises": 0.3,
    "searched": 0.005,
}


def _portrait(name: str = "average") -> Image:
    return read(sample().with_name(f"{name}.jpg")).pixels


def _with_lines(photo: Image) -> Image:
    """Draw a door frame and a shelf behind the head."""
    photo = photo.copy()
    for x in (118, 790):
        cv2.line(photo, (x, 0), (x - 12, 899), (90, 80, 70), 5, cv2.LINE_AA)
    cv2.line(photo, (0, 210), (235, 200), (60, 60, 60), 4, cv2.LINE_AA)
    cv2.line(photo, (655, 120), (899, 128), (60, 60, 60), 4, cv2.LINE_AA)
    return photo


def _rotated(photo: Image, degrees: float) -> Image:
    height, width = photo.shape[:2]
    turn = cv2.getRotationMatrix2D((width / 2, height / 2), degrees, 0.8)
    return np.asarray(cv2.warpAffine(photo, turn, (width, height), borderMode=cv2.BORDER_REFLECT))


def _wide(photo: Image) -> Image:
    """Place a portrait near the right edge of a wide photo."""
    small = cv2.resize(photo, (420, 420), interpolation=cv2.INTER_AREA)
    wide = np.full((600, 900, 3), small[0, 0], np.uint8)
    wide[120:540, 470:890] = small
    return wide


def _pair(gap_px: int) -> Image:
    """Place two heads next to each other; a smaller gap lets them touch."""
    men, women = _portrait("men")[60:860, 200:700], _portrait("women")[60:860, 200:700]
    return np.hstack([men[:, : 450 - gap_px], women[:, 50 + gap_px :]])


def _covered(photo: Image) -> Image:
    """Cover the mouth like a mask."""
    photo = photo.copy()
    cv2.ellipse(photo, (450, 640), (150, 110), 0, 0, 360, (40, 60, 120), -1, cv2.LINE_AA)
    return photo


_STROKE: Final = Protection().with_stroke([(250, 380), (262, 560)], radius_px=14)
_BRUSH: Final = (
    Brushwork()
    .with_stroke("push", [(620, 560), (570, 556)], radius_px=90)
    .with_stroke("push", [(590, 640), (450, 640)], radius_px=60, strength=1.0)
    .with_stroke("restore", [(440, 690), (470, 690)], radius_px=70)
)
SCENES: Final[dict[str, tuple[Callable[[], Image], dict[str, Any]]]] = {
    "lines": (lambda: _with_lines(_portrait()), {"percent": 8.0}),
    "tight": (
        lambda: _portrait("women")[110:720, 215:700],
        {"percent": 10.0, "jaw_width": -6.0, "forehead_height": -6.0, "chin_length": 4.0},
    ),
    "cut": (lambda: _portrait("men")[180:900, 330:900], {"percent": 8.0, "width": -5.0}),
    "edge": (lambda: _portrait("men")[200:745, 200:700], {"percent": 9.0, "scope": "face"}),
    "pair": (lambda: _pair(70), {"percent": 8.0}),
    "loose": (lambda: _with_lines(_portrait()), {"percent": 8.0}),
    "beside": (lambda: _pair(40), {"percent": 8.0, "lattice": 0.5}),
    "hand": (_portrait, {"percent": 6.0}),
    "squeezed": (_portrait, {"percent": 12.0, "jaw_width": -10.0, "cheeks_width": -10.0,
                             "length": -10.0}),
    "lens": (lambda: _wide(_portrait("women")), {"percent": 4.0, "lens": 20.0}),
    "lens-pair": (lambda: _wide(_pair(70)), {"percent": 0.0, "lens": 20.0}),
    "tilted": (lambda: _rotated(_portrait("women"), 24.0), {"percent": 8.0, "even_out": 60.0}),
    "face": (_portrait, {"percent": 8.0, "scope": "face", "left_width": 5.0}),
    "small": (lambda: cv2.resize(_portrait("men"), (150, 150), interpolation=cv2.INTER_AREA), {}),
    "blurred": (lambda: cv2.GaussianBlur(_portrait(), (0, 0), 7), {}),
    "covered": (lambda: _covered(_portrait("men")), {}),
}  # fmt: skip
_AGAIN: Final = (
    Brushwork()
    .with_stroke("push", [(310, 610), (330, 608)], radius_px=120, strength=0.6)
    .with_stroke("push", [(300, 600), (420, 600)], radius_px=70, strength=1.0)
)
_RELEASED: Final = {"loose": (((118.0, 0.0), (106.0, 899.0)),)}
_BY_HAND: Final = {"hand": (_STROKE, _BRUSH), "squeezed": (NOTHING, _AGAIN)}


def result(name: str) -> dict[str, Any]:
    """Return the landmarks, doubts, displacements and notes of a scene."""
    draw, settings = SCENES[name]
    photo = np.ascontiguousarray(draw())
    found = MeshSource().find(photo)
    told: dict[str, Any] = {
        "faces": [_rounded(face.points, 2) for face in found],
        "confidence": [_rounded(face.confidence, 2) for face in found],
        "score": [round(face.score, 2) for face in found],
    }
    which = "1" if name == "beside" else "all"
    try:
        chosen = choose(found, which, Box.of(photo), doubtful=name == "cut")
    except AllDoubted as doubts:
        return told | {"note": str(doubts)}
    protection, brushwork = _BY_HAND.get(name, (NOTHING, UNTOUCHED))
    applied = Applied(
        chosen.faces, Recipe(**settings), protection, others=chosen.others, brushwork=brushwork,
        loose=_RELEASED.get(name, ()),
    )  # fmt: skip
    finder = BackgroundFinder()
    rendering = render(
        photo, applied.faces, applied.recipe, protection=protection,
        held=held_of(photo, applied, finder), brushwork=brushwork,
    )  # fmt: skip
    xs, ys = (np.linspace(0, side - 1, _GRID) for side in photo.shape[1::-1])
    lines = measure(photo, rendering, applied, finder).lines
    return told | {
        "note": str(chosen.note),
        "edge": str(rendering.note),
        "displacement": _rounded(rendering.field.on_grid(xs, ys), _DIGITS),
        "shares": _rounded(rendering.shares, _DIGITS),
        "brush": _rounded(rendering.brush_shares, _DIGITS),
        "turns": _rounded([line.turn_degrees for line in lines], 2),
        "rises": _rounded(sorted(line.rise_permille for line in lines), 1),
        "holding": " ".join(line.holding for line in lines),
    }


def _seen(*given: Any) -> Face:
    """Return a template face as a detector gives one."""
    return dataclasses.replace(template_face(*given), source="mesh")


def statements() -> dict[str, Any]:
    """Return what is said of template faces on ladders of score, pose, place and distance."""
    face, photo = _seen((450.0, 450.0), 300.0), Box(0, 0, 900, 900)
    steps = np.linspace(0.05, 1.0, 20)
    alone = [dataclasses.replace(face, score=step) for step in steps]
    beside = _seen((150.0, 150.0), 240.0)
    crowded = [
        [dataclasses.replace(face, score=0.6), *[dataclasses.replace(beside, score=sure)] * count]
        for count in (1, 2, 4, 8, 16) for sure in (0.78, 0.85, 0.95)
    ]  # fmt: skip
    seen = [dataclasses.replace(face, confidence=np.full(len(face.points), step)) for step in steps]
    hidden = [
        dataclasses.replace(face, confidence=np.where(np.arange(len(face.points)) < count, 0.3, 1))
        for count in range(len(face.points))
    ]
    posed = [_seen((450.0, 450.0), 300.0, degrees) for degrees in range(0, 181, 10)]
    for matrix in (np.diag([step, 1.0]) for step in steps):
        posed.append(
            face.mapped(Affine(matrix, np.array([450.0, 450.0]) * (1.0 - np.diag(matrix))))
        )
    outside = [_seen((150.0 - x, 450.0), 300.0, 20.0) for x in range(0, 120, 4)]
    groups = [[one] for one in (*alone, *seen, *hidden, *outside)] + crowded
    groups += [[one, face] for one in posed] + [[posed[18], one] for one in posed[:18]]
    told = [str(verdicts(group, photo)[0].told(1)) for group in groups]
    notes = [str(distance_note(distance)) for distance in np.geomspace(0.15, 4.0, 24)]
    lens = [
        (distance_m(beside, focal, photo), stretch_percent(beside, focal, photo))
        for focal in (18.0, 26.0, 50.0, 85.0)
    ]
    blank, xs = np.zeros((600, 600), np.uint8), np.linspace(0.0, 599.0, _GRID)
    at_edges = [
        render(blank, [_seen((float(x), 300.0), 240.0)], Recipe(percent=8.0, scope=scope))
        for x in range(60, 200, 12) for scope in ("face", "head")
    ]  # fmt: skip
    dragged = face.with_target(4, face.outline[5] + 9.0)
    fitted = [
        render(blank, [dragged], Recipe(scope="face", guard=False, lattice=6.0, fit=fit))
        for fit in SETTINGS["fit"].choices
    ] + [
        render(blank, [_seen((x, 300.0), 110.0) for x in places], Recipe(percent=0.0, lens=mm))
        for *places, mm in ((20.0, 20.0), (90.0, 470.0, 24.0), (590.0, 12.0))
    ]  # fmt: skip
    turned = dataclasses.replace(
        face.with_outline_point(3, face.outline[3] - 25.0), eyes=face.eyes - (25.0, 0.0)
    )
    steep = Recipe(percent=10.0, scope="face", width=-9.0, jaw_width=-9.0)
    fitted += [render(blank, [face], steep), render(blank, [turned], Recipe(even_out=90.0))]
    return {
        "fits": _rounded([one.field.on_grid(xs, xs) for one in fitted], _DIGITS),
        "told": "; ".join(told),
        "notes": "; ".join(notes),
        "lens": _rounded(lens, _DIGITS),
        "edges": "; ".join(str(one.note) for one in at_edges),
        "displacement": _rounded([one.field.on_grid(xs, xs) for one in at_edges[::5]], _DIGITS),
    }


def steps_of_the_search() -> dict[str, Any]:
    """Return faces of computed heads, and outlines of computed edges."""
    found = [(k, one) for k, some in enumerate(heads.ON_THE_BRINK) for one in heads.found(some)]
    rng = np.random.default_rng(1)
    odds = 3.0 * rng.normal(size=(ALONG, len(MOVES))), 3.0 * rng.normal(size=ALONG)
    face, noise = (
        template_face((128.0, 120.0), 150.0),
        rng.integers(0, 256, (256, 256, 3), np.uint8),
    )
    one = Mesh(face.outline, face.eyes, face.mouth, face.outline, box_of(face), presence=1.0)
    other = dataclasses.replace(one, eyes=one.eyes + 1.0)
    crop = MeshInput(cv2.GaussianBlur(noise, (0, 0), 4.0), Affine.similarity(1.0, 0.0, (0.0, 0.0)))
    return {
        "corners": _rounded(
            _sure_corners(Passes(one, one, other, crop), np.full(21, 0.6)), _DIGITS
        ),
        "searched": _rounded([(k, *one.eye_center, one.score) for k, one in found], _DIGITS),
        "settled": _rounded([settle(*odds, beards=beards) for beards in (True, False)], _DIGITS),
    }


def aam_faces() -> dict[str, Any]:
    """Return what the AAM finds on a sample and under a mask."""
    source = AamSource()
    faces = source.find(_portrait()) + source.find(_covered(_portrait("men")))
    return {
        "points": [_rounded(face.points, 1) for face in faces],
        "confidence": [_rounded(face.confidence, 2) for face in faces],
    }


def all_results() -> Iterator[tuple[str, Any]]:
    """Yield the name and the result of each scene."""
    yield from ((name, result(name)) for name in SCENES)
    yield "aam", aam_faces()
    yield "search", steps_of_the_search()
    yield "statements", statements()


def difference(name: str, now: Any, then: Any) -> str:
    """Return a sentence on the first difference of two results, or "" if they are equal.

    Numbers may differ by the rounding of other processors and libraries.
    """
    for field in {**then, **now} if isinstance(then, dict) else ("",):
        a, b = (one.get(field) if field else one for one in (now, then))
        if isinstance(a, str) or isinstance(b, str) or a is None or b is None:
            if a != b:
                return f"{name}: {field} is {a!r}, was {b!r}"
        elif np.shape(a) != np.shape(b):
            return f"{name}: {field} has shape {np.shape(a)}, was {np.shape(b)}"
        elif (off := np.abs(np.subtract(a, b)).max(initial=0.0)) > _TOLERANCES.get(field, 0.02):
            return f"{name}: {field} differs by {off:.3f}"
    return ""


def _rounded(values: Any, digits: int) -> Any:
    return None if values is None else (np.round(values, digits) + 0.0).tolist()


if __name__ == "__main__":
    lines = (
        f'"{name}":{json.dumps(found, separators=(",", ":"))}' for name, found in all_results()
    )
    FILE.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")
