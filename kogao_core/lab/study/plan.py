"""The two files of a study: one for the raters, one for the maker.

`Study` is in the raters' folder and contains picture names only. `Key` is next to the folder and
contains the variant and the photo of each picture.
"""

from __future__ import annotations

import dataclasses
import hashlib
import hmac
import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from kogao_core.base.atomic import atomic_write
from kogao_core.base.json_reader import BadFile, Node, parse, read
from kogao_core.base.language import Text
from kogao_core.base.wording import printable
from kogao_core.lab.study.design import CONDUCT, RULES, Conduct, Kind, Rules, Variant, one_of
from kogao_core.lab.subjects import Subject
from kogao_core.pipeline import Rendering
from kogao_core.recipe.recipe import Recipe
from kogao_core.recipe.settings import PAPER_CENTERS, Fit

_MOST_POINTS: Final = 1000
_LARGEST: Final = 1e9
_DIGITS: Final = 2  # decimals of landmarks, px at the paper's size
STUDY_FILE: Final = "study.json"
RATINGS_FOLDER: Final = "ratings"
SUFFIX: Final = ".jpg"
VERSION: Final = 2
KEY_VERSION: Final = 4
_STUDY_FORMAT: Final = "kogao-study"
_KEY_FORMAT: Final = "kogao-study-key"
_MOST_BYTES: Final = 32 * 2**20
_MOST_PICTURES: Final = 100_000
_HEX: Final = 16  # letters of a name: 64 bits
LONGEST_SEED: Final = 64
_NAME: Final = re.compile(r"[0-9a-f]{16}\.jpg")
_RATER: Final = re.compile(r"[a-z0-9][a-z0-9-]{0,31}")


@dataclass(frozen=True, slots=True)
class Origin:
    """Origin of a study."""

    program: str  # version of Kogao
    made: str  # when, ISO 8601 in UTC
    landmarks: str  # name of the landmark source; empty if unknown

    @staticmethod
    def parse(node: Node) -> Origin:
        """Read the value from a key. Raises BadFile."""
        node.only(("program", "made", "landmarks"))
        program, made, landmarks = (
            node.field(name).text(200) for name in ("program", "made", "landmarks")
        )
        return Origin(program, made, landmarks)


@dataclass(frozen=True, slots=True)
class PhotoRecord:
    """One face of a study."""

    name: str  # file name of the photo
    sha256: str = ""  # digest of the file; empty without a file
    points: tuple[tuple[float, float], ...] = ()  # landmarks before the warp, px of the pictures

    @staticmethod
    def of(subject: Subject) -> PhotoRecord:
        """Return the record of a subject for the key; unprintable letters become '?'."""
        name = printable(subject.name)
        points = [(float(x), float(y)) for x, y in _points(subject)]
        return PhotoRecord(name, subject.sha256, tuple(points))

    @staticmethod
    def parse(node: Node) -> PhotoRecord:
        """Read the value from a key. Raises BadFile."""
        node.only(("name", "sha256", "points"))
        points = [
            [one.number(-_LARGEST, _LARGEST) for one in point.items(2)]
            for point in node.field("points").items(_MOST_POINTS)
        ]
        if any(len(point) != 2 for point in points):
            node.field("points").refuse("must be pairs of x and y")
        return PhotoRecord(
            node.field("name").text(4096),
            node.field("sha256").text(64),
            tuple((x, y) for x, y in points),
        )


@dataclass(frozen=True, slots=True)
class PictureFigures:
    """Achieved distance and lattice size of a picture."""

    # Achieved distance towards the centre, % of D (`kogao_core.field.measures`).
    achieved: float
    # Lattice spacing in mean warp distances, the paper's R in figures 10 and 11.
    lattice_in_warps: float | None
    # Requested distance, % of D, of pictures made with `match`; otherwise None.
    asked: float | None = None

    @staticmethod
    def of(rendering: Rendering) -> PictureFigures:
        (pairs,), (lattice,) = rendering.pairs, rendering.field.lattices
        moved = pairs.warp_distance_px
        return PictureFigures(
            round(rendering.achieved[0], 4),
            round(lattice.grid.spacing_px / moved, 4) if moved > 0.0 else None,
        )

    @staticmethod
    def parse(node: Node) -> PictureFigures:
        """Read the value from a key. Raises BadFile."""
        ratio, asked = (
            None if one.value is None else one.number(-_LARGEST, _LARGEST)
            for one in (node.field("lattice_in_warps"), node.field("asked"))
        )
        return PictureFigures(node.field("achieved").number(-100.0, 100.0), ratio, asked)


