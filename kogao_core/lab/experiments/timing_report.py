"""Table 2 as a report: bars, tables, records; beside the paper's figures."""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence
from dataclasses import asdict
from itertools import chain
from typing import Final

from kogao_core.base.language import Text
from kogao_core.base.timing import STAGES
from kogao_core.lab.experiments.timing import (
    PROCEDURES,
    SIZES,
    Procedure,
    Size,
    Timing,
    TimingResult,
)
from kogao_core.lab.reports.charts import Chart, Series
from kogao_core.lab.reports.report import NONE, Report, Table, recipe_in_words
from kogao_core.lab.reports.spread import Spread, rounded

_TITLE: Final = Text("Table 2: setting and computing time")
_LEAD: Final = Text(
    "How long does it take to make a face smaller when landmarks and targets are "
    "set by hand or found, and when the whole image or only the reduced domain "
    "is warped?"
)
_NAMES: Final[dict[Size, str]] = {
    "960x720": Text("960 x 720 px"),
    "own": Text("the photos' own size"),
}
_SHORT: Final = {
    "conventional": Text("Conventional method"),
    "wdr": Text("Warping domain reduction"),
    "akt": Text("Automatic transformation"),
    "dual": Text("Dual method"),
}
_PAPER_MACHINE: Final = "Intel Core Duo T2300, 1.66 GHz, 2011"


def report(result: TimingResult) -> Report:
    """Return table 2 and the stages for each size, then the photos one by one."""
    sizes = [size for size in SIZES if any(timing.size == size for timing in result.timings)]
    parts = [
        part
        for size in sizes
        for part in (
            _chart(result, size), _table_2(result, size), _beside_the_paper(result, size),
            _stages(result, size),
        )
    ]  # fmt: skip
    how = Text(
        "{recipe}; {warm_up} rounds to warm up, then {repeats} that "
        "count, the four ways in turns. Manual ways are computed with the points "
        "that were found, held as if set by hand: where a point lies doesn't "
        "change what its warp costs.",
        recipe=recipe_in_words(result.recipe),
        warm_up=result.warm_up,
        repeats=result.repeats,
    )
    return Report(
        _TITLE, _LEAD, [*parts, _photos(result), how], _records(result), _document(result)
    )


def _chart(result: TimingResult, size: Size) -> Chart:
    procedures = _procedures(result, size)
    settings = [_setting(result, timings, procedure) for procedure, timings in procedures]
    computings = [_pooled(timings) for _, timings in procedures]
    series = (
        _bars(Text("setting, here"), settings, 1.0),
        Series(Text("setting, the paper"), [procedure.setting_s for procedure, _ in procedures]),
        _bars(Text("computing, here"), computings, 1e-3),
        Series(
            Text("computing, the paper"), [procedure.computing_s for procedure, _ in procedures]
        ),
    )
    caption = Text(
        "At {size}: medians with quartiles. A division is ten times the one "
        "before. The paper says less than 1 s for automatic setting.",
        size=_NAMES[size],
    )
    return Chart(
        Text("Table 2 at {size}", size=_NAMES[size]), [_SHORT[one.name] for one, _ in procedures],
        Text("time, s"), series, bars=True, logarithmic=True, caption=caption,
    )  # fmt: skip


def _bars(name: str, spreads: Sequence[Spread | None], unit_s: float) -> Series:
    missing = Spread(math.nan, math.nan, math.nan, 0)
    known = [spread or missing for spread in spreads]
    return Series(
        name,
        [unit_s * one.median for one in known],
        [(unit_s * one.q1, unit_s * one.q3) for one in known],
    )


def _table_2(result: TimingResult, size: Size) -> Table:
    header = (
        Text("method"),
        Text("setting, s"),
        Text("computing, ms"),
        Text("total, s"),
        Text("computing / conventional"),
    )
    rows = []
    for procedure, timings in _procedures(result, size):
        setting, total = _setting(result, timings, procedure), _total(result, timings, procedure)
        ratio = _of_conventional(result, size, procedure.name)
        rows.append((
            procedure.title, setting.text() if setting else NONE, _pooled(timings).text(),
            total.text() if total else NONE, NONE if ratio is None else f"{ratio:.2f}",
        ))  # fmt: skip
    if result.setting is None:
        note = Text(
            "Median and quartiles of all runs. No session of setting by hand was given, so there "
            "is no total with one."
        )
    else:
        note = Text(
            "Median and quartiles of all runs. Recorded sessions of setting by hand: {count}.",
            count=result.setting.count,
        )
    return Table(Text("Table 2 at {size}, measured here", size=_NAMES[size]), header, rows, note)


def _beside_the_paper(result: TimingResult, size: Size) -> Table:
    header = (
        Text("method"), Text("setting, s"), Text("computing, s"), Text("total, s"),
        Text("computing / conventional"), Text("paper's computing / here"),
        Text("paper's total / here"),
    )  # fmt: skip
    rows = []
    for procedure, timings in _procedures(result, size):
        total = _total(result, timings, procedure)
        rows.append((
            procedure.title, f"{'<' if procedure.automatic else ''}{procedure.setting_s:g}",
            f"{procedure.computing_s:.3f}", f"{procedure.total_s:.3f}",
            f"{procedure.computing_s / PROCEDURES[0].computing_s:.2f}",
            rounded(1e3 * procedure.computing_s / _pooled(timings).median),
            rounded(procedure.total_s / total.median) if total else NONE,
        ))  # fmt: skip
    note = Text(
        "The paper worked at 960 x 720 px on an {machine}; the last two "
        "columns divide its times by the medians at {size} here: they compare "
        "machines and programs together. Its text says 6.3 and 3.2 s where its "
        "table, as here, says 7.102 and 4.722 s.",
        machine=_PAPER_MACHINE,
        size=_NAMES[size],
    )
    return Table(Text("The paper's table 2, and how many times faster here"), header, rows, note)


