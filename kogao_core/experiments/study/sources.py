"""Where a study's pictures come from, and notes on answers that aren't counted."""

from __future__ import annotations

from typing import Final

from kogao_core.experiments.report import NONE, Table, recipe_in_words
from kogao_core.experiments.study.plan import Key
from kogao_core.experiments.study.tally import Tally

_SHOWN: Final = 12  # letters of a digest


def studies(tally: Tally) -> Table:
    """Return where the pictures come from, a row for each photo."""
    rows = [
        [key.identity, face.name, face.sha256[:_SHOWN] or NONE, *_origin(key), key.seed]
        for key in tally.keys
        for face in key.subjects
    ]
    recipes = dict.fromkeys(recipe_in_words(key.recipe) for key in tally.keys)
    return Table(
        "Studies",
        ("study", "photo", "its SHA-256", "landmarks", "Kogao", "made", "seed"),
        rows,
        f"{'; '.join(recipes)}; distance, centre and lattice as the tables say. Keys hold whole "
        "digests, and the landmarks.",
    )


def _origin(key: Key) -> tuple[str, str, str]:
    if key.origin is None:
        return NONE, NONE, NONE
    return key.origin.landmarks or NONE, key.origin.program, key.origin.made


def notes(tally: Tally) -> list[str]:
    """Return sentences about what isn't counted, or should be known of what is."""
    sentences = [
        f"{path} holds ratings of study {study}, not of this one; they aren't counted"
        for path, study in tally.foreign
    ]
    if tally.torn:
        sentences.append(f"torn lines of ratings that were left out: {tally.torn}")
    if tally.unfinished:
        left = ((one.rater, len(one.answered), len(one.order)) for one in tally.unfinished)
        some = ", ".join(f"{rater} ({done} of {total})" for rater, done, total in left)
        sentences.append(f"sessions that weren't finished, whose answers count: {some}")
    old = [key.identity for key in tally.keys if key.origin is None]
    if old:
        sentences.append(
            f"made by a version whose names don't tell faces apart: {', '.join(old)}; if another "
            "study was made with the same seed, check that no rating of it lies here"
        )
    return sentences


def document_of(key: Key) -> dict[str, object]:
    """Return a key without its pictures, as plain JSON values."""
    whole = key.to_dict()
    return {name: whole[name] for name in ("study", "seed", "recipe", "origin", "subjects")}


def counted(count: int, thing: str) -> str:
    """Return such as "1 face" or "2 faces"."""
    return f"{count} {thing}" if count == 1 else f"{count} {thing}s"
