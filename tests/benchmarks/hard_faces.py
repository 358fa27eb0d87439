"""What becomes of faces that are hard: covered, blurred, tiny, cut, and where there is none.

``python tests/benchmarks/hard_faces.py [DATA] [--source mesh] [--every 2] [--only mask nobody]``

Each portrait of DATA (``KOGAO_SHARED`` or ``../shared/data`` when not given) is searched as it is,
at most 600 px high, distorted in every way of ``distortions.py``, and searched again. Distances are
from the face found undistorted, carried along, in % of its outer inter-ocular distance.
"""

from __future__ import annotations

import argparse
import os
import sys
import zlib
from collections.abc import Iterator, Sequence
from pathlib import Path

import cv2
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from core.test_no_face import pictures
from distortions import DISTORTIONS
from kogao_resources.training.evaluate import distance_to_line
from real_photos import picture_of

from kogao_core.base.geometry import Box, Image
from kogao_core.faces.doubt import verdicts
from kogao_core.faces.face import Face, LandmarkSource
from kogao_core.faces.landmarks import source

LONGEST_PX = 600.0
_SAME_PLACE = 1.0  # outer inter-ocular distances
_ON_ITS_HEAD = 120.0  # degrees
_WRONG = 5.0  # %


def tilt(face: Face) -> float:
    """Return the roll of the line between the outer eye corners, degrees."""
    x, y = face.eyes[3] - face.eyes[0]
    return float(np.degrees(np.arctan2(y, x)))


def apart(face: Face, truth: Face) -> tuple[float, float, float]:
    """Return how far outline, eyes and mouth are from the truth, %."""
    unit = truth.interocular_px / 100.0
    eyes = np.linalg.norm(face.eyes - truth.eyes, axis=1).mean()
    mouth = np.linalg.norm(face.mouth - truth.mouth, axis=1).mean()
    outline = distance_to_line(face.outline, truth.outline).mean()
    return outline / unit, eyes / unit, mouth / unit


def rows(finder: LandmarkSource, portraits: Sequence[Path], only: Sequence[str]) -> Iterator[str]:
    """Markdown rows: one for each distortion."""
    known = []
    for path in portraits:
        picture = picture_of(path, LONGEST_PX)
        faces = finder.find(picture)
        if len(faces) == 1:
            known.append((path.stem, picture, faces[0]))
    yield (
        "| distortion | faces | found | on their heads | others | doubted | marked "
        "| outline (p90, most) | eyes | mouth | outline > 5 %: doubted or marked |"
    )
    yield "|" + "---|" * 11
    for name, distort in DISTORTIONS.items():
        if only and not any(one in name for one in only):
            continue
        off, told, upside_down, others, doubted, marked = [], [], 0, 0, 0, 0
        for stem, picture, face in known:
            rng = np.random.default_rng(zlib.crc32(f"{stem} {name}".encode()))
            distorted, change = distort(picture, face, rng)
            truth, image = face.mapped(change), Box.of(distorted)
            found = finder.find(distorted)
            judged = dict(zip(map(id, found), verdicts(found, image), strict=True))
            near = [one for one in found if _near(one, truth)]
            others += len(found) - len(near[:1])
            for one in near[:1]:
                turned = abs((tilt(one) - tilt(truth) + 180.0) % 360.0 - 180.0) > _ON_ITS_HEAD
                upside_down += turned
                verdict = judged[id(one)]
                doubted += verdict.reason is not None
                marked += bool(verdict.look_at)
                if not turned:
                    off.append(apart(one, truth))
                    told.append(verdict.reason is not None or bool(verdict.look_at))
        outline, eyes, mouth = np.array(off).reshape(-1, 3).T
        wrong = outline > _WRONG
        worst = (np.percentile(outline, 90), outline.max()) if len(outline) else (np.nan, np.nan)
        yield (
            f"| {name} | {len(known)} | {len(off) + upside_down} | {upside_down} | {others} "
            f"| {doubted} | {marked} | {np.mean(outline):.2f} ({worst[0]:.1f}, {worst[1]:.1f}) "
            f"| {np.mean(eyes):.2f} | {np.mean(mouth):.2f} "
            f"| {np.array(told, bool)[wrong].sum()} of {wrong.sum()} |"
        )


def _near(one: Face, truth: Face) -> bool:
    return float(np.linalg.norm(one.middle - truth.middle)) < _SAME_PLACE * truth.interocular_px


def nobody() -> dict[str, Image]:
    """Return pictures without a face: scikit-image's samples and drawings of round things."""
    found = {path.name: picture_of(path) for path in pictures()}
    return {**found, **drawings()}


def drawings() -> dict[str, Image]:
    """Return drawings of what is round or has two dark spots, and no face."""
    rng = np.random.default_rng(5)
    result = {}
    for name in ("balls", "target", "clock", "lamps", "buttons", "fist", "cloth", "leaves"):
        picture = np.full((480, 640, 3), 205, np.uint8)
        picture = np.clip(picture + rng.normal(0, 6, picture.shape), 0, 255).astype(np.uint8)
        _DRAWN[name](picture, rng)
        result[name] = np.asarray(cv2.GaussianBlur(picture, (0, 0), 1.2))
    return result


