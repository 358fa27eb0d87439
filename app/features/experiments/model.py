"""The paper's experiments on the photo that is open; each is one call, off the GUI thread."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from kogao_core.experiments.subjects import Subject
from kogao_core.face import LandmarkSource
from kogao_core.geometry import Image
from kogao_core.recipe import Recipe

from ...i18n import tr

if TYPE_CHECKING:
    from kogao_core.experiments.report import Table

ExperimentName = Literal["timing", "domains", "distortion", "methods"]


@dataclass(frozen=True, eq=False)
class ExperimentTask:
    """What an experiment works on.

    Parameters
    ----------
    subject : Subject
        The photo and the faces that are on.
    recipe : Recipe
        The photo's choices.
    source : callable
        Makes what finds the faces, for automatic setting; called off the GUI thread.
    sessions : Path
        Setting times of manual work on this machine.
    """

    subject: Subject
    recipe: Recipe
    source: Callable[[], LandmarkSource]
    sessions: Path


@dataclass(frozen=True, eq=False)
class Findings:
    """What an experiment found.

    Parameters
    ----------
    name : str
        Which one.
    lead : str
        What it asks, in a sentence.
    tables : list of Table
        Its figures.
    pictures : dict of str to list of (str, array)
        By kind: captions and RGB pictures of one size, to look at in one place.
    left_out : list of str
        What couldn't be measured, and why.
    texts : dict of str to str
        The report by kind of file: html, json and csv.
    """

    name: ExperimentName
    lead: str
    tables: list[Table]
    pictures: dict[str, list[tuple[str, Image]]] = field(default_factory=dict)
    left_out: list[str] = field(default_factory=list)
    texts: dict[str, str] = field(default_factory=dict)


def title(name: ExperimentName) -> str:
    """Return what an experiment is called."""
    return {
        "timing": tr("Setting and computing time (table 2)"),
        "domains": tr("Reduced domains (figures 14 and 15)"),
        "distortion": tr("Distortion beside table 1"),
        "methods": tr("Methods side by side"),
    }[name]
