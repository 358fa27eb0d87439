"""What the commands share: exit codes, one-line errors, the input and its faces."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from kogao_core.base.language import Text, translated
from kogao_core.base.wording import printable, sentence, system_reason
from kogao_core.cli import words

if TYPE_CHECKING:
    from kogao_core.faces.doubt import Chosen
    from kogao_core.faces.face import Face, LandmarkSource
    from kogao_core.photo import Photo

BROKEN: Final = 1
USAGE: Final = 2
UNREADABLE: Final = 3
NO_FACE: Final = 4
SOME_FAILED: Final = 5
UNEXPECTED: Final = 70  # EX_SOFTWARE of sysexits.h

# Whether it may be read is found, and said, by whoever reads it.
PHOTO: Final = click.Path(path_type=Path, readable=False)
FILE: Final = click.Path(path_type=Path, dir_okay=False)
FOLDER: Final = click.Path(path_type=Path, file_okay=False)


class Number(click.FloatRange):
    """A finite number within a range; click itself lets NaN through."""

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Read a number; NaN and infinities are none."""
        number: float = super().convert(value, param, ctx)
        if not isfinite(number):
            self.fail(Text("{value} is not a finite number.", value=value), param, ctx)
        return number


class LateChoice(click.ParamType):  # type: ignore[type-arg]
    """A choice whose list is made when it is needed, for what it comes from loads numpy."""

    name = "choice"

    def __init__(self, choices: Callable[[], Sequence[str]]) -> None:
        self._choices = choices

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Take a value that is on the list."""
        return click.Choice(self._choices()).convert(value, param, ctx)

    def get_metavar(self, param: click.Parameter, ctx: click.Context | None = None) -> str:  # noqa: ARG002
        """Return the list as help shows it."""
        return f"[{'|'.join(self._choices())}]"


def endings() -> list[str]:
    """Return the usual endings of the formats that can be written."""
    from kogao_core.photo import formats

    return [form.suffixes[0] for form in formats.WRITTEN]


def output_help() -> Text:
    """Return the help of an output."""
    from kogao_core.photo import formats

    return Text("Where to write; {endings}.", endings=formats.either(endings()))


class Stop(click.ClickException):
    """Ends the command with one line on stderr and an exit code."""

    def __init__(self, message: object, code: int) -> None:
        super().__init__(str(message))
        self.code = code


@contextmanager
def stopping(kinds: type[Exception] | tuple[type[Exception], ...], code: int) -> Iterator[None]:
    """Turn exceptions of some kinds into a `Stop`."""
    try:
        yield
    except kinds as error:
        raise Stop(error, code) from error


@contextmanager
def refusing(sentence: Callable[[str], Text]) -> Iterator[None]:
    """Stop where the system refuses something, with what `sentence` makes of its reason."""
    try:
        yield
    except OSError as error:
        raise Stop(sentence(system_reason(error)), UNREADABLE) from error


def writing(path: Path) -> AbstractContextManager[None]:
    """Stop with a sentence when a file, or what belongs into a folder, can't be written."""
    return refusing(
        lambda reason: Text("{path} can't be written ({reason})", path=path, reason=reason)
    )


def print_text(text: str) -> None:
    """Print lines on stdout; whatever in a file's name gives orders to a terminal becomes '?'."""
    click.echo("\n".join(map(printable, text.split("\n"))))


def print_message(message: str) -> None:
    """Print one line on stderr, in the user's language."""
    click.echo(f"kogao-cli: {sentence(translated(message))}", err=True)


def check_free(file: Path, force: bool) -> None:
    """Stop when a file may not be written: one is there without `force`, or no file can be."""
    from kogao_core.base.atomic import NotAFile, check_target

    try:
        check_target(file)
    except NotAFile as error:
        raise Stop(
            Text(
                "{file} can't be replaced: {reason}; name another file",
                file=file,
                reason=system_reason(error),
            ),
            USAGE,
        ) from None
    if file.exists() and not force:
        raise Stop(Text("{file} exists; --force replaces it", file=file), USAGE)


limits_megapixels = words.option(
    "--max-megapixels",
    type=Number(min=0, min_open=True),
    default=300.0,
    show_default=True,
    help="Refuse larger photos.",
)


def landmarks_help() -> Text:
    """Return the help of a landmark source."""
    from kogao_core.faces.landmarks import CHOICES

    names = [choice.name for choice in CHOICES]
    instead = next(choice.name for choice in CHOICES if not choice.needs_networks)
    return Text(
        "{names}, or a cv2.face model file [{first}; {instead} where the networks are missing].",
        names=", ".join(names),
        first=names[0],
        instead=instead,
    )


chooses_landmarks = words.option("--landmarks", metavar="SOURCE", help=landmarks_help)


forces = words.option("--force", is_flag=True, help="Replace existing files.")
_SEARCHING: Final = (
    words.option("--sample", is_flag=True, help="Use the built-in portrait."),
    limits_megapixels,
    chooses_landmarks,
)
# What it takes to read and search a photo, or any number of photos and folders of photos.
takes_photo = words.together(
    click.argument("source", metavar="[IN]", required=False, type=PHOTO), *_SEARCHING
)
takes_photos = words.together(
    click.argument("inputs", metavar="[PHOTO]...", nargs=-1, type=PHOTO), *_SEARCHING
)


