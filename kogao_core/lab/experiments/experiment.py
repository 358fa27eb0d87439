"""What an experiment is: a declaration, from which its command and its window follow."""

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
from kogao_core.recipe.recipe import PAPER, Recipe


@dataclass(frozen=True, eq=False)
class Work:
    """What an experiment works on, and whom it tells of it: the command line or a window."""

    subjects: Iterable[Subject]  # read and searched one after another
    recipe: Recipe  # what happens to the faces
    source: Callable[[], LandmarkSource]  # what finds the faces, made when it is first asked for
    new_source: Callable[[], LandmarkSource]  # makes another, its networks yet to be loaded
    given: Mapping[str, Any]  # by the names of the experiment's options, with _ for -
    progress: Progress
    # Takes a sentence: why something of a photo can't be used, or what isn't installed.
    leave_out: Callable[[str], None]
    name_absent: Callable[[str], None]
    # Takes pictures, grey or RGB, by the names of their files; a window keeps none.
    keep: Callable[[Iterable[tuple[str, Image]]], None]


@dataclass(frozen=True, slots=True)
class ExperimentOption:
    """What an experiment takes besides photos and a recipe: a number, a name, or files."""

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
        """What it is called in `Work.given`."""
        return self.name.replace("-", "_")


@dataclass(frozen=True, slots=True)
class Experiment:
    """An experiment, as the table `EXPERIMENTS` lists it."""

    name: str  # of its command, its files and its section in ``docs/experiments.md``
    # What the menu calls it, with the letter that leads to it, and tells of it.
    entry: Text
    tip: Text
    title: Text  # of its window
    help: Text  # of its command
    run: Callable[[Work], Report]
    options: tuple[ExperimentOption, ...] = ()
    takes_percent: bool = True  # whether its command has ``--percent``
    recipe: Recipe = PAPER  # where none is given
