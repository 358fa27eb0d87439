"""Declaration of an experiment: the source of command, menu entry and window."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from kogao_core.base.geometry import Image
from kogao_core.base.language import Text
from kogao_core.faces.face import LandmarkSource
from kogao_core.lab.reports.report import Report
from kogao_core.lab.subjects import Progress, Subject
from kogao_core.recipe.recipe import Recipe


@dataclass(frozen=True, eq=False)
class Work:
    """Input of an experiment, and callbacks of the command line or the window."""

    subjects: Iterable[Subject]  # read and searched lazily
    recipe: Recipe  # settings of the warp
    source: Callable[[], LandmarkSource]  # returns the landmark source, made at the first call
    given: Mapping[str, Any]  # values of the options, by key
    progress: Progress
    leave_out: Callable[[str], None]  # called with the reason for a skipped photo or method
    # Called with pictures, grey or RGB, and texts by file name; ignored in the window.
    keep: Callable[[Iterable[tuple[str, Image | str]]], None]


@dataclass(frozen=True, slots=True)
class ExperimentOption:
    """An option of an experiment: a number, a name, or files."""

    name: str  # name on the command line, without dashes
    default: int | str = ""  # a number or a name; not used for files
    least: int = 1  # minimum of a number
    names: tuple[str, ...] = ()  # allowed names
    # Reads a file. The window reads the file NAME.jsonl in the editor's data folder.
    read: Callable[[Path], Iterable[Any]] | None = None
    in_window: int | None = None  # default in the window, if different
    help: Text | None = None

    @property
    def key(self) -> str:
        """The option's name in `Work.given`: dashes become underscores."""
        return self.name.replace("-", "_")


@dataclass(frozen=True, slots=True)
class Experiment:
    """An experiment, an entry of `EXPERIMENTS`."""

    name: str  # name of the command, of files, and of the section in docs/experiments.md
    entry: Text  # menu text with mnemonic
    title: Text  # title of the window
    help: Text  # help of the command, and tooltip
    run: Callable[[Work], Report]
    options: tuple[ExperimentOption, ...] = ()
    takes_percent: bool = True  # whether the command has the option ``--amount``