def input_path(source: Path | None, sample: bool) -> Path:
    """Return the photo to read; exactly one of the two must be asked for."""
    if (source is None) != sample:
        raise Stop(Text("name one photo, or use --sample"), USAGE)
    if source is not None:
        return source
    from kogao_core.base import assets

    with stopping(assets.AssetMissing, BROKEN):
        return assets.sample()


def input_paths(inputs: Sequence[Path], sample: bool) -> list[Path]:
    """Return the photos to read, those in folders too; or the sample, but not both."""
    from kogao_core.photo import READABLE

    if bool(inputs) == sample:
        raise Stop(Text("name photos or folders of photos, or use --sample"), USAGE)
    if sample:
        return [input_path(None, sample)]
    paths: list[Path] = []
    for path in inputs:
        if not path.is_dir():
            paths.append(path)
            continue
        within = [p for p in sorted(path.rglob("*")) if p.suffix.lower() in READABLE]
        if not within:
            raise Stop(Text("there is no photo in {path}", path=path), USAGE)
        paths += within
    return paths


def each(photos: Sequence[Path], work: Callable[[Path], None]) -> int:
    """Work on photos and return the exit code; what stops one of several is told, no more."""
    code = 0
    for photo in photos:
        try:
            work(photo)
        except Stop as stop:
            if len(photos) == 1:
                raise
            print_message(stop.message)
            code = SOME_FAILED
    return code


def read_photo(path: Path, max_megapixels: float, output: Path | None = None) -> Photo:
    """Read the input, no deeper than the output can be where that is open, or stop."""
    from kogao_core.photo import UnreadablePhoto, bits_of, read

    bits = 16 if output is None else bits_of(output)
    with stopping(UnreadablePhoto, UNREADABLE):
        return read(path, max_megapixels=max_megapixels, bits=bits)


def landmark_source(wanted: str | None) -> LandmarkSource:
    """Return the source of landmarks that was asked for, or the best one here."""
    from kogao_core.faces.landmarks import ModelRefused, source

    with stopping(ModelRefused, USAGE):
        return source(wanted)


def loader(wanted: str | None) -> Callable[[], LandmarkSource]:
    """Return what reads the networks of that source and returns it, for a thread beside others."""
    from kogao_core.faces.landmarks import MeshSource

    found = landmark_source(wanted)

    def loaded() -> LandmarkSource:
        if isinstance(found, MeshSource):
            found.load()
        return found

    return loaded


def check_networks() -> None:
    """Stop when a network is damaged: every photo of a batch would fail."""
    from kogao_core.faces import landmarks

    with stopping(landmarks.ModelRefused, BROKEN):
        landmarks.check_networks()


def mention_fallback(wanted: str | None) -> None:
    """Print a note when landmarks come from the AAM for want of the networks."""
    from kogao_core.faces.landmarks import networks_are_here

    if wanted is None and not networks_are_here():
        print_message(
            Text(
                "the networks are missing, so landmarks come from the AAM, which is "
                "less exact; kogao-cli doctor says how to get them"
            )
        )


def find_faces(
    photo: Photo, landmarks: str | None, source: Callable[[], LandmarkSource | None] | None = None
) -> list[Face]:
    """Find the faces, `in_reading_order`, or stop where there is none.

    The source is what `source` returns, or else the one of `landmarks`.
    """
    from kogao_core.base.assets import AssetMissing
    from kogao_core.faces.landmarks import ModelRefused

    with stopping((AssetMissing, ModelRefused), BROKEN):
        try:
            found = (source() if source is not None else None) or landmark_source(landmarks)
            faces = found.find(photo.pixels)
        except ValueError as error:  # what `Face` refuses
            raise Stop(
                Text(
                    "the landmarks found in {path} are no face: {error}; choose "
                    "another source with --landmarks",
                    path=photo.path,
                    error=error,
                ),
                NO_FACE,
            ) from error
    mention_fallback(landmarks)
    if not faces:
        raise Stop(
            Text(
                "no face in {path}; crop closer or place the landmarks by hand in "
                "the editor (kogao {path})",
                path=photo.path,
            ),
            NO_FACE,
        )
    return faces


def selected(faces: Sequence[Face], which: str) -> list[Face]:
    """Return the faces that ``--face`` names, or stop where it names none of them."""
    from kogao_core.faces.face import select

    with stopping(ValueError, USAGE):
        return select(faces, which)


def chosen(photo: Photo, faces: Sequence[Face], which: str, doubtful: bool) -> Chosen:
    """Return what ``--face`` and ``--doubtful`` make of a photo's faces, or stop."""
    from kogao_core.base.geometry import Box
    from kogao_core.faces.doubt import AllDoubted, choose

    with stopping(ValueError, USAGE):
        try:
            return choose(faces, which, Box.of(photo.pixels), doubtful=doubtful)
        except AllDoubted as doubts:
            sentence = Text(
                "{path} stays as it is: {doubts}; --doubtful makes it smaller all the same",
                path=photo.path,
                doubts=doubts,
            )
            raise Stop(sentence, NO_FACE) from doubts


def count_of_faces(count: int) -> Text:
    """Return ``1 face`` or ``2 faces``."""
    return Text.counted(count, "{n} face", "{n} faces")