def digest(subject: Subject, recipe: Recipe) -> str:
    """Return the SHA-256 of pixels, landmarks and recipe, which determine a subject's pictures.

    File names don't matter.
    """
    content: dict[str, Any] = {
        "shape": subject.pixels.shape,
        "points": _points(subject).tolist(),
        "recipe": recipe.to_dict(),
    }
    total = hashlib.sha256(json.dumps(content, sort_keys=True).encode())
    total.update(np.ascontiguousarray(subject.pixels).tobytes())
    return total.hexdigest()


def _points(subject: Subject) -> np.ndarray:
    # Adding 0.0 turns -0.0 into 0.0.
    return np.round(np.vstack([face.points for face in subject.faces]), _DIGITS) + 0.0


@dataclass(frozen=True, slots=True)
class Study:
    """The raters' file: picture names without meaning, sorted."""

    identity: str  # identifier of the study, repeated in ratings
    ratings: tuple[str, ...]  # pictures to judge
    satisfaction: tuple[str, ...]  # pictures to grade from 0 to 100
    practice: tuple[str, ...] = ()  # practice pictures, shown first
    # Pictures of each face, and groups of identical pictures: not shown in succession.
    faces: tuple[tuple[str, ...], ...] = ()
    twins: tuple[tuple[str, ...], ...] = ()
    conduct: Conduct = CONDUCT

    def to_dict(self) -> dict[str, Any]:
        """Return plain JSON values."""
        values = dataclasses.asdict(self)
        identity = values.pop("identity")
        return {"format": _STUDY_FORMAT, "version": VERSION, "study": identity, **values}


@dataclass(frozen=True, slots=True)
class Meaning:
    """Meaning of a picture: subject, variant and figures."""

    subject: int
    variant: Variant
    measured: PictureFigures


@dataclass(frozen=True, slots=True)
class Key:
    """The key, for the maker of the study only."""

    identity: str  # identifier of the study
    # Seed of the names: the same photos, landmarks, choices and seed give the same names.
    seed: str
    recipe: Recipe  # settings of all pictures
    subjects: tuple[PhotoRecord, ...]  # photos; `Meaning.subject` is an index
    pictures: Mapping[str, Meaning]  # by name
    origin: Origin  # version, time and landmark source
    rules: Rules = RULES  # rules that exclude answers

    def to_dict(self) -> dict[str, Any]:
        """Return plain JSON values."""
        pictures = {
            name: {
                "subject": meaning.subject,
                **dataclasses.asdict(meaning.variant),
                **dataclasses.asdict(meaning.measured),
            }
            for name, meaning in sorted(self.pictures.items())
        }
        return {
            "format": _KEY_FORMAT,
            "version": KEY_VERSION,
            "study": self.identity,
            "seed": self.seed,
            "recipe": self.recipe.to_dict(),
            "origin": dataclasses.asdict(self.origin),
            "rules": dataclasses.asdict(self.rules),
            "subjects": [dataclasses.asdict(one) for one in self.subjects],
            "pictures": pictures,
        }


def key_path(folder: Path) -> Path:
    """Return the path of the key: next to the raters' folder, never inside."""
    whole = folder.resolve()  # "." has no name
    return whole.with_name(f"{whole.name}.key.json")


def picture_name(seed: str, content: str, subject: int, variant: Variant) -> str:
    """Return a random-looking picture name: an HMAC under the seed."""
    text = json.dumps([content, subject, *dataclasses.astuple(variant)])
    digest = hmac.new(seed.encode(), text.encode(), hashlib.sha256).hexdigest()
    return digest[:_HEX] + SUFFIX


def is_rater(code: str) -> bool:
    """Return whether a text is a valid rater code: at most 32 of a to z, 0 to 9 and dashes."""
    return _RATER.fullmatch(code) is not None


