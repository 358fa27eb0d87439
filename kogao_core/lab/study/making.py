"""Make a study: pictures without labels, the rating page, and the key next to the folder."""

from __future__ import annotations

import dataclasses
import hashlib
import io
import json
import os
import secrets
from collections import defaultdict
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Final

import numpy as np
from PIL import Image as Pillow

from kogao_core import __version__
from kogao_core.base.atomic import atomic_write, temporary_folder
from kogao_core.base.display import rgb8
from kogao_core.base.geometry import Image
from kogao_core.base.language import BadValue, TextError
from kogao_core.base.wording import printable
from kogao_core.faces.face import Face
from kogao_core.lab.study import page, plan
from kogao_core.lab.study.design import CONDUCT, RULES, Conduct, Rules, Variant, practice, variants
from kogao_core.lab.study.plan import (
    Key,
    Meaning,
    Origin,
    PhotoRecord,
    PictureFigures,
    Study,
    digest,
)
from kogao_core.lab.subjects import Progress, Subject, at_paper_size, no_progress
from kogao_core.photo import Photo, profiles
from kogao_core.pipeline import render
from kogao_core.recipe.recipe import PAPER, Recipe

_QUALITY: Final = 95
_FULL_COLOUR: Final = 0
_LEAST_PADDING: Final = 16
_STEPS: Final = 3
_MOST: Final = 15.0  # % of D
# 1 January 1980, the first date of MS-DOS: every file system can store this date.
_CHANGED_S: Final = 315_619_200.0
PAGE_FILE: Final = "index.html"
_SEED_BYTES: Final = 16


def subject(photo: Photo, face: Face) -> Subject:
    """Return one face of a photo at the paper's 960 x 720 px, in sRGB, upright."""
    named = Subject(photo.path.name, _srgb(photo), (face,))
    return at_paper_size(named)


def _srgb(photo: Photo) -> Image:
    if photo.icc_profile is None:
        return rgb8(photo.pixels)
    try:
        return rgb8(profiles.to_srgb(photo.pixels, photo.icc_profile))
    except profiles.DAMAGED:
        return rgb8(photo.pixels)  # ignore a profile for another colour space, as viewers do


def drawn(
    shown: Subject, variant: Variant, base: Recipe, *, match: bool = False
) -> tuple[bytes, PictureFigures]:
    """Return a picture as JPEG without metadata, and the achieved distance.

    With `match`, the achieved distance equals the percentage of the variant.
    """
    rendering, asked = render(shown.pixels, shown.faces, variant.recipe(base)), None
    if match and variant.percent:
        # The achieved distance is nearly proportional to the requested distance.
        asked = variant
        for _ in range(_STEPS):
            wanted = asked.percent * variant.percent / rendering.achieved[0]
            asked = dataclasses.replace(asked, percent=max(-_MOST, min(_MOST, wanted)))
            rendering = render(shown.pixels, shown.faces, asked.recipe(base))
    pixels = rendering.pixels
    if variant.kind == "catch":
        pixels = _cut(pixels, shown.faces[0])
    figures = PictureFigures.of(rendering)
    if asked is not None:
        figures = dataclasses.replace(figures, asked=round(asked.percent, 4))
    out = io.BytesIO()
    picture = Pillow.fromarray(pixels)
    picture.save(out, "JPEG", quality=_QUALITY, subsampling=_FULL_COLOUR)
    return out.getvalue(), figures


def _cut(pixels: Image, face: Face) -> Image:
    """Shift the part below the middle of a face sideways by half the face's width."""
    left, top = face.outline.min(axis=0)
    right, bottom = face.outline.max(axis=0)
    cut, moved = round((top + bottom) / 2.0), round((right - left) / 2.0)
    return np.concatenate([pixels[:cut], np.roll(pixels[cut:], moved, axis=1)])


def write_all(pictures: Mapping[str, Path], folder: Path, seed: str) -> None:
    """Write the pictures to the folder in the order of names, padded to one file size.

    Without padding, sorting by size would mostly sort by warp distance (decision 33). The padding
    comes from the seed, so that the same study has the same bytes.
    """
    size = max(path.stat().st_size for path in pictures.values()) + _LEAST_PADDING
    for name in sorted(pictures):
        data, chance = pictures[name].read_bytes(), hashlib.shake_256(f"{seed}:{name}".encode())
        atomic_write(data + chance.digest(size - len(data)), folder / name)


class RefusedFolder(TextError):
    """The study can't be made in this folder; the message says how to continue."""


@dataclass(frozen=True, slots=True)
class Choices:
    """Settings of a new study."""

    # Recipe of all pictures. The paper's has no guard; a guard would weaken strong warps.
    recipe: Recipe = PAPER
    variants: tuple[Variant, ...] = variants()  # the pictures of each subject
    seed: str | None = None  # the same seed and faces give the same pictures; None: random
    landmarks: str = ""  # name of the source that found the faces, for the key
    match: bool = False  # True: percentages are achieved distances
    practice: int = 0  # number of practice pictures, of another face
    conduct: Conduct = CONDUCT  # how sessions are held
    rules: Rules = RULES  # which answers count

    def __post_init__(self) -> None:
        """Raise ValueError if the key can't store the seed."""
        if self.seed and (len(self.seed) > plan.LONGEST_SEED or printable(self.seed) != self.seed):
            raise BadValue("a seed has at most {most} printable letters", most=plan.LONGEST_SEED)


