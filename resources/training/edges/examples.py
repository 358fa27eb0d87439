"""Training examples from labelled faces."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import numpy as np

from kogao_core.base.geometry import Array, Image
from kogao_core.faces.landmarks.aam.points import EYE_LABELS, OUTLINE_LABELS
from kogao_core.faces.landmarks.edges import smooth
from kogao_core.faces.landmarks.mesh import MeshSource
from kogao_core.faces.landmarks.pixels import Pyramid

from ..aam.detected import read
from ..evaluate import Labels, distance_to_line, nearest
from .learn import LabelledCut, labelled_cut

STUDIO: Final = ("canada", "composites", "frll")
_MOUTH: Final = [87, 93]
_JAW: Final = slice(125, 134)
_WILD_WEIGHT: Final = 2.0
_BEARD_WEIGHT: Final = 4.0
_BEARD_ALONE_WEIGHT: Final = 2.0


def studio(data: Path) -> Iterator[tuple[LabelledCut, Labels]]:
    """Yield the faces with 189 labelled points in a folder of photographs."""
    source = MeshSource(refined=False)
    for folder in STUDIO:
        for picture in sorted((data / folder).glob("*.jpg")):
            if picture.with_suffix(".csv").exists():
                points = np.loadtxt(picture.with_suffix(".csv"), delimiter=",", skiprows=1)
                labels = Labels(points[list(EYE_LABELS)], points[_MOUTH], points[_JAW])
                line = smooth(smooth(points[list(OUTLINE_LABELS)]))
                yield from _example(
                    source, picture, read(picture), labels, line, 1.0, (folder, "studio")
                )


def wild(data: Path, table: Path) -> Iterator[tuple[LabelledCut, Labels]]:
    """Yield the hand-labelled faces of a table; each pass of a face is a separate example."""
    source = MeshSource(refined=False)
    for face in json.loads(table.read_text(encoding="utf-8"))["faces"]:
        image = _picture(data, face)
        passes = [face[name] for name in ("first", "second") if name in face]
        bearded = "beard" in face["tags"]
        weight = (_BEARD_WEIGHT if bearded else _WILD_WEIGHT) / len(passes)
        name = data / face["file"] / face["id"]
        tags = (face["file"].split("/")[0], "wild", "beard" if bearded else "no beard")
        for one in passes:
            labels = Labels.of(one)
            yield from _example(source, name, image, labels, labels.jaw, weight, tags)


def beards(data: Path, table: Path) -> Iterator[LabelledCut]:
    """Yield the faces of a table with labels for all or a part of a beard's edge only."""
    source = MeshSource(refined=False)
    for edge in json.loads(table.read_text(encoding="utf-8"))["edges"]:
        image, line = _picture(data, edge), np.array(edge["outline"])
        face = min(source.find(image), key=lambda one: distance_to_line(line, one.outline).mean())
        name = str(data / edge["file"])
        yield labelled_cut(name, Pyramid(image), face, line, (), _BEARD_ALONE_WEIGHT)


def _picture(data: Path, face: dict[str, Any]) -> Image:
    image = read(data / face["file"])
    if "crop" not in face:
        return image
    left, top, width, height = face["crop"]
    return np.ascontiguousarray(image[top : top + height, left : left + width])


def _example(
    source: MeshSource,
    name: Path,
    image: Image,
    labels: Labels,
    line: Array,
    weight: float,
    tags: tuple[str, ...],
) -> Iterator[tuple[LabelledCut, Labels]]:
    face = nearest(source.find(image), labels)
    if face is not None:
        seen = np.ones(6 + len(line), bool) if labels.seen is None else labels.seen
        hidden = np.flatnonzero(~seen[6:]).tolist()
        cut = labelled_cut(str(name), Pyramid(image), face, line, hidden, weight, tags)
        yield cut, labels
