"""Export of a study for other programs: tables of answers and raters, codebook, R script.

CSV in UTF-8 with ASCII column names, decimal points, 0 and 1 for no and yes, and empty fields for
missing values. pandas, R, jamovi and JASP read the files directly.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from importlib import resources
from typing import Any, Final, Generic, TypeVar

from kogao_core.base.language import Text
from kogao_core.batch.measures import table_text
from kogao_core.lab.study.results import Display
from kogao_core.lab.study.tally import Answered, Quality, Tally

_Row = TypeVar("_Row")


@dataclass(frozen=True, slots=True)
class Column(Generic[_Row]):
    """A column of a table: name, meaning, and a function for the value of a row."""

    name: str
    meaning: str
    value: Callable[[Tally, _Row], Any]


def _display(find: Callable[[Display], Any]) -> Callable[[Tally, Answered], Any]:
    def value(_: Tally, row: Answered) -> Any:
        return None if row.record.display is None else find(row.record.display)

    return value


def _asked(_: Tally, row: Answered) -> float:
    asked = row.meaning.measured.asked
    return row.variant.percent if asked is None else asked


_MEASURED: Final = "achieved move of the landmarks towards the centre, % of D"
ANSWERS: Final[Sequence[Column[Answered]]] = (
    Column("study", "the study's name", lambda _, row: row.key.identity),
    Column("rater", "the rater's code", lambda _, row: row.session.rater),
    Column("trial", "position in the rater's session, from 1", lambda _, row: row.place),
    Column("picture", "the picture's file", lambda _, row: row.record.picture),
    Column("subject", "the face: its photo's file; other photos of that name are numbered",
           lambda _, row: row.subject),
    Column("kind",
           "table1, figure11, control (original photo), catch (cut in two) or "
           "satisfaction (the rater's own face)",
           lambda _, row: row.variant.kind),
    Column("percent", "warp distance, % of D, as designed; below 0 larger",
           lambda _, row: row.variant.percent),
    Column("asked_percent", "warp distance of the recipe, % of D", _asked),
    Column("achieved_percent", _MEASURED, lambda _, row: row.meaning.measured.achieved),
    Column("center", "centre candidate, 1 to 4", lambda _, row: row.variant.center),
    Column("lattice", "lattice spacing R, in the unit of the recipe",
           lambda _, row: row.variant.lattice),
    Column("lattice_in_warps", "lattice spacing in mean warp distances",
           lambda _, row: row.meaning.measured.lattice_in_warps),
    Column("fit", "fit of the lattice: approximation, exact or multilevel",
           lambda _, row: row.variant.fit),
    # In lower case: R reads a column of F as FALSE.
    Column("natural_key", "the key for natural", lambda _, row: row.session.keys[0]),
    Column("answer", "natural or unnatural", lambda _, row: row.record.answer),
    Column("unnatural", "1 for unnatural",
           lambda _, row: None if row.is_unnatural is None else int(row.is_unnatural)),
    Column("grade", "0 to 100", lambda _, row: row.record.grade),
    Column("ms", "time from the painted picture to the answer, ms, without away_ms",
           lambda _, row: row.record.took_ms),
    Column("away_ms", "time in another tab or window, ms", lambda _, row: row.record.away_ms),
    Column("shown_width", "width of the picture, CSS px", _display(lambda d: d.shown[0])),
    Column("shown_height", "height of the picture, CSS px", _display(lambda d: d.shown[1])),
    Column("window_width", "width of the viewport, CSS px", _display(lambda d: d.window[0])),
    Column("window_height", "height of the viewport, CSS px", _display(lambda d: d.window[1])),
    Column("pixel_ratio", "device px per CSS px", _display(lambda d: d.ratio)),
    Column("counts", "1 if the report counts the answer",
           lambda tally, row: int(not tally.reasons(row))),
    Column("why_not", "reasons for exclusion", lambda tally, row: _joined(tally.reasons(row))),
)  # fmt: skip
RATERS: Final[Sequence[Column[Quality]]] = (
    Column("rater", "the rater's code", lambda _, one: one.rater),
    Column("answers", "answers, without undone ones", lambda _, one: one.answers),
    Column("median_ms", "median of ms", lambda _, one: one.median_ms),
    Column("quick", "share of answers below the minimum time", lambda _, one: one.quick),
    Column("unnatural_share", "share of unnatural, without catch pictures",
           lambda _, one: one.unnatural),
    Column("longest_run", "longest run of equal answers",
           lambda _, one: one.longest_run),
    Column("twin_pairs", "pairs of identical pictures", lambda _, one: one.pairs),
    Column("twins_agreeing", "twin pairs with equal answers", lambda _, one: one.agreeing),
    Column("catches", "catch pictures", lambda _, one: one.catches),
    Column("caught", "catch pictures called unnatural", lambda _, one: one.caught),
    Column("follows_auc", "AUC of the answers over the achieved distance: 1 perfect, 0.5 "
           "guessing", lambda _, one: one.follows),
    Column("away_total_ms", "time in another tab or window during trials, ms",
           lambda _, one: one.away_ms),
    Column("taken_back", "undone answers", lambda _, one: one.taken_back),
    Column("rater_counts", "1 if the report counts the rater",
           lambda _, one: int(not one.reasons)),
    Column("rater_why_not", "reasons for exclusion", lambda _, one: _joined(one.reasons)),
)  # fmt: skip


def files(tally: Tally) -> dict[str, str]:
    """Return the text of each file, by file name."""
    codebook = [
        (file, column.name, column.meaning)
        for file, columns in (("answers.csv", ANSWERS), ("raters.csv", RATERS))
        for column in columns
    ]
    return {
        "answers.csv": _filled(ANSWERS, tally, tally.answers),
        "raters.csv": _filled(RATERS, tally, tally.raters.values()),
        "codebook.csv": table_text([("file", "column", "meaning"), *codebook]),
        "model.R": resources.files(__package__).joinpath("model.R").read_text(encoding="utf-8"),
    }


def _filled(columns: Sequence[Column[Any]], tally: Tally, rows: Iterable[Any]) -> str:
    head = [column.name for column in columns]
    return table_text([head, *([column.value(tally, row) for column in columns] for row in rows)])


def _joined(reasons: Sequence[Text]) -> str:
    return "; ".join(map(str, reasons))
