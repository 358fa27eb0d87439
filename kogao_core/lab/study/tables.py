"""Tables and charts of a study, in the form of the paper's, with the paper's figures."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from statistics import fmean
from typing import Final

from kogao_core.base.language import Text
from kogao_core.lab.reports.charts import Chart, Series
from kogao_core.lab.reports.report import NONE, Table
from kogao_core.lab.study.design import Group, Kind, Variant
from kogao_core.lab.study.shares import Share
from kogao_core.lab.study.tally import Tally
from kogao_core.paper.table1 import DISTANCES, STUDENTS, SUBJECTS, UNNATURAL
from kogao_core.recipe.recipe import SETTINGS

PUBLISHED_SATISFACTION: Final = 92
PUBLISHED_USERS: Final = 20
_ACHIEVED: Final = Text(
    "Achieved: mean move of the landmarks towards the centre. The paper's rows are for "
    "requested distances."
)
_INDEPENDENCE: Final = Text(
    "Intervals of 95 % for new raters and new faces: answers of one rater, or about one face, are "
    "dependent."
)
Shares = Mapping[Variant, Share]


def published(variant: Variant) -> float | None:
    """Return the paper's share of "unnatural" for a variant, %; None if not printed."""
    return _published(variant.percent, variant.center) if variant.kind == "table1" else None


def table_1(tally: Tally, shares: Shares, who: str, people: int) -> Table:
    """Return the shares of "unnatural" by centre and warp distance, with the paper's rows."""
    return Table(
        Text("Unnaturalness by centre candidate and warp distance (table 1), {who}", who=who),
        _asked_for(_distances(shares)),
        _by_group(tally, shares, lambda percent, group: _percent(_share(shares, percent, group))),
        _note_1(_basis(tally, shares, people)),
    )


def _asked_for(distances: Sequence[float]) -> list[str]:
    return [Text("requested"), *(Text("{percent:g} % of D", percent=p) for p in distances)]


def _by_group(
    tally: Tally, found: Mapping[Variant, object], cell: Callable[[float, Group], str]
) -> list[list[str]]:
    """Return rows of cells by distance for each centre, with achieved and published values."""
    rows: list[list[str]] = []
    distances = _distances(found)
    for group in _groups(found):
        rows.append([_named(group, found), *(cell(percent, group) for percent in distances)])
        rows.append([Text("achieved, % of D"), *(_achieved(tally, p, group) for p in distances)])
        printed = [_published(percent, group[0]) for percent in distances]
        if any(value is not None for value in printed):
            cells = [NONE if value is None else f"{value:.3f} %" for value in printed]
            rows.append([Text("the paper"), *cells])
    return rows


def _note_1(basis: str) -> Text:
    return Text(
        "{basis} {achieved} The paper: {subjects} faces, {students} students. All printed "
        "figures but one are multiples of 1/160: about 160 answers each. {independence}",
        basis=basis,
        achieved=_ACHIEVED,
        subjects=SUBJECTS,
        students=STUDENTS,
        independence=_INDEPENDENCE,
    )


def figure_11(tally: Tally, shares: Shares) -> Table:
    """Return the shares of "unnatural" by lattice size."""
    rows = [
        _size_row(tally, f"R = {v.lattice:g}", v, share) for v, share in of_kind(shares, "figure11")
    ]
    control = Text("original photo")
    rows += [_size_row(tally, control, v, share) for v, share in of_kind(shares, "control")]
    return Table(
        Text("Unnaturalness by lattice size (figure 11)"),
        (
            Text("lattice, landmark spacings"), Text("lattice, warp distances"),
            Text("achieved, % of D"), Text("unnatural"),
        ),
        rows,
        Text(
            "{basis} The paper prints no numbers; all its faces looked natural above 1 warp "
            "distance. Rows differ in achieved distance, too.",
            basis=_basis(tally, shares, len(tally.careful)),
        ),
    )  # fmt: skip


def _size_row(tally: Tally, title: str, variant: Variant, share: Share) -> list[str]:
    found = tally.measured()[variant]
    in_warps = found.lattice_in_warps
    return [
        title,
        NONE if in_warps is None else f"{in_warps:.2f}",
        f"{found.achieved:.2f}",
        _percent(share),
    ]


def satisfaction(tally: Tally) -> Table:
    """Return the grades, with the paper's mean for grades of the rater's own face."""
    own, others, skipped = tally.grades()
    here = [
        (Text("of the own face"), own, str(skipped)),
        (Text("of several faces, so of other people"), others, NONE),
    ]
    rows: list[list[str]] = [
        [name, str(grades.count), _number(grades.mean), _number(grades.deviation), left]
        for name, grades, left in here
        if grades.count or grades is own
    ]
    if own.count:
        rows.append([Text("the paper"), str(PUBLISHED_USERS), "92", NONE, NONE])
    return Table(
        Text("Satisfaction, 0 to 100 (section 5)"),
        ("", Text("grades"), Text("mean"), Text("standard deviation"), Text("not graded")),
        rows,
        Text(
            "The paper's users graded the picture of their own face; the paper prints no deviation."
        ),
    )


