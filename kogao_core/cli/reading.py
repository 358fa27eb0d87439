"""Functions for input photos, for the faces in these photos, and for the options of results."""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Sequence
from concurrent.futures import Future
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Literal

from kogao_core.base import assets
from kogao_core.base.json_reader import BadFile
from kogao_core.base.language import Text
from kogao_core.base.wording import shown
from kogao_core.cli import common, ending
from kogao_core.faces import landmarks
from kogao_core.faces.doubt import AllDoubted, Chosen
from kogao_core.faces.face import Face, LandmarkSource, select
from kogao_core.faces.landmarks import ModelRefused, networks_are_here
from kogao_core.faces.landmarks import source as landmark_source
from kogao_core.faces.names import NobodyNamed, people_of
from kogao_core.photo import READABLE, CannotDisclose, Photo, UnreadablePhoto, formats, read
from kogao_core.photo.disclosure.disclosing import Disclosure
from kogao_core.photo.disclosure.label import check_label
from kogao_core.photo.export import Export
from kogao_core.photo.formats import suffix_of
from kogao_core.photo.profiles import for_search
from kogao_core.projects import interchange
from kogao_core.projects.results import Results
from kogao_core.recipe.export import EXPORT_SETTINGS
from kogao_core.recipe.recipe import Recipe
from kogao_core.retouch import RetouchJob


def refuse_result(path: Path) -> None:
    """Raise Stop if a photo is an earlier result of this program."""
    origin = Results.of_user().origin(path)
    if origin is not None:
        raise ending.Stop(
            "{why}; open the original, or use --results to continue",
            ending.OWN_RESULT,
            why=origin.why,
        )


def input_paths(inputs: Sequence[Path], sample: bool, *, named: bool = False) -> list[Path]:
    """Return the photos, including those in folders, or the sample. Raises Stop for both.

    With `named`, raise Stop if files that are named after two photos would have one name.
    """
    if bool(inputs) == sample:
        raise ending.Stop("name photos or folders of photos, or use --sample")
    if sample:
        return [common.input_path(None, sample)]
    paths: list[Path] = []
    for path in inputs:
        if not path.is_dir():
            paths.append(path)
            continue
        within = [p for p in sorted(path.rglob("*")) if suffix_of(p) in READABLE]
        if not within:
            raise ending.Stop("no photo found in {path}", path=path)
        paths += within
    stem, count = Counter(path.stem for path in paths).most_common(1)[0]
    if named and count > 1:
        raise ending.Stop("several photos are called {stem}; use separate folders", stem=stem)
    return paths


def read_photo(
    path: Path,
    max_megapixels: float,
    bits: Literal[8, 16] = 16,
    early: Future[Photo] | None = None,
) -> Photo:
    """Read a photo with 8 or 16 bits, as the output can store. Raises Stop.

    `early`: the photo, if a thread is already reading it.
    """
    with ending.stopping(UnreadablePhoto, ending.UNREADABLE):
        return early.result() if early else read(path, max_megapixels=max_megapixels, bits=bits)


def suffix_for(photo: Photo) -> str:
    """Return the file suffix of the photo's format, or .jpg if that format is read-only."""
    form = formats.BY_NAME[photo.format]
    return form.suffixes[0] if form.encode is not None else ".jpg"


def check_networks() -> None:
    """Raise Stop if a network is damaged, because every photo of a batch would fail."""
    with ending.stopping(ModelRefused, ending.BROKEN):
        landmarks.check_networks()


def mention_fallback(wanted: str | None) -> None:
    """Print a message if the AAM replaces missing networks."""
    if wanted is None and not networks_are_here():
        ending.print_message(
            "the networks are missing; using the less exact AAM (see kogao-cli doctor)"
        )


def points_of(photo: Photo, place: Path | None) -> list[Face] | None:
    """Return the faces of a photo in the ``--points`` file or folder, if any. Raises Stop."""
    if place is None:
        return None
    with ending.stopping(BadFile, ending.UNREADABLE):
        return interchange.faces_of(photo, place)


def find_faces(
    photo: Photo,
    landmarks: str | None,
    points: Path | None = None,
    known: LandmarkSource | None = None,
) -> list[Face]:
    """Return the faces of a photo in reading order (`in_reading_order`).

    `points` takes precedence, then the source `known`, then the source named `landmarks`.
    Raises Stop if there is no face.
    """
    if (given := points_of(photo, points)) is not None:
        return given
    with ending.stopping((assets.AssetMissing, ModelRefused), ending.BROKEN):
        try:
            faces = (known or landmark_source(landmarks)).find(for_search(photo))
        except ValueError as error:  # raised by `Face`
            raise ending.Stop(
                "the landmarks in {path} form no face: {error}; choose another source "
                "with --landmarks",
                ending.NO_FACE,
                path=photo.path,
                error=error,
            ) from error
    mention_fallback(landmarks)
    if not faces:
        raise ending.Stop(
            "no face in {path}; crop closer, or place a face by hand in the editor (kogao {path})",
            ending.NO_FACE,
            path=photo.path,
        )
    return faces


def chosen(photo: Photo, faces: Sequence[Face], job: RetouchJob) -> Chosen:
    """Return the faces selected by ``--face``, ``--person`` and ``--doubtful``. Raises Stop."""
    with ending.stopping(ValueError, ending.USAGE):
        try:
            return job.chosen(photo, faces)
        except NobodyNamed as doubts:
            sentence = Text("{path} was not changed: {doubts}", path=photo.path, doubts=doubts)
            raise ending.Stop(sentence, ending.NO_FACE) from doubts
        except AllDoubted as doubts:
            sentence = Text(
                "{path} was not changed: {doubts}; use --doubtful to include doubtful faces",
                path=photo.path,
                doubts=doubts,
            )
            raise ending.Stop(sentence, ending.NO_FACE) from doubts


def selected(faces: Sequence[Face], which: str) -> list[Face]:
    """Return the faces selected by ``--face``. Raises Stop if a number doesn't exist."""
    with ending.stopping(ValueError, ending.USAGE):
        return select(faces, which)


def disclosure_of(args: SimpleNamespace) -> Disclosure:
    """Return the disclosure of `options.discloses`. Raises Stop."""
    if args.label is not None:
        with ending.stopping(CannotDisclose, ending.USAGE):
            check_label(args.label, args.font)
    return Disclosure(args.record, args.label or "", args.font, film=args.motion == "keep")


def job_of(args: SimpleNamespace, recipe: Recipe, **more: Any) -> RetouchJob:
    """Return the job of the options of `warp` and `batch`, with more fields of `Export`."""
    people = people_of(args.people or "")
    if args.people is not None and not people:
        raise ending.Stop(
            Text("{text} isn't a list such as 'Ann=3,Kate=0'", text=shown(args.people))
        )
    with ending.stopping(ValueError, ending.USAGE):
        for _, percent in people:
            dataclasses.replace(recipe, percent=percent)
    return RetouchJob(
        recipe, args.which, args.doubtful, people, args.landmarks, args.max_megapixels,
        disclosure_of(args), export_of(args, **more),
    )  # fmt: skip


def export_of(args: SimpleNamespace, **more: Any) -> Export:
    """Return the value of `options.exports`, with more fields."""
    options = (name for name, setting in EXPORT_SETTINGS.items() if setting.option)
    given = {name: getattr(args, name) for name in options if getattr(args, name) is not None}
    return Export(**given, **more)
