"""Measure a model on labelled faces left out of training."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from kogao_core.faces.face import Face
from kogao_core.faces.landmarks.aam.points import EYES, MOUTH, OUTLINE
from kogao_core.faces.landmarks.aam.source import AamSource

from .. import evaluate
from ..evaluate import Labels
from .detected import read
from .faces import STUDIO, Photographed
from .labels import Labeller

_JAW_LABELS: Final = slice(125, 134)
_LIMITS: Final = (5.0, 8.0)


@dataclass(frozen=True, eq=False)
class Truth:
    """One labelled face, px of the photograph; `tags` are rows of the table."""

    path: Path
    labels: Labels
    tags: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class FaceErrors:
    """Errors in % for eyes, mouth, jaw and their mean; infinite if no face was found."""

    tags: tuple[str, ...]
    errors: tuple[float, ...]
    score: float


def truths(faces: Sequence[Photographed], labeller: Labeller) -> Iterator[Truth]:
    """Yield labels of held-out faces: hand labels in the studio, the mesh's elsewhere."""
    for face in faces:
        shape = face.to_photo(labeller.points(face.view.mesh, face.person))
        jaw = shape[OUTLINE]
        if face.labels is not None:
            jaw = face.to_photo(face.labels[_JAW_LABELS])
        by = "by hand" if face.labels is not None else "by the mesh"
        where = "studio" if face.folder in STUDIO else "in the wild"
        tags = (face.folder, f"{where}, labelled {by}", *_person_tags(face))
        yield Truth(face.path, Labels(shape[EYES], shape[MOUTH], jaw), tags)


def _person_tags(face: Photographed) -> tuple[str, ...]:
    if face.folder != "frll" or face.labels is None:
        return ()
    with (face.path.parent / "people.csv").open(encoding="utf-8", newline="") as stream:
        rows = {row["id"]: row for row in csv.DictReader(stream)}
    row = rows[face.path.stem.split("_")[0]]
    tags = (f"frll, {row['face_gender']}", f"frll, {row['face_eth']}")
    if not row["face_age"].isdigit():
        return tags
    return (*tags, "frll, age 30 and more" if int(row["face_age"]) >= 30 else "frll, age below 30")


def hand_labelled(file: Path, data: Path) -> Iterator[Truth]:
    """Yield the faces of a file of hand labels such as ``tests/labels/faces.json``."""
    for entry in json.loads(file.read_text(encoding="utf-8"))["faces"]:
        labels = Labels.of(entry["first"], entry.get("crop", (0.0, 0.0))[:2])
        tags = ("in the wild, labelled by hand", *(f"by hand, {tag}" for tag in entry["tags"]))
        yield Truth(data / entry["file"], labels, tags)


def results(model: Path, known: Sequence[Truth]) -> list[FaceErrors]:
    """Run the complete source, detection included, on the photographs of labelled faces."""
    source = AamSource(model)
    found: dict[Path, list[Face]] = {}
    for one in known:
        if one.path not in found:
            found[one.path] = source.find(read(one.path))
    return [_result(one, found[one.path]) for one in known]


def _result(one: Truth, found: Sequence[Face]) -> FaceErrors:
    face = evaluate.nearest(found, one.labels)
    if face is None:
        return FaceErrors(one.tags, (np.inf,) * 4, 0.0)
    errors = evaluate.errors(face, one.labels)
    return FaceErrors(one.tags, (*errors, float(np.nanmean(errors))), face.score)


def table(found: Sequence[FaceErrors]) -> Iterator[str]:
    """Yield the lines of a Markdown table, one row per tag: mean (95th percentile) of the found."""
    limits = " | ".join(f"below {limit:.0f} %" for limit in _LIMITS)
    yield f"| faces | number | found | eyes | mouth | jaw | mean of the three | {limits} |"
    yield "|---|" + (6 + len(_LIMITS)) * "---|"
    for tag in sorted({tag for one in found for tag in one.tags}):
        errors = np.array([one.errors for one in found if tag in one.tags])
        seen = errors[np.isfinite(errors[:, 3])]
        cells = [evaluate.summary(column) for column in seen.T]
        means = " | ".join(f"{cell.mean:.2f} ({cell.p95:.2f})" for cell in cells)
        below = " | ".join(
            f"{100 * share:.0f} %" for share in evaluate.share_below(errors[:, 3], _LIMITS)
        )
        yield f"| {tag} | {len(errors)} | {len(seen)} | {means} | {below} |"


def area_under_curve(found: Sequence[FaceErrors], far_percent: float) -> float:
    """Return how often a bad fit scores less than a good fit; 0.5 is chance, 1 perfect."""
    error = np.array([one.errors[3] for one in found])
    score = np.array([one.score for one in found])
    bad, good = score[(error > far_percent) & np.isfinite(error)], score[error <= far_percent]
    return evaluate.area_under_curve(bad, good)
