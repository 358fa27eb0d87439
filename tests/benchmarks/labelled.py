"""Faces with labels: the studio sets' 189 points, and our own labels of faces in the wild."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from kogao_resources.training.evaluate import Labels

from kogao_core.base.geometry import Image
from kogao_core.faces.landmarks.aam.points import EYE_LABELS
from kogao_core.photo.picture import sha256_of

STUDIO = ("frll", "canada", "composites")
OURS = Path(__file__).resolve().parents[1] / "labels" / "faces.json"
# Rows of the 189 points; the chin is 129.
_EYES, _MOUTH, _JAW = list(EYE_LABELS), [87, 93], slice(125, 134)


@dataclass(frozen=True)
class Sample:
    """One labelled face and where its pixels are."""

    name: str
    sets: tuple[str, ...]
    groups: tuple[str, ...]
    picture: Path
    labels: Labels
    crop: tuple[int, int, int, int] | None = None  # left, top, width, height
    again: Labels | None = None  # the second pass of hand labels

    def read(self) -> Image:
        rgb = cv2.cvtColor(cv2.imread(str(self.picture)), cv2.COLOR_BGR2RGB)
        if self.crop is None:
            return rgb
        left, top, width, height = self.crop
        return np.ascontiguousarray(rgb[top : top + height, left : left + width])


def samples(data: Path) -> list[Sample]:
    """Return every labelled face of a data folder; raise ValueError if a picture isn't the one."""
    return [*_studio(data), *_wild(data)]


def _studio(data: Path) -> Iterator[Sample]:
    with (data / "frll" / "people.csv").open(encoding="utf-8") as stream:
        people = {row["id"]: row for row in csv.DictReader(stream)}
    for folder in STUDIO:
        for picture in sorted((data / folder).glob("*.jpg")):
            marks = picture.with_suffix(".csv")
            if not marks.exists():  # smiling faces have none
                continue
            points = np.loadtxt(marks, delimiter=",", skiprows=1)
            yield Sample(
                name=f"{folder}/{picture.stem}",
                sets=(folder, "studio"),
                groups=_groups(folder, picture.stem, people),
                picture=picture,
                labels=Labels(points[_EYES], points[_MOUTH], points[_JAW]),
            )


def _groups(folder: str, name: str, people: dict[str, dict[str, str]]) -> tuple[str, ...]:
    if folder != "frll":
        return ()
    row = people[name.split("_")[0]]
    origin = row["face_eth"].split("/")[0].replace("_", " ")
    if not row["face_age"].isdigit():
        return (row["face_gender"], origin)
    return (row["face_gender"], origin, "under 30" if int(row["face_age"]) < 30 else "30 and over")


def _wild(data: Path) -> Iterator[Sample]:
    for face in json.loads(OURS.read_text(encoding="utf-8"))["faces"]:
        picture = data / face["file"]
        if sha256_of(picture) != face["sha256"]:
            raise ValueError(f"{picture} isn't the picture that was labelled")
        view = "turned" if "turned" in face["tags"] else "frontal"
        opposites = [f"no {tag}" for tag in ("beard", "glasses") if tag not in face["tags"]]
        yield Sample(
            name=face["id"],
            sets=("wild", f"wild {view}"),
            groups=(*face["tags"], *opposites),
            picture=picture,
            labels=Labels.of(face["first"]),
            crop=tuple(face["crop"]) if "crop" in face else None,
            again=Labels.of(face["second"]),
        )