def load_study(folder: Path) -> Study:
    """Read the raters' file. Raises BadFile."""
    top = _parsed(folder / STUDY_FILE, Text("{folder} contains no study", folder=folder))
    fields = ("study", "ratings", "satisfaction", "practice", "faces", "twins", "conduct")
    _check(top, _STUDY_FORMAT, fields, VERSION)
    identity = top.field("study").text(64)
    ratings, grades = names(top.field("ratings")), names(top.field("satisfaction"))
    if set(ratings) & set(grades):
        top.field("satisfaction").refuse("names pictures that are rated, too")
    faces, twins = (
        tuple(names(one) for one in top.field(name).items(_MOST_PICTURES))
        for name in ("faces", "twins")
    )
    conduct = Conduct.parse(top.field("conduct"))
    return Study(identity, ratings, grades, names(top.field("practice")), faces, twins, conduct)


def load_key(path: Path) -> Key:
    """Read the maker's file. Raises BadFile."""
    top = _parsed(path, Text("the key {path} can't be used", path=path))
    fields = ("study", "seed", "recipe", "subjects", "pictures", "origin", "rules")
    _check(top, _KEY_FORMAT, fields, KEY_VERSION)
    subjects = tuple(map(PhotoRecord.parse, top.field("subjects").items(_MOST_PICTURES)))
    pictures = top.field("pictures")
    if not isinstance(pictures.value, dict) or len(pictures.value) > _MOST_PICTURES:
        pictures.refuse("must be an object of pictures")
    try:
        recipe = Recipe.from_dict(top.field("recipe").value)
    except (ValueError, TypeError) as error:
        top.field("recipe").refuse(f"is no recipe: {str(error)[:200]}")
    meanings = {
        _checked_name(Node(name, pictures.path, pictures.root)): _meaning(
            Node(value, f"{pictures.path}[{name!r:.30}]", pictures.root), len(subjects)
        )
        for name, value in pictures.value.items()
    }
    return Key(
        top.field("study").text(64),
        top.field("seed").text(LONGEST_SEED),
        recipe,
        subjects,
        meanings,
        Origin.parse(top.field("origin")),
        Rules.parse(top.field("rules")),
    )


def save(content: Study | Key, path: Path) -> None:
    """Write a study or key atomically."""
    atomic_write((json.dumps(content.to_dict(), indent=1) + "\n").encode(), path)


def _parsed(path: Path, refusal: str) -> Node:
    try:
        return parse(read(path, _MOST_BYTES), _MOST_BYTES)
    except BadFile as error:
        raise BadFile("{refusal}: {error}", refusal=refusal, error=error) from None


def _check(top: Node, form: str, fields: tuple[str, ...], version: int) -> None:
    top.field("format").text(40, (form,))
    top.field("version").whole(version, version)
    top.only(("format", "version", *fields))


def names(node: Node) -> tuple[str, ...]:
    """Read a list of picture names without duplicates. Raises BadFile."""
    found = tuple(_checked_name(item) for item in node.items(_MOST_PICTURES))
    if len(set(found)) != len(found):
        node.refuse("names a picture twice")
    return found


def _checked_name(node: Node) -> str:
    # Names become paths: accept only generated names.
    name = node.text(40)
    if not _NAME.fullmatch(name):
        node.refuse("must name a picture")
    return name


def _meaning(node: Node, subjects: int) -> Meaning:
    figures = ("achieved", "lattice_in_warps", "asked")
    # Keys of 1.0.0 have a field "side" for pairs of pictures, a task that is gone.
    node.only(("subject", "kind", "percent", "center", "lattice", "fit", "side", *figures))
    variant = Variant(
        one_of(node.field("kind"), Kind),
        node.field("percent").number(-15.0, 15.0),
        node.field("center").whole(1, len(PAPER_CENTERS)),
        node.field("lattice").number(0.0, 100.0),
        one_of(node.field("fit"), Fit),
    )
    return Meaning(
        node.field("subject").whole(0, max(0, subjects - 1)),
        variant,
        PictureFigures.parse(node),
    )
