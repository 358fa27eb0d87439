"""Table 2: time of manual and automatic work, on the whole image and on the reduced domain."""

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
from kogao_core.faces.face import Face, LandmarkSource
from kogao_core.faces.targets import matching
from kogao_core.field.fade import threshold_of
from kogao_core.field.field import Field
from kogao_core.lab.experiments.trials import Trial
from kogao_core.lab.reports.spread import Spread, in_turns, processor_ms
from kogao_core.lab.subjects import Progress, Subject, at_paper_size, no_progress, set_by_hand
from kogao_core.paper.domain import pixel_counts
from kogao_core.pipeline import render
from kogao_core.recipe.recipe import Recipe
from kogao_core.recipe.settings import DomainName

Size = Literal["960x720", "own"]
SIZES: Final[tuple[Size, ...]] = ("960x720", "own")


@dataclass(frozen=True, slots=True)
class Procedure:
    """A row of table 2."""

    name: str
    title: str
    automatic: bool
    domain: DomainName
    computing_s: float  # printed in the paper, computer of 2011


PROCEDURES: Final = (
    Procedure("conventional", Text("Conventional method"), False, "image", 5.896),
    Procedure("wdr", Text("Warping domain reduction (Wdr)"), False, "threshold", 3.576),
    Procedure("akt", Text("Automatic transformation (Akt)"), True, "image", 6.102),
    Procedure("dual", Text("Dual method (Wdr + Akt)"), True, "threshold", 3.722),
)
# The first row's computation again: the difference to the first row is the noise of the
# measurement.
AGAIN: Final = dataclasses.replace(
    PROCEDURES[0], name="again", title=Text("Conventional method, again")
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Timing:
    """The runs of one procedure on one photo at one size."""

    photo: str  # name
    size: Size
    # Size of the photo, px.
    width: int
    height: int
    faces: int
    procedure: str  # name of a row of `PROCEDURES`, or of `AGAIN`
    domain_share: float  # processed share of the image, 0 to 1
    # Time of the face search in each run; empty for manual procedures.
    setting_ms: tuple[float, ...]
    stages_ms: dict[str, tuple[float, ...]]  # computing time by stage of `render`
    processor_ms: tuple[float, ...]  # processor time of all threads

    @property
    def computing_ms(self) -> tuple[float, ...]:
        """Sum of the stages of each run."""
        return tuple(map(sum, zip(*self.stages_ms.values(), strict=True)))


@dataclass(frozen=True, slots=True)
class TimingResult:
    """Results for table 2 on some photos."""

    timings: tuple[Timing, ...]  # all measurements
    trials: tuple[Trial, ...]  # recorded trials; may be empty
    recipe: Recipe  # settings; the procedure sets the domain
    # Number of counted rounds, and of warm-up rounds.
    repeats: int
    warm_up: int

    def trials_of(self, mode: str) -> list[Trial]:
        return [one for one in self.trials if one.mode == mode]

    @property
    def setting(self) -> Spread | None:
        """Manual setting time with corrections, s; None without trials."""
        times = [one.total_s for one in self.trials_of("manual")]
        return Spread.of(times) if times else None

    def of(self, size: Size, procedure: str) -> list[Timing]:
        return [one for one in self.timings if (one.size, one.procedure) == (size, procedure)]


def with_trial(subject: Subject, trials: Sequence[Trial]) -> Subject:
    """Return the subject with the landmarks of the last manual trial, if any."""
    mine = [
        one
        for one in trials
        if (one.mode, one.photo, one.width, one.height) == ("manual", subject.name, *subject.size)
        and len(one.faces) == len(subject.faces)
    ]
    return dataclasses.replace(subject, by_hand=mine[-1].faces) if mine else subject


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

    Manual procedures use `Subject.by_hand`, or the subject's faces with all targets set; trials
    have the setting times. Automatic procedures search the photo in every run and warp the same
    faces. Return the timings, and a sentence for each problem.
    """
    timings: list[Timing] = []
    notes: list[str] = []
    at_size = {"own": subject, "960x720": at_paper_size(subject)}
    runs = len(sizes) * (len(PROCEDURES) + 1) * (repeats + warm_up)
    for number, size in enumerate(sizes):
        here = at_size[size]
        procedures: tuple[Procedure, ...] = PROCEDURES
        if len(_again(here.faces, source.find(here.pixels))) < len(here.faces):
            notes.append(
                Text(
                    "{name} at {size}: not all faces were found again; automatic procedures are "
                    "skipped",
                    name=subject.name,
                    size=size,
                )
            )
            procedures = tuple(procedure for procedure in PROCEDURES if not procedure.automatic)
        procedures = (*procedures, AGAIN)
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
        self.by_hand = subject.by_hand or set_by_hand(subject.faces, recipe)
        # By procedure, for each counted run: setting time, stages and processor time, ms.
        self.runs: defaultdict[str, list[tuple[float, dict[str, float], float]]] = defaultdict(list)
        self.fields: dict[str, Field] = {}

    def run(self, procedure: Procedure, counts: bool) -> None:
        faces, setting_ms = self._faces(procedure)
        recipe = dataclasses.replace(self.recipe, domain=procedure.domain)
        rendering, took_ms = processor_ms(lambda: render(self.subject.pixels, faces, recipe))
        if counts:
            self.fields[procedure.name] = rendering.field
            self.runs[procedure.name].append((setting_ms, rendering.timings_ms, took_ms))

    def _faces(self, procedure: Procedure) -> tuple[Sequence[Face], float]:
        if not procedure.automatic:
            return self.by_hand, 0.0
        start = time.perf_counter()
        found = self.source.find(self.subject.pixels)
        setting_ms = (time.perf_counter() - start) * 1e3
        return _again(self.subject.faces, found), setting_ms

    def timing(self, size: Size, procedure: Procedure) -> Timing:
        field = self.fields[procedure.name]
        setting_ms, laps, took_ms = zip(*self.runs[procedure.name], strict=True)
        image = Box.of(self.subject.pixels)
        recipe = dataclasses.replace(self.recipe, domain=procedure.domain)
        counts = pixel_counts(field.lattices, image, threshold_of(recipe, field))
        return Timing(
            photo=self.subject.name,
            size=size,
            width=self.subject.size[0],
            height=self.subject.size[1],
            faces=len(field.lattices),
            procedure=procedure.name,
            domain_share=counts[procedure.domain] / counts["image"],
            setting_ms=setting_ms if procedure.automatic else (),
            stages_ms={stage: tuple(lap[stage] for lap in laps) for stage in laps[0]},
            processor_ms=took_ms,
        )


def _again(faces: Sequence[Face], found: Sequence[Face]) -> list[Face]:
    """Return the found faces that match `faces`, closer than the eye distance."""
    near: dict[int, Face] = {}
    for face in faces:
        place = matching(face, found)
        if place is None:
            continue
        apart_px = math.dist(face.anchor.origin_px, found[place].anchor.origin_px)
        if apart_px < face.interocular_px:
            near[place] = found[place]
    return list(near.values())
