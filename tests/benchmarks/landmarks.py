"""How well and how fast faces are found.

``python tests/benchmarks/landmarks.py [DATA] [--sources mesh aam]``

DATA is the folder of labelled photographs, ``KOGAO_SHARED`` or ``../shared/data`` when not given.
Errors are means over a face's points in % of its outer inter-ocular distance; a table cell is the
mean over faces (95th percentile, worst).
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from datetime import date
from pathlib import Path

import numpy as np
from kogao_resources.training.evaluate import (
    Errors,
    area_under_curve,
    errors,
    nearest,
    repeatability,
    summary,
)
from labelled import STUDIO, Sample, samples

from kogao_core.base.assets import AssetMissing
from kogao_core.base.geometry import Box
from kogao_core.base.machine import machine
from kogao_core.faces.doubt import Verdict, uncertain, verdicts
from kogao_core.faces.face import Face, LandmarkSource
from kogao_core.faces.landmarks import CHOICES

SOURCES: Mapping[str, Callable[[], LandmarkSource]] = {one.name: one.make for one in CHOICES}
SETS = (*STUDIO, "studio", "wild frontal", "wild turned", "wild")
LEAST_IN_GROUP = 7
GOOD, WRONG = 3.0, 5.0  # % of the outer inter-ocular distance
PACKAGES = ("numpy", "opencv-contrib-python-headless")
HEAD = "| eyes | mouth | jaw to outline |"


@dataclass(frozen=True)
class Finding:
    """What a source made of one labelled face."""

    sample: Sample
    face: Face | None
    verdict: Verdict
    milliseconds: float

    @property
    def errors(self) -> Errors:
        """All NaN when the face was missed."""
        if self.face is None:
            return Errors(np.nan, np.nan, np.nan)
        return errors(self.face, self.sample.labels)


def measured(source: LandmarkSource, sample: Sample) -> Finding:
    rgb = sample.read()
    start = time.perf_counter()
    found = source.find(rgb)
    milliseconds = (time.perf_counter() - start) * 1e3
    face = nearest(found, sample.labels)
    judged = dict(zip(map(id, found), verdicts(found, Box.of(rgb)), strict=True))
    verdict = judged.get(id(face), Verdict())
    return Finding(sample, face, verdict, milliseconds / max(1, len(found)))


def table(results: Mapping[str, list[Finding]]) -> Iterator[str]:
    """Markdown rows: one for each source and set."""
    yield f"| source | faces | found {HEAD} ms per face |"
    yield "|---|---|---|---|---|---|---|"
    for source, outcomes in results.items():
        for name in SETS:
            group = [one for one in outcomes if name in one.sample.sets]
            found = sum(one.face is not None for one in group)
            speed = np.median([one.milliseconds for one in group])
            cells = _cells([one.errors for one in group])
            yield f"| {source} | {name} | {found}/{len(group)} | {cells} | {speed:.0f} |"
    labelled = [one.sample for one in next(iter(results.values()))]
    again = [repeatability(one.labels, one.again) for one in labelled if one.again]
    yield f"| second pass of labels | wild | {len(again)} | {_cells(again)} | |"


def groups(results: Mapping[str, list[Finding]]) -> Iterator[str]:
    """Markdown rows: one for each source and group of people, and who are too few to judge."""
    yield f"| source | group | faces {HEAD} mean's 95 % interval | below 3 % | above 5 % |"
    yield "|" + "---|" * 9
    few = set()
    for source, outcomes in results.items():
        names = {(one.sample.sets[0], group) for one in outcomes for group in one.sample.groups}
        for origin, group in sorted(names):
            members = [
                one.errors
                for one in outcomes
                if one.sample.sets[0] == origin and group in one.sample.groups
            ]
            label = f"{origin}, {group.replace('_', ' ')}"
            if len(members) < LEAST_IN_GROUP:
                few.add(f"{label} ({len(members)})")
                continue
            jaws = np.array([one.jaw for one in members])
            low, high = interval(jaws)
            good, wrong = (jaws < GOOD).mean(), (jaws > WRONG).sum()
            yield (
                f"| {source} | {label} | {len(members)} | {_cells(members)} "
                f"| {low:.2f} to {high:.2f} | {100 * good:.0f} % | {wrong} |"
            )
    yield f"\nNot judged, for there are fewer than {LEAST_IN_GROUP}: {', '.join(sorted(few))}."


def interval(values: np.ndarray) -> tuple[float, float]:
    """Return the 95 % interval of a mean by resampling faces, the same each time."""
    seen = values[~np.isnan(values)]
    picks = np.random.default_rng(0).integers(0, len(seen), (4000, len(seen)))
    low, high = np.percentile(seen[picks].mean(axis=1), (2.5, 97.5))
    return float(low), float(high)


def honesty(results: Mapping[str, list[Finding]]) -> Iterator[str]:
    """Markdown rows: whether doubt and confidence know which faces and points are wrong."""
    yield (
        f"| source | faces | outline > {WRONG:g} % | of these doubted, marked "
        "| doubted, marked of all | area: share of uncertain points | eyes | mouth |"
    )
    yield "|" + "---|" * 8
    for source, outcomes in results.items():
        for name in ("studio", "wild"):
            found = [one for one in outcomes if name in one.sample.sets and one.face is not None]
            wrong = np.array([one.errors.jaw > WRONG for one in found])
            judged = [one.verdict for one in found]
            doubted = np.array([one.reason is not None for one in judged])
            marked = np.array([bool(one.look_at) for one in judged])
            share = np.array([len(uncertain(one.face)) for one in found])
            areas = [
                area_under_curve(share[~wrong], share[wrong]),
                *(_area_of_points(found, rows) for rows in (slice(0, 4), slice(4, 6))),
            ]
            cells = " | ".join(f"{area:.2f}" for area in areas)
            yield (
                f"| {source} | {name}, {len(found)} | {wrong.sum()} "
                f"| {(doubted & wrong).sum()}, {(marked & wrong).sum()} "
                f"| {doubted.sum()}, {marked.sum()} | {cells} |"
            )


def _area_of_points(found: list[Finding], rows: slice) -> float:
    """Return how often a corner more than `WRONG` off has less confidence than another one."""
    off, sure = [], []
    for one in found:
        assert one.face is not None
        if one.face.confidence is None:
            return float("nan")
        labels = one.sample.labels
        corners = np.vstack([one.face.eyes, one.face.mouth])
        apart = np.linalg.norm(corners - np.vstack([labels.eyes, labels.mouth]), axis=1)
        off.append((apart / labels.unit_px)[rows])
        sure.append(one.face.confidence[-6:][rows])
    wrong = np.concatenate(off) > WRONG
    confidence = np.concatenate(sure)
    return area_under_curve(confidence[wrong], confidence[~wrong])


def _cells(rows: list[Errors]) -> str:
    columns = np.array(rows, np.float64).reshape(-1, 3).T
    return " | ".join("{:.2f} ({:.2f}, {:.1f})".format(*summary(column)) for column in columns)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    default = os.environ.get("KOGAO_SHARED", "../shared/data")
    parser.add_argument("data", nargs="?", type=Path, default=Path(default))
    parser.add_argument("--sources", nargs="+", choices=list(SOURCES), default=list(SOURCES))
    arguments = parser.parse_args()
    try:
        faces = samples(arguments.data)
    except (OSError, ValueError) as problem:
        parser.error(f"{problem}; name the folder of labelled photographs or set KOGAO_SHARED")
    results = {}
    for name in arguments.sources:
        try:
            finder = SOURCES[name]()
            finder.find(faces[0].read())  # reads the model
            results[name] = [measured(finder, sample) for sample in faces]
        except AssetMissing as missing:
            print(f"{name}: absent ({missing})")
    if not results:
        parser.exit(1)
    tables = table(results), honesty(results), groups(results)
    facts = machine()
    versions = ", ".join(f"{name} {facts['packages'][name]}" for name in PACKAGES)
    print(f"{date.today()}, {facts['processor']}, {facts['cores']} cores, {versions}")
    print(*("\n".join(["", *rows]) for rows in tables), sep="\n")


if __name__ == "__main__":
    main()
