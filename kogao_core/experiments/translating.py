"""A report in the user's language: what people read of it; its data stay as they are."""

from __future__ import annotations

from dataclasses import replace

from kogao_core.experiments.charts import Chart
from kogao_core.experiments.report import Heading, Part, Picture, Report, Row, Table
from kogao_core.language import translated


def translated_report(report: Report) -> Report:
    """Return a report whose texts are said in the language at work.

    Parameters
    ----------
    report : Report
        As an experiment made it, in English.

    Returns
    -------
    Report
        With the same records and document.
    """
    return replace(
        report,
        title=translated(report.title),
        lead=translated(report.lead),
        parts=[_part(part) for part in report.parts],
    )


def _part(part: Part) -> Part:
    match part:
        case str():
            return translated(part)
        case Heading():
            return replace(part, text=translated(part.text))
        case Table():
            return Table(
                translated(part.caption),
                list(map(translated, part.header)),
                [list(map(translated, row)) for row in part.rows],
                translated(part.note),
            )
        case Chart():
            return _chart(part)
        case Picture():
            return replace(part, caption=translated(part.caption), alt=translated(part.alt))
        case Row():
            return replace(part, parts=[_part(one) for one in part.parts])


def _chart(chart: Chart) -> Chart:
    return replace(
        chart,
        title=translated(chart.title),
        places=list(map(translated, chart.places)),
        unit=translated(chart.unit),
        series=[replace(one, name=translated(one.name)) for one in chart.series],
        along=translated(chart.along),
        caption=translated(chart.caption),
    )