def check_folder(folder: Path) -> None:
    """Check that a study can be made in a folder. Raises RefusedFolder."""
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise RefusedFolder("{folder} isn't empty; name a new folder for the study", folder=folder)
    if plan.key_path(folder).exists():
        raise RefusedFolder(
            "{file} is the key of another study; name another folder", file=plan.key_path(folder)
        )


def make(
    subjects: Sequence[Subject],
    folder: Path,
    choices: Choices | None = None,
    progress: Progress = no_progress,
    other: Subject | None = None,
) -> Key:
    """Make a study of some subjects. Return the key. Raises RefusedFolder.

    `other` is the face of the practice pictures.
    """
    choices = choices or Choices()
    check_folder(folder)
    folder.resolve().parent.mkdir(parents=True, exist_ok=True)
    todo = [(subject, choices.variants) for subject in subjects]
    if other is not None:
        todo.append((other, practice(choices.practice, choices.recipe)))
    seed = choices.seed or secrets.token_hex(_SEED_BYTES)
    # Make the study in a temporary folder: an interrupted study leaves no files.
    with temporary_folder(folder.resolve().parent) as place:
        drawn, ready = place / "drawn", place / "ready"
        drawn.mkdir()
        ready.mkdir()
        meanings = dict(_drawn(todo, choices, seed, drawn, progress))
        write_all({name: drawn / name for name in meanings}, ready, seed)
        study = _study(meanings, choices.conduct)
        plan.save(study, ready / plan.STUDY_FILE)
        atomic_write(page.page(study, ready).encode(), ready / PAGE_FILE)
        for path in ready.iterdir():  # one time, which hides the order
            os.utime(path, (_CHANGED_S, _CHANGED_S))
        faces = tuple(PhotoRecord.of(subject) for subject, _ in todo)
        now = datetime.now(UTC).isoformat(timespec="seconds")
        made = Origin(__version__, now, choices.landmarks)
        key = Key(study.identity, seed, choices.recipe, faces, meanings, made, choices.rules)
        _put_in_place(ready, key, folder)
    return key


def _put_in_place(ready: Path, key: Key, folder: Path) -> None:
    place = plan.key_path(folder)
    plan.save(key, place)
    place.chmod(0o600)
    was_there = folder.exists()
    moved: list[Path] = []
    try:
        folder.mkdir(exist_ok=True)
        for path in sorted(ready.iterdir()):
            moved.append(path.rename(folder / path.name))
    except OSError:
        for path in (place, *moved):
            path.unlink()
        if not was_there and folder.exists():
            folder.rmdir()
        raise


def _drawn(
    todo: Sequence[tuple[Subject, Sequence[Variant]]],
    choices: Choices,
    seed: str,
    place: Path,
    progress: Progress,
) -> Iterator[tuple[str, Meaning]]:
    done, total = 0, sum(len(kinds) for _, kinds in todo)
    for index, (subject, kinds) in enumerate(todo):
        content = digest(subject, choices.recipe)
        for variant in kinds:
            name = plan.picture_name(seed, content, index, variant)
            data, measured = drawn(subject, variant, choices.recipe, match=choices.match)
            (place / name).write_bytes(data)
            done += 1
            progress(done, total)
            yield name, Meaning(index, variant, measured)


def _study(meanings: Mapping[str, Meaning], conduct: Conduct) -> Study:
    """Return the raters' file, sorted by name: the order carries no information."""

    def grouped(key: Callable[[Meaning], Hashable], *left_out: str) -> tuple[tuple[str, ...], ...]:
        found: defaultdict[Hashable, list[str]] = defaultdict(list)
        for name, one in sorted(meanings.items()):
            if one.variant.kind not in left_out:
                found[key(one)].append(name)
        return tuple(sorted(map(tuple, found.values())))

    blocks: defaultdict[str, list[str]] = defaultdict(list)
    for name, one in sorted(meanings.items()):
        kind = one.variant.kind
        blocks[kind if kind in ("satisfaction", "practice") else "ratings"].append(name)
    told = [*sorted(meanings), json.dumps(dataclasses.asdict(conduct), sort_keys=True)]
    identity = hashlib.sha256("".join(told).encode()).hexdigest()[:16]
    same = grouped(lambda one: (one.subject, one.variant.what), "satisfaction", "practice")
    return Study(
        identity,
        tuple(blocks["ratings"]),
        tuple(blocks["satisfaction"]),
        tuple(blocks["practice"]),
        grouped(lambda one: one.subject, "practice"),
        tuple(names for names in same if len(names) > 1),
        conduct,
    )
