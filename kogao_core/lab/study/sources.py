"""Where a study's pictures come from, and notes on answers that aren't counted."""

from __future__ import annotations

from typing import Final

from kogao_core.base.language import Text
from kogao_core.lab.reports.report import NONE, Table, recipe_in_words
from kogao_core.lab.study import curve
from kogao_core.lab.study.plan import Key
from kogao_core.lab.study.tally import Tally

_SHOWN: Final = 12  # letters of a digest
_ALIKE: Final = 0.02  # sizes, as angles, that differ by no larger a share are one


def studies(tally: Tally) -> Table:
    """Return where the pictures come from, a row for each photo."""
    rows = [
        [
            key.identity, face.name, face.sha256[:_SHOWN] or NONE, key.origin.landmarks or NONE,
            key.origin.program, key.origin.made, key.seed,
        ]
        for key in tally.keys
        for face in key.subjects
    ]  # fmt: skip
    recipes = dict.fromkeys(recipe_in_words(key.recipe) for key in tally.keys)
    return Table(
        Text("Studies"),
        (
            Text("study"),
            Text("photo"),
            Text("its SHA-256"),
            Text("landmarks"),
            "Kogao",
            Text("made"),
            Text("seed"),
        ),
        rows,
        Text(
            "{names}; distance, centre and lattice as the tables say. Keys hold "
            "whole digests, and the landmarks.",
            names=Text.joined("; ", list(recipes)),
        ),
    )


def notes(tally: Tally) -> list[str]:
    """Return sentences about what isn't counted, or should be known of what is."""
    sentences: list[str] = [Text("not counted: {why}", why=why) for _, why in tally.refused]
    sentences += [
        Text(
            "the answers of {rater} are left out: {why}",
            rater=one.rater,
            why=Text.joined("; ", one.reasons),
        )
        for one in tally.left_out
    ]
    early = sum(row.is_early for row in tally.answers if row.session.rater in tally.careful)
    if early:
        sentences.append(Text("answers that came too early and are left out: {n}", n=early))
    angles = [angle for one in tally.raters.values() for angle in one.degrees or (0.0,)]
    sizes = {one.sizes for one in tally.raters.values()}
    if len(sizes) > 1 and max(angles) - min(angles) > _ALIKE * max(angles):
        sentences.append(
            Text(
                "raters saw pictures at different sizes, which are pooled; see the table of raters"
            )
        )
    if not curve.is_here():
        sentences.append(
            Text("the curve and its 50 % point need scipy: pip install 'kogao[experiments]'")
        )
    if tally.torn:
        sentences.append(Text("torn lines of ratings that were left out: {torn}", torn=tally.torn))
    if tally.unfinished:
        left = ((one.rater, len(one.answered), len(one.order)) for one in tally.unfinished)
        some = Text.joined(
            ", ",
            [
                Text("{rater} ({done} of {total})", rater=rater, done=done, total=total)
                for rater, done, total in left
            ],
        )
        sentences.append(
            Text("sessions that weren't finished, whose answers count: {some}", some=some)
        )
    return sentences


def document_of(key: Key) -> dict[str, object]:
    """Return a key without its pictures, as plain JSON values."""
    whole = key.to_dict()
    return {name: whole[name] for name in ("study", "seed", "recipe", "origin", "subjects")}
