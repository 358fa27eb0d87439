"""How well and how fast faces are found: `python tests/benchmarks/landmarks.py ../shared/data`."""

from __future__ import annotations

import sys
import time
from pathlib import Path

import cv2
import numpy as np

from kogao_core.face import Face
from kogao_core.geometry import Array
from kogao_core.landmarks import MeshSource

LABELLED = ("frll", "canada", "composites")
UNLABELLED = ("portraits", "headshots", "large", "groups", "synthetic")
EYES, MOUTH, JAW = (18, 22, 23, 27), (87, 93), slice(125, 134)


def read(path: Path) -> np.ndarray:
    return cv2.cvtColor(cv2.imread(str(path)), cv2.COLOR_BGR2RGB)


def labels_of(picture: Path) -> Array:
    return np.loadtxt(picture.with_suffix(".csv"), delimiter=",", skiprows=1)


def distance_to_line(points: Array, line: Array) -> Array:
    """Distance of each point to a polyline."""
    start, along = line[:-1], np.diff(line, axis=0)
    t = ((points[:, None] - start) * along).sum(axis=-1) / (along**2).sum(axis=-1)
    nearest = start + np.clip(t, 0.0, 1.0)[..., None] * along
    return np.linalg.norm(points[:, None] - nearest, axis=-1).min(axis=1)


def errors_percent(face: Face, labels: Array) -> tuple[float, float, float]:
    """Mean error of eyes, mouth and jaw-to-outline in % of the outer inter-ocular distance."""
    unit = np.linalg.norm(labels[EYES[3]] - labels[EYES[0]]) / 100.0
    eyes = np.linalg.norm(face.eyes - labels[list(EYES)], axis=1).mean()
    mouth = np.linalg.norm(face.mouth - labels[list(MOUTH)], axis=1).mean()
    jaw = distance_to_line(labels[JAW], face.outline).mean()
    return eyes / unit, mouth / unit, jaw / unit


def main(data: Path) -> None:
    source = MeshSource()
    source.find(read(data / "composites" / "f_african.jpg"))
    print(f"{'':12}{'photos':>7}{'with':>6}{'faces':>7}{'ms/photo':>9}{'ms/face':>8}", end="   ")
    print("eyes, mouth, jaw: mean (p95) in % of the outer inter-ocular distance")
    for name in (*LABELLED, *UNLABELLED):
        pictures = sorted((data / name).glob("*.jpg"))
        errors, faces_found, photos_found, seconds = [], 0, 0, 0.0
        for picture in pictures:
            rgb = read(picture)
            start = time.perf_counter()
            faces = source.find(rgb)
            seconds += time.perf_counter() - start
            faces_found += len(faces)
            photos_found += bool(faces)
            if faces and picture.with_suffix(".csv").exists():
                errors.append(errors_percent(faces[0], labels_of(picture)))
        line = f"{name:12}{len(pictures):7}{photos_found:6}{faces_found:7}"
        line += f"{seconds / len(pictures) * 1e3:9.0f}{seconds / max(1, faces_found) * 1e3:8.0f}   "
        for column in np.array(errors).reshape(-1, 3).T if errors else ():
            line += f"{column.mean():.2f} ({np.percentile(column, 95):.2f})  "
        print(line, flush=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
