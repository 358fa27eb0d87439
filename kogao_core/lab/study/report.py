"""The report of a study: answers, raters, and the origin of the pictures."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Final

from kogao_core.base.language import Text
from kogao_core.lab.reports.report import NONE, Heading, Part, Report, Row, Table, recipe_in_words
from kogao_core.lab.study import tables
from kogao_core.lab.study.design import Variant
from kogao_core.lab.study.plan import PictureFigures
from kogao_core.lab.study.shares import Share
from kogao_core.lab.study.tables import PUBLISHED_SATISFACTION, of_kind
from kogao_core.lab.study.tally import Quality, Tally

_TITLE: Final = Text("How natural do the faces look?")
_LEAD: Final = Text("Raters called pictures natural or unnatural, without knowing the settings.")
_ORIGIN: Final = ("study", "seed", "recipe", "origin", "subjects")  # fields of a key
_SHOWN: Final = 12  # letters of a digest


def report(tally: Tally) -> Report:
    """Return the report of a tally."""
    shares, everybody = tally.shares(), tally.shares(tally.answers)
    differs = shares != everybody
    who = Text("counted raters") if differs else Text("all raters")
    parts: list[Part] = [
        Row(tables.distance_charts(shares), wide=True),
        Heading(Text("Warp distance and centre")),
        tables.table_1(tally, shares, who, len(tally.careful)),
    ]
    if differs:
        parts.append(tables.table_1(tally, everybody, Text("all raters"), len(tally.raters)))
    if of_kind(shares, "figure11") or of_kind(shares, "control"):
        parts += [Heading(Text("Lattice size")), tables.figure_11(tally, shares)]
    if of_kind(shares, "figure11"):
        parts.append(tables.lattice_chart(shares))
    if any(row.variant.kind == "satisfaction" for row in tally.answers):
        parts += [Heading(Text("Satisfaction")), tables.satisfaction(tally)]
    parts += [care(tally)] if tally.raters else []
    parts.append(studies(tally))
    parts += [Text("Note: {sentence}.", sentence=sentence) for sentence in notes(tally)]
    measured = tally.measured()
    records = [
        _row(variant, share, everybody[variant], measured[variant])
        for variant, share in shares.items()
    ]
    return Report(_TITLE, _LEAD, parts, records, _document(tally, records))


def care(tally: Tally) -> Table:
    """Return the quality of each rater's answers."""
    return Table(
        Text("Raters"),
        (
            Text("rater"), Text("answers"), Text("median, s"),
            Text("under {ms} ms", ms=tally.keys[0].rules.least_ms), Text("unnatural"),
            Text("longest run"), Text("twins alike"), Text("catches seen"),
            Text("follows distance"), Text("away, s"), Text("picture, CSS px"),
        ),
        [_rater_row(one) for one in tally.raters.values()],
        Text(
            "Follows distance: AUC; 0.5 is guessing, 1 perfect. Twins: identical pictures. Times "
            "exclude other tabs and windows. The key contains the rules that exclude answers."
        ),
    )  # fmt: skip


def _rater_row(one: Quality) -> list[str]:
    sizes = ", ".join(f"{width} \N{MULTIPLICATION SIGN} {height}" for width, height in one.sizes)
    return [
        one.rater,
        str(one.answers),
        f"{one.median_ms / 1000.0:.2f}",
        f"{100.0 * one.quick:.0f} %",
        NONE if one.unnatural is None else f"{100.0 * one.unnatural:.0f} %",
        str(one.longest_run),
        f"{one.agreeing}/{one.pairs}" if one.pairs else NONE,
        f"{one.caught}/{one.catches}" if one.catches else NONE,
        NONE if one.follows is None else f"{one.follows:.2f}",
        f"{one.away_ms / 1000.0:.1f}",
        sizes or NONE,
    ]


