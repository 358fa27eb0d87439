"""What becomes of faces that are hard: covered, blurred, tiny, cut.

``python tests/benchmarks/hard_faces.py [DATA] [--source mesh] [--every 2] [--only mask]``

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

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from distortions import DISTORTIONS
from kogao_resources.training.evaluate import distance_to_line
from real_photos import picture_of

from kogao_core.base.geometry import Box
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


if __name__ == "__main__":
    main()
