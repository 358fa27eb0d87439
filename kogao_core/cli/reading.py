"""Photos on the command line: which to read, what reads them, and the faces in them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Final

import click

from kogao_core.base import assets
from kogao_core.base.geometry import Box
from kogao_core.base.language import Text
from kogao_core.base.strict import BadFile
from kogao_core.cli import ending, words
from kogao_core.cli.common import PHOTO, limits_megapixels
from kogao_core.faces import landmarks
from kogao_core.faces.doubt import AllDoubted, Chosen, choose
from kogao_core.faces.face import Face, LandmarkSource, select
from kogao_core.faces.landmarks import CHOICES, ModelRefused, networks_are_here, source
from kogao_core.photo import READABLE, Photo, UnreadablePhoto, bits_of, formats, read
from kogao_core.projects import interchange
from kogao_core.projects.interchange import PointSet
from kogao_core.projects.project import sha256_of
from kogao_core.projects.results import Results

# The usual endings of the formats that can be written.
ENDINGS: Final = [form.suffixes[0] for form in formats.WRITTEN]
NAMED_ENDINGS: Final = [ending.removeprefix(".") for ending in ENDINGS]
OUTPUT_HELP: Final = Text("Where to write; {endings}.", endings=formats.either(ENDINGS))


_SOURCES: Final = [choice.name for choice in CHOICES]
chooses_landmarks = words.option(
    "--landmarks",
    metavar="SOURCE",
    help=Text(
        "{names}, or a cv2.face model file [{first}; {instead} where the networks are missing].",
        names=", ".join(_SOURCES),
        first=_SOURCES[0],
        instead=next(choice.name for choice in CHOICES if not choice.needs_networks),
    ),
)


_SEARCHING: Final = (
    words.option("--sample", is_flag=True, help="Use the built-in portrait."),
    limits_megapixels,
    chooses_landmarks,
)
# What it takes to read and search a photo, or any number of photos and folders of photos.
takes_photo = words.together(
    click.argument("source", metavar="[IN]", required=False, type=PHOTO), *_SEARCHING
)
_POINTS: Final = "kogao_core.points"  # of what `--points` gave, in the command's context


def _keep(kind: str) -> Callable[[click.Context, click.Parameter, Any], None]:
    def keep(context: click.Context, _: click.Parameter, value: Any) -> None:
        context.meta[f"{_POINTS}.{kind}"] = value

    return keep


# For all that takes photos alike: `find_faces` and `points_of` ask the context.
takes_point_files = words.together(
    words.option(
        "--points", type=click.Path(path_type=Path), metavar="PATH", excludes=("--landmarks",),
        expose_value=False, callback=_keep("place"),
        help="Take the landmarks from a .tem, .pts, .csv or .json file, or from that of the "
        "photo's name in a folder, instead of looking for faces.",
    ),
    words.option(
        "--points-map", metavar="MAP", needs="--points", expose_value=False, callback=_keep("map"),
        help="Which of a file's points are outline/eyes/mouth, such as 0-16/36,39,42,45/48,54 "
        "[by their number: 27, 68 or 189].",
    ),
)  # fmt: skip
takes_photos = words.together(
    click.argument("inputs", metavar="[PHOTO]...", nargs=-1, type=PHOTO),
    *_SEARCHING,
    takes_point_files,
)


takes_results = words.option(
    "--results", is_flag=True, help="Work on Kogao's own results again, too."
)


def refuse_result(path: Path) -> None:
    """Stop where a photo is one of this program's own results."""
    origin = Results.of_user().origin(path)
    if origin is not None:
        raise ending.Stop(
            Text("{why}; work on the original, or --results to go on", why=origin.why),
            ending.OWN_RESULT,
        )


def input_path(source: Path | None, sample: bool) -> Path:
    """Return the photo to read; exactly one of the two must be asked for."""
    if (source is None) != sample:
        raise ending.Stop(Text("name one photo, or use --sample"))
    if source is not None:
        return source

    with ending.stopping(assets.AssetMissing, ending.BROKEN):
        return assets.sample()


def input_paths(inputs: Sequence[Path], sample: bool) -> list[Path]:
    """Return the photos to read, those in folders too; or the sample, but not both."""
    if bool(inputs) == sample:
        raise ending.Stop(Text("name photos or folders of photos, or use --sample"))
    if sample:
        return [input_path(None, sample)]
    paths: list[Path] = []
    for path in inputs:
        if not path.is_dir():
            paths.append(path)
            continue
        within = [p for p in sorted(path.rglob("*")) if p.suffix.lower() in READABLE]
        if not within:
            raise ending.Stop(Text("there is no photo in {path}", path=path))
        paths += within
    return paths


