"""Report of table 2: bars, tables, records."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Sequence
from dataclasses import asdict, fields
from itertools import chain
from typing import Final

from kogao_core.base.language import Text
from kogao_core.lab.experiments import timing
from kogao_core.lab.experiments.experiment import Experiment, ExperimentOption, Work
from kogao_core.lab.experiments.timing import (
    AGAIN,
    PROCEDURES,
    SIZES,
    Procedure,
    Size,
    Timing,
    TimingResult,
)
from kogao_core.lab.experiments.trials import Trial, read
from kogao_core.lab.reports.report import NONE, Report, Table, recipe_in_words
from kogao_core.lab.reports.spread import Spread, in_columns, rounded
from kogao_core.pipeline import STAGES

_NAMES: Final[dict[Size, str]] = {
    "960x720": Text("960 x 720 px"),
    "own": Text("the photos' own size"),
}


def report(result: TimingResult) -> Report:
    """Return the report: table 2 and stages by size, manual trials, each photo."""
    sizes = [size for size in SIZES if any(timing.size == size for timing in result.timings)]
    parts = [part for size in sizes for part in (_table_2(result, size), _stages(result, size))]
    how = Text(
        "{recipe}; {warm_up} warm-up rounds, then {repeats} rounds, procedures in turns. "
        "Manual procedures use the points of the manual trial of the photo. Without a trial, "
        "manual procedures use the found points, treated as set by hand.",
        recipe=recipe_in_words(result.recipe),
        warm_up=result.warm_up,
        repeats=result.repeats,
    )
    return Report(
        Text("Table 2: setting and computing time"),
        Text(
            "How long does a warp take with manual or found landmarks, on the whole image or the "
            "reduced domain?"
        ),
        [*parts, *_by_hand(result), how],
        [_record(result, timing) for timing in result.timings],
        _document(result),
    )


def _table_2(result: TimingResult, size: Size) -> Table:
    header = (
        Text("method"),
        Text("setting, s"),
        Text("n"),
        Text("computing, ms"),
        Text("processor, ms"),
        Text("n"),
        Text("total, s"),
        Text("computing / conventional"),
        Text("processor / conventional"),
        Text("the paper: computing / conventional"),
    )
    rows = []
    again = result.of(size, AGAIN.name)
    for procedure, timings in [*_procedures(result, size), *([(AGAIN, again)] if again else [])]:
        is_again = procedure is AGAIN
        setting = None if is_again else _setting(result, timings, procedure)
        total = None if is_again else _total(result, timings, procedure)
        computing = _pooled(timings)
        processor = Spread.of([ms for timing in timings for ms in timing.processor_ms])
        rows.append((
            procedure.title, setting.text() if setting else NONE,
            str(setting.count) if setting else NONE, computing.text(), processor.text(),
            str(computing.count), total.text() if total else NONE,
            *(_of_conventional(result, size, procedure.name, of) for of in _CLOCKS),
            NONE if is_again else f"{procedure.computing_s / PROCEDURES[0].computing_s:.2f}",
        ))  # fmt: skip
    people = Text("No manual trial was given: manual procedures have no total.")
    if result.setting is not None:
        people = Text("Manual setting: from the first view to Apply, with corrections.")
    note = Text(
        "Median and quartiles of n runs. Automatic setting: networks loaded before. {people} "
        "The last row repeats the first row; smaller differences than between these two mean "
        "nothing. Processor: time of all threads. Reading, loading the networks and saving "
        "are not included. Last column: ratio printed in the paper.",
        people=people,
    )
    return Table(Text("Table 2 at {size}, measured here", size=_NAMES[size]), header, rows, note)


_CLOCKS: Final[tuple[Callable[[Timing], Sequence[float]], ...]] = (
    lambda timing: timing.computing_ms,
    lambda timing: timing.processor_ms,
)


def _by_hand(result: TimingResult) -> list[Table]:
    """Return setting times by hand and of the machine."""
    trials = result.trials_of("manual")
    if not trials:
        return []
    rows = [_set_by(Text("by hand"), trials)]
    for cold, called in ((True, Text("machine, cold")), (False, Text("machine, warm"))):
        found = [one for one in result.trials_of("automatic") if one.cold == cold]
        rows += [_set_by(called, found)] if found else []
    return [Table(
        Text("Setting time"),
        (
            Text("who"), Text("n"), Text("looking, s"), Text("to applying, s"),
            Text("corrections"), Text("correcting, s"), Text("all of it, s"), Text("landmarks"),
        ),
        rows,
        Text(
            "Medians and quartiles of n photos. The clock starts with the first view of the photo. "
            "Looking ends with the first point. Corrections after Apply belong to the same trial. "
            "Cold: the time contains loading the networks."
        ),
    )]  # fmt: skip


def _set_by(who: str, trials: Sequence[Trial]) -> list[str]:
    def spread(of: Callable[[Trial], float]) -> str:
        return Spread.of([of(one) for one in trials]).text()

    corrected = [sum(one.corrections_s) for one in trials if one.corrections_s]
    return [
        who, str(len(trials)), spread(lambda one: one.looking_s), spread(lambda one: one.setting_s),
        str(sum(len(one.corrections_s) for one in trials)),
        Spread.of(corrected).text() if corrected else NONE,
        spread(lambda one: one.total_s), spread(lambda one: one.landmarks),
    ]  # fmt: skip


def _procedures(result: TimingResult, size: Size) -> list[tuple[Procedure, list[Timing]]]:
    found = [(procedure, result.of(size, procedure.name)) for procedure in PROCEDURES]
    return [(procedure, timings) for procedure, timings in found if timings]


def _pooled(timings: Sequence[Timing]) -> Spread:
    return Spread.of([ms for timing in timings for ms in timing.computing_ms])


def _setting(
    result: TimingResult, timings: Sequence[Timing], procedure: Procedure
) -> Spread | None:
    """Return the setting time, s."""
    if not procedure.automatic:
        return result.setting
    return Spread.of([ms / 1e3 for timing in timings for ms in timing.setting_ms])


def _total(result: TimingResult, timings: Sequence[Timing], procedure: Procedure) -> Spread | None:
    """Return setting plus computing, s: by run, or by trial plus median computing time."""
    if procedure.automatic:
        both = (zip(one.setting_ms, one.computing_ms, strict=True) for one in timings)
        return Spread.of([sum(run) / 1e3 for run in chain.from_iterable(both)])
    if result.setting is None:
        return None
    computing_s = _pooled(timings).median / 1e3
    return Spread.of([one.total_s + computing_s for one in result.trials_of("manual")])


def _of_conventional(
    result: TimingResult, size: Size, procedure: str, clock: Callable[[Timing], Sequence[float]]
) -> str:
    """Return computing time relative to conventional: median of the photos' ratios."""
    base = {one.photo: one for one in result.of(size, PROCEDURES[0].name)}
    ratios = [
        statistics.median(clock(one)) / statistics.median(clock(base[one.photo]))
        for one in result.of(size, procedure)
        if one.photo in base
    ]
    return f"{statistics.median(ratios):.2f}" if ratios else NONE


