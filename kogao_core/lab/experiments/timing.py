"""Table 2: what manual and automatic work cost, on the whole image and on the reduced domain."""

from __future__ import annotations

import dataclasses
import math
import time
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal

from kogao_core.base.geometry import Box
from kogao_core.base.language import Text
from kogao_core.faces.differences import matching
from kogao_core.faces.face import Face, LandmarkSource
from kogao_core.lab.experiments.setting_times import SettingTime
from kogao_core.lab.reports.spread import Spread, in_turns
from kogao_core.lab.subjects import (
    Progress,
    Subject,
    at_paper_size,
    no_progress,
    set_by_hand,
)
from kogao_core.pipeline import render
from kogao_core.recipe.recipe import Recipe
from kogao_core.recipe.settings import DomainName
from kogao_core.warp.counts import pixel_counts
from kogao_core.warp.domain import threshold_of
from kogao_core.warp.field import Field

Size = Literal["960x720", "own"]
SIZES: Final[tuple[Size, ...]] = ("960x720", "own")


@dataclass(frozen=True, slots=True)
class Procedure:
    """A row of table 2 with the paper's times, s; automatic setting took it "less than 1"."""

    name: str
    title: str
    automatic: bool
    domain: DomainName
    setting_s: float
    computing_s: float

    @property
    def total_s(self) -> float:
        """The paper's total, s; it counts automatic setting as a whole second."""
        return self.setting_s + self.computing_s


PROCEDURES: Final = (
    Procedure("conventional", Text("Conventional method"), False, "image", 20.0, 5.896),
    Procedure("wdr", Text("Warping domain reduction (Wdr)"), False, "threshold", 20.0, 3.576),
    Procedure("akt", Text("Automatic transformation (Akt)"), True, "image", 1.0, 6.102),
    Procedure("dual", Text("Dual method (Wdr + Akt)"), True, "threshold", 1.0, 3.722),
)


@dataclass(frozen=True, slots=True)
class Timing:
    """The runs of one procedure on one photo at one size."""

    photo: str  # its name
    size: Size  # which size
    # What was worked on, px.
    width: int
    height: int
    faces: int
    procedure: str  # name of a row of `PROCEDURES`
    domain_share: float  # part of the image that was worked on, 0 to 1, by section 4's counts
    # Time to find faces and landmarks in each run; empty where people do that.
    setting_ms: tuple[float, ...]
    stages_ms: dict[str, tuple[float, ...]]  # computing time by stage of `pipeline.render`

    @property
    def computing_ms(self) -> tuple[float, ...]:
        """All stages together, of each run."""
        return tuple(map(sum, zip(*self.stages_ms.values(), strict=True)))


@dataclass(frozen=True, slots=True)
class TimingResult:
    """Table 2 on some photos."""

    timings: tuple[Timing, ...]  # what was measured
    setting_times: tuple[SettingTime, ...]  # setting by hand, as recorded; may be empty
    recipe: Recipe  # what was done to the faces; its domain is set by the procedure
    # Rounds that count, and rounds before them.
    repeats: int
    warm_up: int

    @property
    def setting(self) -> Spread | None:
        """Setting time by hand, s; None while no session was recorded."""
        times = [one.setting_s for one in self.setting_times]
        return Spread.of(times) if times else None

    def of(self, size: Size, procedure: str) -> list[Timing]:
        """Return the timings of one procedure at one size."""
        return [one for one in self.timings if (one.size, one.procedure) == (size, procedure)]


def measure(
    subject: Subject,
    source: LandmarkSource,
    recipe: Recipe,
    *,
    sizes: Sequence[Size] = SIZES,
    repeats: int = 10,
    warm_up: int = 2,
    progress: Progress = no_progress,
) -> tuple[list[Timing], list[str]]:
    """Time all four procedures on one photo, in turns.

    Manual procedures get the subject's faces with all targets set; how long people take for that is
    their setting clock's to say. Automatic procedures search the photo anew in every run, and of
    what they find warp the same faces. Result: and what couldn't be measured, in a sentence each.
    """
    timings: list[Timing] = []
    notes: list[str] = []
    at_size = {"own": subject, "960x720": at_paper_size(subject)}
    runs = len(sizes) * len(PROCEDURES) * (repeats + warm_up)
    for number, size in enumerate(sizes):
        here = at_size[size]
        procedures: tuple[Procedure, ...] = PROCEDURES
        if len(_again(here.faces, source.find(here.pixels))) < len(here.faces):
            notes.append(
                Text(
                    "{name} at {size}: not every face was found again, so nothing is automatic",
                    name=subject.name,
                    size=size,
                )
            )
            procedures = tuple(procedure for procedure in PROCEDURES if not procedure.automatic)
        timer = _Timer(here, source, recipe)
        names = {procedure.name: procedure for procedure in procedures}
        for done, (name, counts) in enumerate(in_turns(list(names), repeats, warm_up)):
            timer.run(names[name], counts)
            progress(number * runs // len(sizes) + done + 1, runs)
        timings += [timer.timing(size, procedure) for procedure in procedures]
    return timings, notes


class _Timer:
    def __init__(self, subject: Subject, source: LandmarkSource, recipe: Recipe) -> None:
        self.subject, self.source, self.recipe = subject, source, recipe
        self.by_hand = set_by_hand(subject.faces, recipe)
        self.setting_ms: defaultdict[str, list[float]] = defaultdict(list)
        self.laps_ms: defaultdict[str, list[dict[str, float]]] = defaultdict(list)
        self.fields: dict[str, Field] = {}

    def run(self, procedure: Procedure, counts: bool) -> None:
        faces, setting_ms = self._faces(procedure)
        recipe = dataclasses.replace(self.recipe, domain=procedure.domain)
        rendering = render(self.subject.pixels, faces, recipe)
        if not counts:
            return
        self.fields[procedure.name] = rendering.field
        self.laps_ms[procedure.name].append(rendering.timings_ms)
        if procedure.automatic:
            self.setting_ms[procedure.name].append(setting_ms)

    def _faces(self, procedure: Procedure) -> tuple[Sequence[Face], float]:
        if not procedure.automatic:
            return self.by_hand, 0.0
        start = time.perf_counter()
        found = self.source.find(self.subject.pixels)
        setting_ms = (time.perf_counter() - start) * 1e3
        return _again(self.subject.faces, found), setting_ms

    def timing(self, size: Size, procedure: Procedure) -> Timing:
        field, laps = self.fields[procedure.name], self.laps_ms[procedure.name]
        image = Box.of(self.subject.pixels)
        recipe = dataclasses.replace(self.recipe, domain=procedure.domain)
        counts = pixel_counts(field, image, threshold_of(recipe, field))
        return Timing(
            self.subject.name, size, *self.subject.size, len(field.lattices), procedure.name,
            counts[procedure.domain] / counts["image"],
            tuple(self.setting_ms[procedure.name]),
            {stage: tuple(lap[stage] for lap in laps) for stage in laps[0]},
        )  # fmt: skip


def _again(faces: Sequence[Face], found: Sequence[Face]) -> list[Face]:
    """Return those of the faces found that are `faces`; `matching` alone takes neighbours, too."""
    near: dict[int, Face] = {}
    for face in faces:
        place = matching(face, found)
        if place is None:
            continue
        apart_px = math.dist(face.anchor.origin_px, found[place].anchor.origin_px)
        if apart_px < face.interocular_px:
            near[place] = found[place]
    return list(near.values())
