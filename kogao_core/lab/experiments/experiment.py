"""Declaration of an experiment; its command and its window follow from this."""

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

    subjects: Iterable[Subject]  # read and searched one after another
    recipe: Recipe  # settings of the warp
    source: Callable[[], LandmarkSource]  # returns the landmark source, made at the first call
    new_source: Callable[[], LandmarkSource]  # makes another, its networks yet to be loaded
    given: Mapping[str, Any]  # by the names of the experiment's options, with _ for -
    progress: Progress
    leave_out: Callable[[str], None]  # takes a sentence: why a photo or a method is left out
    # Takes pictures, grey or RGB, by the names of their files; a window keeps none.
    keep: Callable[[Iterable[tuple[str, Image]]], None]


@dataclass(frozen=True, slots=True)
class ExperimentOption:
    """An option of an experiment: a number, a name, or files."""

    name: str  # as the command spells it behind its dashes
    default: int | str = ""  # a number or a name; of files there are none
    least: int = 1  # of a number
    names: tuple[str, ...] = ()  # among which a name is
    # Reads a file. A window takes the one called after the option among the editor's data.
    read: Callable[[Path], Iterable[Any]] | None = None
    in_window: int | None = None  # the number that a window takes, where it is another
    help: Text | None = None

    @property
    def key(self) -> str:
        """Key of the option in `Work.given`."""
        return self.name.replace("-", "_")


@dataclass(frozen=True, slots=True)
class Experiment:
    """An experiment, as the table `EXPERIMENTS` lists it."""

    name: str  # of its command, its files and its section in ``docs/experiments.md``
    # Menu text with the letter for Alt, and tip.
    entry: Text
    tip: Text
    title: Text  # of its window
    help: Text  # of its command
    run: Callable[[Work], Report]
    options: tuple[ExperimentOption, ...] = ()
    takes_percent: bool = True  # whether its command has ``--percent``