def _stages(result: TimingResult, size: Size) -> Table:
    procedures = _procedures(result, size)
    rows: list[list[str]] = [[Text("finding faces and landmarks")]]
    for procedure, timings in procedures:
        setting = _setting(result, timings, procedure) if procedure.automatic else None
        rows[0].append(rounded(1e3 * setting.median) if setting else NONE)
    for name in procedures[0][1][0].stages_ms:
        medians = (
            statistics.median(ms for timing in timings for ms in timing.stages_ms[name])
            for _, timings in procedures
        )
        rows.append([STAGES[name], *map(rounded, medians)])
    header = (Text("stage"), *(procedure.title for procedure, _ in procedures))
    return Table(Text("Stages at {size}, median ms", size=_NAMES[size]), header, rows)


def _record(result: TimingResult, timing: Timing) -> dict[str, object]:
    procedure = next(one for one in (*PROCEDURES, AGAIN) if one.name == timing.procedure)
    stages = {f"{n}_ms": statistics.median(ms) for n, ms in timing.stages_ms.items()}
    return {
        **{name: getattr(timing, name) for name in ("photo", "size", "width", "height", "faces")},
        "way": timing.procedure,
        "domain_share": timing.domain_share,
        **in_columns("setting", _setting(result, [timing], procedure), 1e3),
        **in_columns("computing", Spread.of(timing.computing_ms)),
        "processor_median_ms": statistics.median(timing.processor_ms),
        **stages,
        "repeats": result.repeats,
    }


def _document(result: TimingResult) -> dict[str, object]:
    return {
        "experiment": "timing",
        "recipe": result.recipe.to_dict(),
        "repeats": result.repeats,
        "warm_up": result.warm_up,
        "paper": {procedure.name: asdict(procedure) for procedure in PROCEDURES},
        "trials": [
            {
                **{f.name: getattr(one, f.name) for f in fields(one) if f.name != "faces"},
                "landmarks": one.landmarks,
            }
            for one in result.trials
        ],
        "timings": [asdict(timing) for timing in result.timings],
    }


def _run(work: Work) -> Report:
    given = work.given
    trials = tuple(given["trials"])
    sizes = [one for one in SIZES if given["size"] in (one, "both")]
    timings: list[Timing] = []
    for subject in work.subjects:
        subject = timing.with_trial(subject, trials)
        found, missing = timing.measure(
            subject, work.source(), work.recipe, sizes=sizes, repeats=given["repeats"],
            warm_up=given["warm_up"], progress=work.progress,
        )  # fmt: skip
        timings += found
        for sentence in missing:
            work.leave_out(sentence)
    return report(
        TimingResult(tuple(timings), trials, work.recipe, given["repeats"], given["warm_up"])
    )


EXPERIMENT: Final = Experiment(
    "timing",
    Text("Setting and computing &time…"),
    Text("Setting and computing time (table 2)"),
    Text(
        "Table 2: setting and computing time, manual and automatic, whole image and reduced domain."
    ),
    _run,
    (
        ExperimentOption(
            "size",
            "both",
            names=("own", "960x720", "both"),
            help=Text("The photo's size, or the paper's (cropped and resized)."),
        ),
        ExperimentOption("repeats", 10, in_window=5),
        ExperimentOption("warm-up", 2, least=0, in_window=1),
        ExperimentOption(
            "trials",
            read=read,
            help=Text("Manual trials recorded by the editor (JSON lines); repeatable."),
        ),
    ),
)
