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
_WRONG = 5.0  # %


def rows(finder: LandmarkSource, portraits: Sequence[Path], only: Sequence[str]) -> Iterator[str]:
    """Yield Markdown rows: one for each distortion."""
    known = []
    for path in portraits:
        picture = picture_of(path, LONGEST_PX)
        faces = finder.find(picture)
        if len(faces) == 1:
            known.append((path.stem, picture, faces[0]))
    yield (
        "| distortion | faces | found | others | doubted | marked | outline (p90, most) "
        "| outline > 5 %: doubted or marked |"
    )
    yield "|" + "---|" * 8
    for name, distort in DISTORTIONS.items():
        if only and not any(one in name for one in only):
            continue
        outlines, doubted, marked, others = [], [], [], 0
        for stem, picture, face in known:
            rng = np.random.default_rng(zlib.crc32(f"{stem} {name}".encode()))
            distorted, change = distort(picture, face, rng)
            truth = face.mapped(change)
            found = finder.find(distorted)
            judged = zip(found, verdicts(found, Box.of(distorted)), strict=True)
            near = [(one, verdict) for one, verdict in judged if _near(one, truth)]
            others += len(found) - len(near[:1])
            for one, verdict in near[:1]:
                off = distance_to_line(one.outline, truth.outline).mean()
                outlines.append(100.0 * off / truth.interocular_px)
                doubted.append(verdict.reason is not None)
                marked.append(bool(verdict.look_at))
        outline = np.array(outlines or [np.nan])
        wrong = outline > _WRONG
        reported = np.logical_or(doubted, marked)[wrong[: len(doubted)]]
        yield (
            f"| {name} | {len(known)} | {len(outlines)} | {others} "
            f"| {sum(doubted)} | {sum(marked)} | {outline.mean():.2f} "
            f"({np.percentile(outline, 90):.1f}, {outline.max():.1f}) "
            f"| {reported.sum()} of {wrong.sum()} |"
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
