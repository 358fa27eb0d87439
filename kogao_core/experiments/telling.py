"""What an experiment found, as the texts of files: all figures, a table of them, a report."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable, Mapping
from typing import Any, Protocol

from kogao_core.experiments.report import Made, Table


class Telling(Protocol):
    """A module that tells what an experiment found: to read, to compute with, to look at."""

    @property
    def tables(self) -> Callable[[Any], list[Table]]: ...  # noqa: D102
    @property
    def records(self) -> Callable[[Any], list[dict[str, object]]]: ...  # noqa: D102
    @property
    def document(self) -> Callable[[Any], dict[str, object]]: ...  # noqa: D102
    @property
    def html(self) -> Callable[[Any, Made], str]: ...  # noqa: D102


def texts(result: object, telling: Telling, made: Made) -> Mapping[str, Callable[[], str]]:
    """Return what makes the text of each kind of file.

    Parameters
    ----------
    result : object
        What `telling` tells of.
    telling : Telling
        The module that does.
    made : Made
        How the result came to be.
    """
    return {
        "json": lambda: _json({**telling.document(result), "made": made.to_dict()}),
        "csv": lambda: _csv(telling.records(result)),
        "html": lambda: telling.html(result, made),
    }


def _json(document: Mapping[str, object]) -> str:
    return json.dumps(document, indent=1, allow_nan=False) + "\n"


def _csv(records: list[dict[str, object]]) -> str:
    text = io.StringIO()
    writer = csv.DictWriter(text, list(records[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(records)
    return text.getvalue()