def read_photo(path: Path, max_megapixels: float, output: Path | None = None) -> Photo:
    """Read the input, no deeper than the output can be where that is open, or stop."""
    bits = 16 if output is None else bits_of(output)
    with ending.stopping(UnreadablePhoto, ending.UNREADABLE):
        return read(path, max_megapixels=max_megapixels, bits=bits)


def landmark_source(wanted: str | None) -> LandmarkSource:
    """Return the source of landmarks that was asked for, or the best one here."""
    with ending.stopping(ModelRefused, ending.USAGE):
        return source(wanted)


def check_networks() -> None:
    """Stop when a network is damaged: every photo of a batch would fail."""
    with ending.stopping(ModelRefused, ending.BROKEN):
        landmarks.check_networks()


def mention_fallback(wanted: str | None) -> None:
    """Print a note when landmarks come from the AAM for want of the networks."""
    if wanted is None and not networks_are_here():
        ending.print_message(
            Text(
                "the networks are missing, so landmarks come from the AAM, which is "
                "less exact; kogao-cli doctor says how to get them"
            )
        )


def point_files() -> tuple[Path | None, str | None]:
    """Return the path and the mapping that ``--points`` and ``--points-map`` gave, or stop."""
    given = click.get_current_context().meta
    place, mapping = given.get(f"{_POINTS}.place"), given.get(f"{_POINTS}.map")
    if mapping is not None:
        with ending.stopping(ValueError, ending.USAGE):
            interchange.template(mapping)
    return place, mapping


def points_of(photo: Photo) -> list[tuple[Face, PointSet]] | None:
    """Return the faces that ``--points`` has for a photo, with all their points, or stop.

    Result: None where that wasn't given.
    """
    place, mapping = point_files()
    if place is None:
        return None
    template = None if mapping is None else interchange.template(mapping)
    with ending.stopping(BadFile, ending.UNREADABLE):
        found = interchange.read_all(interchange.file_for(photo.path, place), template)
        interchange.check_inside([face for face, _ in found], Box.of(photo.pixels))
    return found


def find_faces(
    photo: Photo, landmarks: str | None, known: LandmarkSource | None = None
) -> list[Face]:
    """Find the faces, `in_reading_order`, or stop where there is none.

    The source is the one of `landmarks`, where it isn't `known` already; ``--points`` goes before.
    """
    if (given := points_of(photo)) is not None:
        return [face for face, _ in given]
    with ending.stopping((assets.AssetMissing, ModelRefused), ending.BROKEN):
        try:
            faces = (known or landmark_source(landmarks)).find(photo.pixels)
        except ValueError as error:  # what `Face` refuses
            raise ending.Stop(
                Text(
                    "the landmarks found in {path} are no face: {error}; choose "
                    "another source with --landmarks",
                    path=photo.path,
                    error=error,
                ),
                ending.NO_FACE,
            ) from error
    mention_fallback(landmarks)
    if not faces:
        raise ending.Stop(
            Text(
                "no face in {path}; crop closer or place the landmarks by hand in "
                "the editor (kogao {path})",
                path=photo.path,
            ),
            ending.NO_FACE,
        )
    return faces


def chosen(photo: Photo, faces: Sequence[Face], which: str, doubtful: bool) -> Chosen:
    """Return what ``--face`` and ``--doubtful`` make of a photo's faces, or stop."""
    with ending.stopping(ValueError, ending.USAGE):
        try:
            return choose(faces, which, Box.of(photo.pixels), doubtful=doubtful)
        except AllDoubted as doubts:
            sentence = Text(
                "{path} stays as it is: {doubts}; --doubtful makes it smaller all the same",
                path=photo.path,
                doubts=doubts,
            )
            raise ending.Stop(sentence, ending.NO_FACE) from doubts


def selected(faces: Sequence[Face], which: str) -> list[Face]:
    """Return the faces that ``--face`` names, or stop where it names none of them."""
    with ending.stopping(ValueError, ending.USAGE):
        return select(faces, which)


def hash_of(path: Path) -> str:
    """Return the SHA-256 of a photo's file, or stop."""
    with ending.stopping(OSError, ending.UNREADABLE):
        return sha256_of(path)