def _balls(picture: Image, rng: np.random.Generator) -> None:
    for _ in range(9):
        middle = rng.integers(60, (580, 420))
        radius = int(rng.integers(30, 90))
        for share in np.linspace(1.0, 0.0, 24):
            tone = np.array((200, 160, 130)) * (1.0 - 0.6 * share)
            at = (middle - 0.3 * radius * (1.0 - share)).astype(int)
            cv2.circle(picture, tuple(at.tolist()), round(radius * share), tone.tolist(), -1)


def _target(picture: Image, _: np.random.Generator) -> None:
    for ring in range(8, 0, -1):
        cv2.circle(picture, (320, 240), 25 * ring, (190, 60, 50) if ring % 2 else (240,) * 3, -1)


def _clock(picture: Image, _: np.random.Generator) -> None:
    cv2.circle(picture, (320, 240), 190, (245, 240, 225), -1)
    cv2.circle(picture, (320, 240), 190, (60, 40, 30), 12)
    for hour in range(12):
        turn = np.deg2rad(30.0 * hour)
        at = (320 + 155 * np.sin(turn), 240 - 155 * np.cos(turn))
        cv2.circle(picture, tuple(map(round, at)), 10, (40, 30, 30), -1)
    cv2.line(picture, (320, 240), (250, 170), (20, 20, 20), 10)
    cv2.line(picture, (320, 240), (430, 150), (20, 20, 20), 7)


def _lamps(picture: Image, _: np.random.Generator) -> None:
    cv2.rectangle(picture, (120, 150), (520, 380), (120, 20, 25), -1)
    for x in (200, 440):
        cv2.circle(picture, (x, 230), 48, (235, 235, 225), -1)
        cv2.circle(picture, (x, 230), 22, (90, 90, 95), -1)
    cv2.rectangle(picture, (240, 290), (400, 345), (25, 25, 28), -1)


def _buttons(picture: Image, _: np.random.Generator) -> None:
    for x, y in ((200, 150), (420, 160), (300, 330)):
        cv2.circle(picture, (x, y), 85, (185, 150, 110), -1)
        for u, v in ((-25, -20), (25, -20), (-25, 25), (25, 25)):
            cv2.circle(picture, (x + u, y + v), 12, (40, 30, 25), -1)


def _fist(picture: Image, _: np.random.Generator) -> None:
    cv2.ellipse(picture, (320, 260), (150, 130), 0, 0, 360, (205, 155, 125), -1)
    for finger in range(4):
        middle = (215 + 70 * finger, 200)
        cv2.ellipse(picture, middle, (36, 70), 0, 0, 360, (215, 165, 135), -1)
        cv2.ellipse(picture, middle, (36, 70), 0, 0, 360, (140, 95, 75), 4)
    cv2.ellipse(picture, (270, 320), (120, 34), -12, 0, 360, (210, 160, 130), -1)
    cv2.ellipse(picture, (270, 320), (120, 34), -12, 0, 360, (140, 95, 75), 4)


def _cloth(picture: Image, _: np.random.Generator) -> None:
    y, x = np.mgrid[:480, :640] / 100.0
    folds = np.sin(3.0 * x + 1.7 * np.sin(2.0 * y)) + 0.6 * np.sin(5.0 * y + 2.0 * np.cos(1.3 * x))
    picture[:] = np.clip(120.0 + 38.0 * folds, 0, 255).astype(np.uint8)[..., None]


def _leaves(picture: Image, rng: np.random.Generator) -> None:
    for _ in range(160):
        middle = tuple(rng.integers(0, (640, 480)).tolist())
        tone = (np.array((70, 120, 50)) * rng.uniform(0.5, 1.4)).tolist()
        size = tuple(rng.integers(12, 48, 2).tolist())
        cv2.ellipse(picture, middle, size, float(rng.uniform(0, 180)), 0, 360, tone, -1)


_DRAWN = {
    "balls": _balls,
    "target": _target,
    "clock": _clock,
    "lamps": _lamps,
    "buttons": _buttons,
    "fist": _fist,
    "cloth": _cloth,
    "leaves": _leaves,
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    default = os.environ.get("KOGAO_SHARED", "../shared/data")
    parser.add_argument("data", nargs="?", type=Path, default=Path(default))
    parser.add_argument("--source", default="mesh")
    parser.add_argument("--every", type=int, default=2, help="of the portraits, sorted by name")
    parser.add_argument("--first", type=int, default=0, help="number of the first portrait")
    parser.add_argument("--only", nargs="+", default=(), metavar="WORD")
    arguments = parser.parse_args()
    finder = source(arguments.source)
    portraits = sorted((arguments.data / "portraits").glob("*.jpg"))
    if not portraits:
        parser.error(f"no portraits in {arguments.data}; name the folder or set KOGAO_SHARED")
    chosen = portraits[arguments.first :: arguments.every]
    for row in rows(finder, chosen, arguments.only):
        print(row, flush=True)
    if not arguments.only or "nobody" in arguments.only:
        empty = nobody()
        wrong = {name: finder.find(picture) for name, picture in empty.items()}
        told = [
            f"{name} {', '.join(f'{one.score:.2f}' for one in faces)}"
            for name, faces in wrong.items()
            if faces
        ]
        count = sum(map(len, wrong.values()))
        print(f"\nwithout a face: {len(empty)} pictures, {count} faces: {'; '.join(told)}")


if __name__ == "__main__":
    main()
