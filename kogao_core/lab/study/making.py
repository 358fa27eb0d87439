"""Make a study: pictures, the page, the list for the editor, and the key beside the folder."""

from __future__ import annotations

import hashlib
import json
import secrets
from collections import defaultdict
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from kogao_core.base.atomic import aside, put
from kogao_core.base.language import Text
from kogao_core.base.wording import printable
from kogao_core.lab.study import page, pictures, plan
from kogao_core.lab.study.conduct import CONDUCT, Conduct
from kogao_core.lab.study.origin import Origin, PhotoRecord, digest
from kogao_core.lab.study.plan import Key, Meaning, Study
from kogao_core.lab.study.variants import Variant, practice, variants
from kogao_core.lab.subjects import Progress, Subject, no_progress
from kogao_core.recipe.recipe import PAPER, Recipe

PAGE_FILE: Final = "index.html"
_SEED_BYTES: Final = 16


class RefusedFolder(Exception):
    """The study can't be made there; one sentence that says what to do next."""


@dataclass(frozen=True, slots=True)
class Choices:
    """How a study is made."""

    # What all pictures share; the paper's without the guard, which would hide what is asked.
    recipe: Recipe = PAPER
    variants: tuple[Variant, ...] = variants()  # the pictures of each subject
    seed: str | None = None  # brings the same pictures of the same faces again; drawn when absent
    landmarks: str = ""  # name of the source that found the faces, for the key
    match: bool = False  # whether percentages are what is achieved
    practice: int = 0  # pictures to practise with, of a face that isn't among those judged
    conduct: Conduct = CONDUCT  # how sessions are held

    def __post_init__(self) -> None:
        """Refuse a seed that a key couldn't hold."""
        if self.seed and (len(self.seed) > plan.LONGEST_SEED or printable(self.seed) != self.seed):
            raise ValueError(
                Text("a seed has at most {most} printable letters", most=plan.LONGEST_SEED)
            )


def check_folder(folder: Path) -> None:
    """Check that a study can be made in a folder. Raises RefusedFolder."""
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise RefusedFolder(
            Text("{folder} isn't empty; name a new folder for the study", folder=folder)
        )
    if plan.key_path(folder).exists():
        raise RefusedFolder(
            Text(
                "{file} is the key of another study; name another folder",
                file=plan.key_path(folder),
            )
        )
    if not folder.resolve().parent.is_dir():
        raise RefusedFolder(
            Text("the folder {folder} doesn't exist; make it first", folder=folder.resolve().parent)
        )


def make(
    subjects: Sequence[Subject],
    folder: Path,
    choices: Choices | None = None,
    progress: Progress = no_progress,
    other: Subject | None = None,
) -> Key:
    """Make a study of some subjects. Result: what each picture is. Raises RefusedFolder.

    The face of `other` is for practice.
    """
    choices = choices or Choices()
    check_folder(folder)
    todo = [(subject, choices.variants) for subject in subjects]
    if other is not None:
        todo.append((other, practice(choices.practice, choices.recipe)))
    seed = choices.seed or secrets.token_hex(_SEED_BYTES)
    # All of it aside first: a study that can't be finished leaves nothing behind.
    with aside(folder.resolve().parent) as place:
        drawn, ready = place / "drawn", place / "ready"
        drawn.mkdir()
        ready.mkdir()
        meanings = dict(_drawn(todo, choices, seed, drawn, progress))
        pictures.write_all({name: drawn / name for name in meanings}, ready, seed)
        study = _study(meanings, choices.conduct)
        _write_lists(study, ready)
        faces = tuple(PhotoRecord.of(subject) for subject, _ in todo)
        made = Origin.now(choices.landmarks)
        key = Key(study.identity, seed, choices.recipe, faces, meanings, made)
        _put_in_place(ready, key, folder)
    return key


def _write_lists(study: Study, folder: Path) -> None:
    plan.save(study, folder / plan.STUDY_FILE)
    put(page.page(study, folder).encode(), folder / PAGE_FILE)
    pictures.same_time([folder / plan.STUDY_FILE, folder / PAGE_FILE])


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
            paired = choices.conduct.pairs and variant.kind != "satisfaction"
            side = plan.side_of(seed, name) if paired else None
            data, measured = pictures.drawn(
                subject, variant, choices.recipe, match=choices.match, side=side
            )
            (place / name).write_bytes(data)
            done += 1
            progress(done, total)
            yield name, Meaning(index, variant, measured, side)


def _study(meanings: Mapping[str, Meaning], conduct: Conduct) -> Study:
    """Return the raters' half: all in the order of names, which tells nothing."""

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
    told = [*sorted(meanings), json.dumps(conduct.to_dict(), sort_keys=True)]
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