def _procedures(result: TimingResult, size: Size) -> list[tuple[Procedure, list[Timing]]]:
    found = [(procedure, result.of(size, procedure.name)) for procedure in PROCEDURES]
    return [(procedure, timings) for procedure, timings in found if timings]


def _pooled(timings: Sequence[Timing]) -> Spread:
    return Spread.of([ms for timing in timings for ms in timing.computing_ms])


def _setting(
    result: TimingResult, timings: Sequence[Timing], procedure: Procedure
) -> Spread | None:
    """Return the time to set everything, s."""
    if not procedure.automatic:
        return result.setting
    return Spread.of([ms / 1e3 for timing in timings for ms in timing.setting_ms])


def _total(result: TimingResult, timings: Sequence[Timing], procedure: Procedure) -> Spread | None:
    """Return setting and computing together, s: run by run, or each session with the median."""
    if procedure.automatic:
        both = (zip(one.setting_ms, one.computing_ms, strict=True) for one in timings)
        return Spread.of([sum(run) / 1e3 for run in chain.from_iterable(both)])
    if result.setting is None:
        return None
    computing_s = _pooled(timings).median / 1e3
    return Spread.of([one.setting_s + computing_s for one in result.setting_times])


def _of_conventional(result: TimingResult, size: Size, procedure: str) -> float | None:
    """Return computing time against the conventional one: median of the photos' ratios."""
    base = {one.photo: one for one in result.of(size, PROCEDURES[0].name)}
    ratios = [
        statistics.median(one.computing_ms) / statistics.median(base[one.photo].computing_ms)
        for one in result.of(size, procedure)
        if one.photo in base
    ]
    return statistics.median(ratios) if ratios else None


def _stages(result: TimingResult, size: Size) -> Table:
    procedures = _procedures(result, size)
    rows: list[list[str]] = [[Text("finding faces and landmarks")]]
    for procedure, timings in procedures:
        setting = _setting(result, timings, procedure) if procedure.automatic else None
        rows[0].append(rounded(1e3 * setting.median) if setting else NONE)
    for name in procedures[0][1][0].stages_ms:
        rows.append([STAGES[name], *(rounded(_stage(timings, name)) for _, timings in procedures)])
    header = (Text("stage"), *(_SHORT[procedure.name] for procedure, _ in procedures))
    return Table(Text("Stages at {size}, median ms", size=_NAMES[size]), header, rows)


def _stage(timings: Sequence[Timing], name: str) -> float:
    return statistics.median(ms for timing in timings for ms in timing.stages_ms[name])


def _photos(result: TimingResult) -> Table:
    header = (
        Text("photo"), Text("width"), Text("height"), Text("faces"), Text("domain, % of image"),
        Text("conventional, ms"), Text("wdr, ms"), Text("wdr / conventional"), Text("finding, ms"),
    )  # fmt: skip
    rows = []
    for size in SIZES:
        by_hand = zip(result.of(size, "conventional"), result.of(size, "wdr"), strict=True)
        finding = {one.photo: Spread.of(one.setting_ms) for one in result.of(size, "dual")}
        for whole, reduced in by_hand:
            all_of_it, part = Spread.of(whole.computing_ms), Spread.of(reduced.computing_ms)
            found = finding.get(whole.photo)
            rows.append([
                whole.photo, str(whole.width), str(whole.height), str(whole.faces),
                f"{100.0 * reduced.domain_share:.1f}", all_of_it.text(), part.text(),
                f"{part.median / all_of_it.median:.2f}", found.text() if found else NONE,
            ])  # fmt: skip
    return Table(
        Text("Photo by photo"), header, rows, Text("Computing and finding: median and quartiles.")
    )


def _records(result: TimingResult) -> list[dict[str, object]]:
    procedures = {procedure.name: procedure for procedure in PROCEDURES}
    return [_record(result, timing, procedures[timing.procedure]) for timing in result.timings]


def _record(result: TimingResult, timing: Timing, procedure: Procedure) -> dict[str, object]:
    computing = Spread.of(timing.computing_ms)
    setting = _setting(result, [timing], procedure)
    stages = {f"{n}_ms": statistics.median(ms) for n, ms in timing.stages_ms.items()}
    return {
        "photo": timing.photo,
        "size": timing.size,
        "width": timing.width,
        "height": timing.height,
        "faces": timing.faces,
        "way": timing.procedure,
        "domain_share": timing.domain_share,
        "setting_median_ms": 1e3 * setting.median if setting else None,
        "setting_q1_ms": 1e3 * setting.q1 if setting else None,
        "setting_q3_ms": 1e3 * setting.q3 if setting else None,
        "computing_median_ms": computing.median,
        "computing_q1_ms": computing.q1,
        "computing_q3_ms": computing.q3,
        **stages,
        "repeats": result.repeats,
        "paper_setting_s": procedure.setting_s,
        "paper_computing_s": procedure.computing_s,
        "paper_total_s": procedure.total_s,
    }


def _document(result: TimingResult) -> dict[str, object]:
    return {
        "experiment": "timing",
        "recipe": result.recipe.to_dict(),
        "repeats": result.repeats,
        "warm_up": result.warm_up,
        "paper": {procedure.name: asdict(procedure) for procedure in PROCEDURES},
        "sessions": [asdict(one) for one in result.setting_times],
        "timings": [asdict(timing) for timing in result.timings],
    }
