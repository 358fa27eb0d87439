"""A report in the user's language: what people read of it; its data stay as they are."""

from __future__ import annotations

from dataclasses import fields, is_dataclass, replace
from typing import Any

from kogao_core.base.language import translated
from kogao_core.lab.reports.report import Report


def translated_report(report: Report) -> Report:
    """Return a report whose texts are said in the language at work.

    Result: with the same records and document.
    """
    title, lead, parts = map(_said, (report.title, report.lead, report.parts))
    return replace(report, title=title, lead=lead, parts=parts)


def _said(part: Any) -> Any:
    """Translate a text, the texts of a list, or those of a part of a report and of its parts."""
    if isinstance(part, str):
        return translated(part)
    if isinstance(part, list | tuple):
        return [_said(one) for one in part]
    if is_dataclass(part) and not isinstance(part, type):
        return replace(part, **{one.name: _said(getattr(part, one.name)) for one in fields(part)})
    return part
