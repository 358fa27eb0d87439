"""Read retouches of portraits, and other photos of the same persons, and print a table.

``python tests/benchmarks/reading.py FOLDER``

FOLDER has ``portraits`` (every third is retouched) and ``frll`` (every second person: neutral and
smiling).
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from slimming import curves

import kogao_core as kogao
from kogao_core.base.geometry import Array, Image
from kogao_core.faces.face import Face
from kogao_core.field.field import shown_at
from kogao_core.field.measures import measures
from kogao_core.reading.displacement import read_faces
from kogao_core.reading.flow import NotRead
from kogao_core.recipe.recipe import SETTINGS, SHAPE, Recipe


def exported(pixels: Image, smoothing: float, quality: int, scale: float = 1.0) -> Image:
    """Return a copy with a tone curve, smooth skin, another size and JPEG losses."""
    toned = np.clip(255.0 * (pixels / 255.0) ** 0.8 * 1.05, 0, 255).astype(np.uint8)
    smooth = cv2.bilateralFilter(toned, 11, 50, 11)
    copy = cv2.addWeighted(toned, 1.0 - smoothing, smooth, smoothing, 0)
    copy = cv2.resize(copy, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    return cv2.imdecode(cv2.imencode(".jpg", copy, [cv2.IMWRITE_JPEG_QUALITY, quality])[1], 1)


def retouched(photo: Image, face: Face, chance: np.random.Generator) -> dict[str, Any]:
    """Return copies by kind, each with the displacement field."""
    settings = {"percent": chance.uniform(2, 9), "hold_background": bool(chance.integers(2))}
    for name in chance.choice(SHAPE, 2, replace=False).tolist():
        settings[name] = float(np.clip(chance.uniform(-5, 5), *SETTINGS[name].within))
    own = kogao.render(photo, [face], Recipe(**settings))
    field, thin = curves(photo, face, 2.0)
    return {
        "own settings": (exported(own.pixels, 0.4, 88), own.field),
        "a thin-face formula of live filters": (exported(thin, 0.4, 88), field),
        "the same at 60 %, heavy smoothing, JPEG 80": (exported(thin, 0.75, 80, 0.6), field),
        "nothing moved": (exported(photo, 0.4, 88), None),
    }


def main() -> None:
    """Measure and print."""
    folder, source, chance = Path(sys.argv[1]), kogao.source(), np.random.default_rng(0)
    errors: dict[str, list[float]] = {}

    def face_of(file: Path) -> tuple[Image, Face | None]:
        photo = np.ascontiguousarray(kogao.read(file).pixels[..., :3])
        found = source.find(photo)
        return photo, max(found, key=lambda one: one.interocular_px) if found else None

    def read(kind: str, photo: Image, copy: Image, face: Face, outline: Array) -> None:
        try:
            (reading,) = read_faces(photo, copy, [face])
            away = np.linalg.norm(reading.outline - outline, axis=1).mean()
        except NotRead:
            away = np.nan
        errors.setdefault(kind, []).append(100.0 * float(away) / measures(face).width_px)

    for file in sorted((folder / "portraits").glob("*.jpg"))[::3]:
        photo, face = face_of(file)
        if face is not None:
            for kind, (copy, field) in retouched(photo, face, chance).items():
                outline = face.outline if field is None else shown_at(field, face.outline)
                read(kind, photo, copy, face, outline)
    files = sorted((folder / "frll").glob("*_neutral.jpg"))[::2]
    for file, next_file in zip(files, files[1:] + files[:1], strict=True):
        (photo, face), (other, _) = face_of(file), face_of(next_file)
        smile, smiling = face_of(file.with_name(file.name.replace("neutral", "smiling")))
        if face is not None and smiling is not None:
            read("neutral, then smiling", photo, smile, face, face.outline)
            read("smiling, then neutral", smile, photo, smiling, smiling.outline)
            read("another person", photo, other, face, face.outline)
    print("| copy | pairs | refused | median error | 90 % |\n|---|---|---|---|---|")
    for kind, found in errors.items():
        known = [one for one in found if np.isfinite(one)] or [np.nan]
        middle, worst = np.percentile(known, (50, 90))
        refused = len(found) - np.isfinite(found).sum()
        print(f"| {kind} | {len(found)} | {refused} | {middle:.3f} | {worst:.3f} |")


if __name__ == "__main__":
    main()
