"""The report of a study: tables in the shape of the paper's, its figures beside."""

from __future__ import annotations

import math
from collections.abc import Sequence
from statistics import fmean
from typing import Final

from kogao_core.base.language import Text
from kogao_core.faces.naturalness import DISTANCES, STUDENTS, SUBJECTS, UNNATURAL
from kogao_core.lab.reports.charts import Chart, Series
from kogao_core.lab.reports.report import NONE, Heading, Part, Report, Row, Table
from kogao_core.lab.study.sources import document_of, notes, studies
from kogao_core.lab.study.statistics import Share
from kogao_core.lab.study.tally import Tally
from kogao_core.lab.study.variants import Kind, Variant

PUBLISHED_SATISFACTION: Final = 92
PUBLISHED_USERS: Final = 20
_TITLE: Final = Text("How natural do the faces look?")
_LEAD: Final = Text(
    "People called pictures natural or unnatural without knowing how they were made."
)
_ACHIEVED: Final = Text(
    "Achieved: how far landmarks came towards the centre on average; the paper's "
    "own figures are those that were asked for."
)
_INDEPENDENCE: Final = Text(
    "Intervals are Wilson's at 95 %. They take every answer as independent; "
    "answers of one person, or about one face, are not, so the true uncertainty "
    "is larger."
)


def published(variant: Variant) -> float | None:
    """Return table 1's share of "unnatural" for a variant, %; None where the paper prints none."""
    if variant.kind != "table1" or variant.percent not in DISTANCES:
        return None
    return UNNATURAL[variant.center - 1][DISTANCES.index(variant.percent)]


def table_1(tally: Tally) -> Table:
    """Return unnaturalness by centre candidate and warp distance; the paper's in its own rows."""
    rows = []
    for center, printed in enumerate(UNNATURAL, start=1):
        shares = [_share(tally, "table1", percent, center) for percent in DISTANCES]
        came = [_achieved(tally, percent, center) for percent in DISTANCES]
        candidate = Text("candidate\N{NO-BREAK SPACE}{center}", center=center)
        rows.append([candidate, *map(_percent, shares)])
        rows.append([Text("achieved, % of D"), *came])
        rows.append([Text("the paper"), *(f"{value:.3f} %" for value in printed)])
    return Table(
        Text("Unnaturalness by centre candidate and warp distance (table 1)"),
        (
            Text("asked for"),
            *(Text("{percent:g} % of D", percent=percent) for percent in DISTANCES),
        ),
        rows,
        Text(
            "{basis} {achieved} The paper: {subjects} faces, {students} students; "
            "each of its figures but one, which may be a slip, is a multiple of 1/160, so "
            "about 160 answers stand behind each. {independence}",
            basis=_basis(tally),
            achieved=_ACHIEVED,
            subjects=SUBJECTS,
            students=STUDENTS,
            independence=_INDEPENDENCE,
        ),
    )


def figure_11(tally: Tally) -> Table:
    """Return unnaturalness by lattice size."""
    rows = [_size_row(tally, f"R = {v.lattice:g}", v) for v, _ in _of(tally, "figure11")]
    rows += [_size_row(tally, Text("the photo as it is"), v) for v, _ in _of(tally, "control")]
    return Table(
        Text("Unnaturalness by lattice size (figure 11)"),
        (
            Text("lattice, landmark spacings"), Text("lattice, warp distances"),
            Text("achieved, % of D"), Text("unnatural"),
        ),
        rows,
        Text(
            "{basis} R is told in mean landmark spacings. The paper's own figure "
            "divides by the warp distance: that is the second column. The paper "
            "prints no figures for its plot; its text says that no face was called "
            "unnatural once the lattice was larger than the warp distance, above 1 "
            "in that column. Sizes achieve different distances, so they are compared "
            "together with these.",
            basis=_basis(tally),
        ),
    )  # fmt: skip


def _size_row(tally: Tally, title: str, variant: Variant) -> list[str]:
    found = tally.measured.get(variant)
    in_warps = None if found is None else found.lattice_in_warps
    return [
        title,
        NONE if in_warps is None else f"{in_warps:.2f}",
        NONE if found is None else f"{found.achieved:.2f}",
        _percent(tally.shares[variant]),
    ]


def satisfaction(tally: Tally) -> Table:
    """Return mean and deviation of the grades beside the paper's mean."""
    grades = tally.satisfaction
    row = [str(grades.count), _number(grades.mean), _number(grades.deviation), str(tally.skipped)]
    return Table(
        Text("Satisfaction, 0 to 100 (section 5)"),
        ("", Text("grades"), Text("mean"), Text("standard deviation"), Text("not graded")),
        [[Text("this study"), *row], [Text("the paper"), str(PUBLISHED_USERS), "92", NONE, NONE]],
        Text("The paper's users graded the picture of themselves; it prints no deviation."),
    )


def report(tally: Tally) -> Report:
    """Return the report of a tally."""
    parts: list[Part] = [Row(_distance_charts(tally), wide=True)]
    parts += [Heading(Text("Warp distance and centre")), table_1(tally)]
    parts += [Heading(Text("Lattice size")), figure_11(tally)]
    if _of(tally, "figure11"):
        parts.append(_lattice_chart(tally))
    parts += [Heading(Text("Satisfaction")), satisfaction(tally)]
    parts += [Heading(Text("Where it comes from")), studies(tally)]
    parts += [Text("Note: {sentence}.", sentence=sentence) for sentence in notes(tally)]
    return Report(_TITLE, _LEAD, parts, _records(tally), _document(tally))


