"""``kogao-cli detect``: positions of the faces and their 27 landmarks."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from kogao_core.additions.lens import (
    NOSE_SEEN_PERCENT,
    distance_m,
    distance_note,
    distance_range_m,
    nose_percent,
    stretch_percent,
)
from kogao_core.background.people import PersonFinder, PersonMask
from kogao_core.base.assets import AssetMissing
from kogao_core.base.atomic import atomic_write
from kogao_core.base.display import png
from kogao_core.base.geometry import Box, degrees_of
from kogao_core.base.language import Text, tr, translated
from kogao_core.cli import common, ending, reading
from kogao_core.faces.doubt import Verdict, verdicts
from kogao_core.faces.face import Face
from kogao_core.faces.landmarks import ModelRefused
from kogao_core.faces.landmarks import source as landmark_source
from kogao_core.photo import Photo
from kogao_core.photo.optics import optics_of


def run(args: SimpleNamespace) -> None:
    """Run the command."""
    common.check_report(args.json_file, args.force)
    common.check_report(args.mask_file, args.force)
    path = common.input_path(args.source, args.sample)
    if args.mask_file is not None and args.mask_file.exists() and args.mask_file.samefile(path):
        raise ending.Stop("{file} is the input photo; name another file", file=path)
    known = landmark_source(args.landmarks)
    photo = reading.read_photo(path, args.max_megapixels)
    faces = reading.find_faces(photo, args.landmarks, known=known)
    judged = list(zip(faces, verdicts(faces, Box.of(photo.pixels)), strict=True))
    mask_file = args.mask_file
    people = None if mask_file is None else _people(photo, faces)
    if mask_file is not None and people is not None:
        with ending.refusing("{file} can't be written: {reason}", file=mask_file):
            atomic_write(png(people.picture(photo.width, photo.height)), mask_file)
    common.deliver(
        lambda: _found(photo, judged, mask_file, people),
        lambda: _table(photo, judged),
        args.json_file,
    )


def _people(photo: Photo, faces: Sequence[Face]) -> PersonMask:
    with ending.stopping((AssetMissing, ModelRefused), ending.BROKEN):
        people = PersonFinder().find(photo.pixels, faces)
    if people.missed:
        ending.print_message(
            "{missed} of {count_of_faces} can't be separated from the background; the mask is "
            "black there",
            missed=people.missed,
            count_of_faces=common.count_of_faces(len(faces)),
        )
    return people


def _found(
    photo: Photo,
    judged: Sequence[tuple[Face, Verdict]],
    mask_file: Path | None,
    people: PersonMask | None,
) -> dict[str, Any]:
    optics = optics_of(photo)
    found: dict[str, Any] = {
        "image": {"width": photo.width, "height": photo.height},
        "lens": {"focal_mm": optics.focal_mm, "why": optics.why},
        "faces": [
            {
                **face.to_dict(),
                **verdict.to_dict(),
                **_lensed(photo, face, optics.focal_mm),
            }
            for face, verdict in judged
        ],
    }
    if people is not None:
        found["person_mask"] = {"file": str(mask_file), "missed_faces": people.missed}
    return found


def _lensed(photo: Photo, face: Face, focal_mm: float | None) -> dict[str, Any]:
    """Return lens stretch, distance and nose size of a face; None without a focal length."""
    if focal_mm is None:
        return {"stretch_percent": None, "distance_m": None, "nose_percent": None}
    about = distance_m(face, focal_mm, Box.of(photo.pixels))
    least, most = (round(end, 3) for end in distance_range_m(about))
    return {
        "stretch_percent": round(_stretch(photo, face, focal_mm), 2),
        "distance_m": {"about": round(about, 3), "least": least, "most": most},
        "nose_percent": round(nose_percent(about), 1),
    }


def _stretch(photo: Photo, face: Face, focal_mm: float) -> float:
    return stretch_percent(face, focal_mm, Box.of(photo.pixels))


def _table(photo: Photo, judged: Sequence[tuple[Face, Verdict]]) -> str:
    size, count = f"{photo.width} x {photo.height} px", common.count_of_faces(len(judged))
    lines, optics = [f"{photo.path}: {size}, {translated(count)}"], optics_of(photo)
    # Translators: six columns that figures stand below, 4, 7, 7, 7, 7, 8 and 6 letters wide.
    lines.append(tr("face  score      x      y  width  height  tilt"))
    for number, (face, _) in enumerate(judged, start=1):
        x, y, width, height = face.box
        tilt = degrees_of(face.eyes[3] - face.eyes[0])
        lines.append(
            f"{number:4}  {face.score:5.2f}  {x:5.0f}  {y:5.0f}  {width:5.0f}  {height:6.0f}"
            f"  {round(tilt):+3d}°"
        )
    notes = [verdict.told(number) for number, (_, verdict) in enumerate(judged, start=1)]
    if optics.focal_mm is not None:
        far = [f"{_stretch(photo, face, optics.focal_mm):.1f}" for face, _ in judged]
        lens = Text(
            "{mm:g} mm: wide-angle stretch by face {far} % (correct with warp --lens auto)",
            mm=optics.focal_mm,
            far=", ".join(far),
        )
        notes.append(lens)
        away = [distance_m(face, optics.focal_mm, Box.of(photo.pixels)) for face, _ in judged]
        notes += [
            Text("face {number}: {why}", number=number, why=distance_note(about))
            for number, about in enumerate(away, start=1)
            if nose_percent(about) >= NOSE_SEEN_PERCENT
        ]
    return "\n".join([*lines, *(translated(note) for note in notes if note)])