def studies(tally: Tally) -> Table:
    """Return the origin of the pictures, one row per photo."""
    recipes = dict.fromkeys(recipe_in_words(key.recipe) for key in tally.keys)
    return Table.of(
        Text("Studies"),
        [(key, face) for key in tally.keys for face in key.subjects],
        [
            (Text("study"), lambda of: of[0].identity),
            (Text("photo"), lambda of: of[1].name),
            (Text("its SHA-256"), lambda of: of[1].sha256[:_SHOWN] or NONE),
            (Text("landmarks"), lambda of: of[0].origin.landmarks or NONE),
            ("Kogao", lambda of: of[0].origin.program),
            (Text("made"), lambda of: of[0].origin.made),
            (Text("seed"), lambda of: of[0].seed),
        ],
        Text(
            "{names}; distance, centre and lattice as in the tables. Keys contain full digests "
            "and landmarks.",
            names=Text.joined("; ", list(recipes)),
        ),
    )


def notes(tally: Tally) -> list[str]:
    """Return notes about excluded answers, and warnings."""
    sentences: list[str] = [Text("not counted: {why}", why=why) for _, why in tally.refused]
    sentences += [
        Text(
            "excluded rater {rater}: {why}",
            rater=one.rater,
            why=Text.joined("; ", one.reasons),
        )
        for one in tally.left_out
    ]
    early = sum(row.is_early for row in tally.answers if row.session.rater in tally.careful)
    if early:
        sentences.append(Text("excluded answers below the minimum time: {n}", n=early))
    sizes = {one.sizes for one in tally.raters.values()}
    if len(sizes) > 1:
        sentences.append(
            Text(
                "raters saw pictures at different sizes; the answers are pooled, see the table of "
                "raters"
            )
        )
    if tally.unfinished:
        left = ((one.rater, len(one.answered), len(one.order)) for one in tally.unfinished)
        some = Text.joined(
            ", ",
            [
                Text("{rater} ({done} of {total})", rater=rater, done=done, total=total)
                for rater, done, total in left
            ],
        )
        counts = tally.keys[0].rules.unfinished
        sentences.append(
            Text("unfinished sessions, counted: {some}", some=some)
            if counts
            else Text("unfinished sessions, not counted: {some}", some=some)
        )
    return sentences


def _document(tally: Tally, records: list[dict[str, object]]) -> dict[str, object]:
    own, others, skipped = tally.grades()
    graded = {
        "grades": own.count,
        "mean": _or_none(own.mean),
        "standard_deviation": _or_none(own.deviation),
        "of_others": others.count,
        "skipped": skipped,
        "published_mean": PUBLISHED_SATISFACTION if own.count else None,
    }
    return {
        "subjects": tally.subjects,
        "raters": len(tally.careful),
        "rules": [asdict(key.rules) for key in tally.keys],
        "care": [
            {**asdict(one), "reasons": [str(reason) for reason in one.reasons]}
            for one in tally.raters.values()
        ],
        "unfinished": [
            {"rater": one.rater, "answered": len(one.answered), "pictures": len(one.order)}
            for one in tally.unfinished
        ],
        "not_counted": [{"file": str(path), "why": str(why)} for path, why in tally.refused],
        "studies": [
            {name: value for name, value in key.to_dict().items() if name in _ORIGIN}
            for key in tally.keys
        ],
        "variants": records,
        "satisfaction": graded,
    }


def _row(
    variant: Variant, share: Share, everybody: Share, found: PictureFigures
) -> dict[str, object]:
    printed = tables.published(variant)
    low, high = share.interval
    return {
        **asdict(variant),
        "achieved": found.achieved,
        "lattice_in_warps": found.lattice_in_warps,
        "unnatural": share.hits,
        "answers": share.answers,
        "share": _or_none(share.value),
        "low": low,
        "high": high,
        "published": None if printed is None else printed / 100.0,
        "unnatural_everybody": everybody.hits,
        "answers_everybody": everybody.answers,
    }


def _or_none(value: float) -> float | None:
    return None if math.isnan(value) else value