def distance_charts(shares: Shares) -> list[Chart]:
    """Return charts of the study and the paper side by side, all centres."""
    distances = _distances(shares)
    here = [
        _series(_named(group, shares), [_share(shares, percent, group) for percent in distances])
        for group in _groups(shares)
    ]
    there = [
        Series(Text("centre candidate {center}", center=center), row)
        for center, row in enumerate(UNNATURAL, start=1)
    ]
    most = max([100.0, *(value for row in UNNATURAL for value in row)])
    return [
        Chart(
            Text("Unnaturalness by warp distance, {who}", who=who),
            [f"{p:g}" for p in places],
            Text("unnatural, %"), series, along=Text("warp distance, % of D"), caption=caption,
            most=most,
        )
        for who, places, series, caption in (
            (Text("this study"), distances, here, Text("This study, with intervals of 95 %.")),
            (
                Text("the paper"), DISTANCES, there,
                Text("The paper's table 1, which prints no intervals."),
            ),
        )
    ]  # fmt: skip


def lattice_chart(shares: Shares) -> Chart:
    """Return unnaturalness by lattice size."""
    found = of_kind(shares, "figure11")
    return Chart(
        Text("Unnaturalness by lattice size"), [f"{variant.lattice:g}" for variant, _ in found],
        Text("unnatural, %"), [_series(Text("this study"), [share for _, share in found])],
        along=Text("lattice spacing R, landmark spacings"), most=100.0,
        caption=Text("In the form of figure 11. The paper prints no numbers for figure 11."),
    )  # fmt: skip


def _series(name: str, shares: Sequence[Share]) -> Series:
    ends = [(100.0 * low, 100.0 * high) for low, high in (share.interval for share in shares)]
    return Series(name, [100.0 * share.value for share in shares], ends)


def of_kind(shares: Shares, kind: Kind) -> list[tuple[Variant, Share]]:
    """Return the shares of the pictures of one kind."""
    return [(variant, share) for variant, share in shares.items() if variant.kind == kind]


def _distances(shares: Mapping[Variant, object]) -> list[float]:
    return sorted({variant.percent for variant in shares if variant.kind == "table1"})


def _groups(shares: Mapping[Variant, object]) -> list[Group]:
    return sorted({variant.group for variant in shares if variant.kind == "table1"})


def _named(group: Group, shares: Mapping[Variant, object]) -> Text:
    """Return the name of a group of pictures, with the fit if there are several fits."""
    center, fit = group
    candidate = Text("candidate\N{NO-BREAK SPACE}{center}", center=center)
    if len({fit for _, fit in _groups(shares)}) == 1:
        return candidate
    word = SETTINGS["fit"].alternative(fit).word
    return Text("{candidate}, {fit} fit", candidate=candidate, fit=word)


def _share(shares: Shares, percent: float, group: Group) -> Share:
    found = [s for v, s in of_kind(shares, "table1") if (v.percent, v.group) == (percent, group)]
    judgements = [one for share in found for one in share.judgements]
    return dataclasses.replace(found[0], judgements=tuple(judgements)) if found else Share()


def _published(percent: float, center: int) -> float | None:
    return UNNATURAL[center - 1][DISTANCES.index(percent)] if percent in DISTANCES else None


def _achieved(tally: Tally, percent: float, group: Group) -> str:
    found = [
        one.achieved
        for v, one in tally.measured().items()
        if (v.kind, v.percent, v.group) == ("table1", percent, group)
    ]
    return f"{fmean(found):.2f}" if found else NONE


def _percent(share: Share) -> str:
    if not share.answers:
        return NONE
    low, high = (100.0 * end for end in share.interval)
    return Text(
        "{value:.1f} % ({low:.1f} to {high:.1f})", value=100.0 * share.value, low=low, high=high
    )


def _number(value: float) -> str:
    return NONE if math.isnan(value) else f"{value:.1f}"


def _basis(tally: Tally, shares: Shares, people: int) -> str:
    counts = [share.answers for share in shares.values()]
    low, high = min(counts), max(counts)
    answers = (
        Text.counted(high, "{n} answer", "{n} answers")
        if low == high
        else Text.counted(high, "{low} to {n} answer", "{low} to {n} answers", low=low)
    )
    faces = Text.counted(tally.subjects, "{n} face", "{n} faces")
    raters = Text.counted(people, "{n} rater", "{n} raters")
    return Text(
        "{faces}, {raters}, {answers} per kind of picture.",
        faces=faces,
        raters=raters,
        answers=answers,
    )