def _document(tally: Tally) -> dict[str, object]:
    grades = tally.satisfaction
    return {
        "subjects": tally.subjects,
        "raters": tally.raters,
        "torn_lines": tally.torn,
        "unfinished": [
            {"rater": one.rater, "answered": len(one.answered), "pictures": len(one.order)}
            for one in tally.unfinished
        ],
        "not_counted": [{"file": str(path), "study": study} for path, study in tally.foreign],
        "studies": [document_of(key) for key in tally.keys],
        "variants": _records(tally),
        "satisfaction": {
            "grades": grades.count,
            "mean": _or_none(grades.mean),
            "standard_deviation": _or_none(grades.deviation),
            "skipped": tally.skipped,
            "published_mean": PUBLISHED_SATISFACTION,
        },
    }


def _records(tally: Tally) -> list[dict[str, object]]:
    return [_row(tally, variant, share) for variant, share in tally.shares.items()]


def _row(tally: Tally, variant: Variant, share: Share) -> dict[str, object]:
    printed, found = published(variant), tally.measured.get(variant)
    low, high = share.interval
    return {
        "kind": variant.kind,
        "percent": variant.percent,
        "center": variant.center,
        "lattice": variant.lattice,
        "achieved": found.achieved if found else None,
        "lattice_in_warps": found.lattice_in_warps if found else None,
        "unnatural": share.hits,
        "answers": share.answers,
        "share": _or_none(share.value),
        "low": low,
        "high": high,
        "published": None if printed is None else printed / 100.0,
    }


def _of(tally: Tally, kind: Kind) -> list[tuple[Variant, Share]]:
    return [(variant, share) for variant, share in tally.shares.items() if variant.kind == kind]


def _share(tally: Tally, kind: Kind, percent: float, center: int) -> Share:
    found = [s for v, s in _of(tally, kind) if (v.percent, v.center) == (percent, center)]
    return Share(sum(s.hits for s in found), sum(s.answers for s in found))


def _achieved(tally: Tally, percent: float, center: int) -> str:
    found = [
        one.achieved
        for v, one in tally.measured.items()
        if (v.kind, v.percent, v.center) == ("table1", percent, center)
    ]
    return f"{fmean(found):.2f}" if found else NONE


def _percent(share: Share) -> str:
    if not share.answers:
        return NONE
    low, high = (100.0 * end for end in share.interval)
    return Text(
        "{value:.1f} % ({low:.1f} to {high:.1f})", value=100.0 * share.value, low=low, high=high
    )


def _basis(tally: Tally) -> str:
    counts = [share.answers for share in tally.shares.values()]
    low, high = min(counts), max(counts)
    answers = (
        Text.counted(high, "{n} answer", "{n} answers")
        if low == high
        else Text.counted(high, "{low} to {n} answer", "{low} to {n} answers", low=low)
    )
    faces = Text.counted(tally.subjects, "{n} face", "{n} faces")
    raters = Text.counted(tally.raters, "{n} rater", "{n} raters")
    return Text(
        "{faces}, {raters}, {answers} to each kind of picture.",
        faces=faces,
        raters=raters,
        answers=answers,
    )


def _distance_charts(tally: Tally) -> list[Chart]:
    """Return the study and the paper side by side, all centres."""
    names = [
        Text("centre candidate {center}", center=center) for center in range(1, len(UNNATURAL) + 1)
    ]
    shares = [
        [_share(tally, "table1", percent, center) for percent in DISTANCES]
        for center in range(1, len(names) + 1)
    ]
    here = [_series(name, row) for name, row in zip(names, shares, strict=True)]
    there = [Series(name, row) for name, row in zip(names, UNNATURAL, strict=True)]
    most = max([100.0, *(value for row in UNNATURAL for value in row)])
    return [
        Chart(
            Text("Unnaturalness by warp distance, {whose}", whose=whose),
            [f"{p:g}" for p in DISTANCES],
            Text("unnatural, %"), series, along=Text("warp distance, % of D"), caption=caption,
            most=most,
        )
        for whose, series, caption in (
            (Text("this study"), here, Text("This study, with intervals of 95 %.")),
            (Text("the paper"), there, Text("The paper's table 1, which prints no intervals.")),
        )
    ]  # fmt: skip


def _lattice_chart(tally: Tally) -> Chart:
    found = _of(tally, "figure11")
    return Chart(
        Text("Unnaturalness by lattice size"), [f"{variant.lattice:g}" for variant, _ in found],
        Text("unnatural, %"), [_series(Text("this study"), [share for _, share in found])],
        along=Text("lattice spacing R, landmark spacings"), most=100.0,
        caption=Text("In the shape of figure 11, which has no printed figures to put beside."),
    )  # fmt: skip


def _series(name: str, shares: Sequence[Share]) -> Series:
    ends = [(100.0 * low, 100.0 * high) for low, high in (share.interval for share in shares)]
    return Series(name, [100.0 * share.value for share in shares], ends)


def _number(value: float) -> str:
    return NONE if math.isnan(value) else f"{value:.1f}"


def _or_none(value: float) -> float | None:
    return None if math.isnan(value) else value
