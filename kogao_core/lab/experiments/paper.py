"""All tables and figures of the paper on one page: the figures drawn here, then the experiments."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from typing import Final

import cv2
import numpy as np

from kogao_core.base.display import rgb8
from kogao_core.base.geometry import Array, Image
from kogao_core.base.language import Text
from kogao_core.faces.targets import aim, center_candidates
from kogao_core.lab.experiments import distortion, domains, timing_report
from kogao_core.lab.experiments.experiment import Experiment, Work
from kogao_core.lab.reports.report import Heading, Part, Picture, Report, Row
from kogao_core.lab.study.design import LATTICES
from kogao_core.lab.subjects import Subject, at_paper_size
from kogao_core.paper.table1 import DISTANCES
from kogao_core.pipeline import render
from kogao_core.recipe.recipe import Recipe

_PARTS: Final = (distortion.EXPERIMENT, timing_report.EXPERIMENT, domains.EXPERIMENT)
_YELLOW, _RED, _BLUE = (255, 220, 0), (255, 60, 60), (60, 160, 255)
_SHIFT: Final = 4  # binary places of the positions that OpenCV draws


def _drawn(
    subject: Subject,
    lines: Sequence[tuple[Array, Array]],
    dots: Sequence[tuple[Array, tuple[int, ...]]],
) -> Image:
    """Return the photo with blue lines between points (N, 2), and dots in their colours."""
    picture = rgb8(subject.pixels).copy()

    def at(point: Array) -> tuple[int, ...]:
        return tuple(np.rint(point * 2**_SHIFT).astype(int).tolist())

    for one, other in (pair for ends in lines for pair in zip(*ends, strict=True)):
        cv2.line(picture, at(one), at(other), _BLUE, 1, cv2.LINE_AA, _SHIFT)
    for points, colour in dots:
        for point in points:
            cv2.circle(picture, at(point), 3 << _SHIFT, colour, -1, cv2.LINE_AA, _SHIFT)
    return picture


def _figures(
    subject: Subject, recipe: Recipe
) -> Iterator[tuple[str, Text, Sequence[tuple[str, Image, Text]]]]:
    """Yield name, heading and pictures (name, pixels, caption) of each figure."""
    face = subject.faces[0]
    pairs, rendering = aim(face, recipe), render(subject.pixels, subject.faces, recipe)
    marks, candidates = (face.outline, _YELLOW), (center_candidates(face), _RED)
    center = np.broadcast_to(pairs.center_px, pairs.target_px.shape)
    lattice = rendering.field.lattices[0]
    (rows, columns), (i, j) = lattice.shape, lattice.first
    x, y = lattice.grid.nodes_px(i, columns, 0), lattice.grid.nodes_px(j, rows, 1)
    across = np.stack([np.full(rows, x[0]), y], 1), np.stack([np.full(rows, x[-1]), y], 1)
    down = np.stack([x, np.full(columns, y[0])], 1), np.stack([x, np.full(columns, y[-1])], 1)
    yield "points", Text("Sections 3.1 to 3.3: landmarks, targets, lattice"), [
        ("landmarks", _drawn(subject, [], [marks, candidates]),
         Text("Landmarks and centre candidates (figure 6)")),
        ("targets", _drawn(subject, [(pairs.source_px, center)], [marks, (pairs.target_px, _RED)]),
         Text("Targets on the lines to the centre (figure 7)")),
        ("lattice", _drawn(subject, [across, down], [marks]),
         Text("Control lattice of R = {r:g} (section 3.3)", r=recipe.lattice)),
    ]  # fmt: skip
    distances = [
        (f"{value:g}", dataclasses.replace(recipe, percent=value), Text("{n:g} %", n=value))
        for value in DISTANCES
    ]
    sizes = [
        (f"{value:g}", dataclasses.replace(recipe, lattice=value), Text("R = {n:g}", n=value))
        for value in LATTICES
    ]
    for name, title, warps in (
        ("distance", Text("Figure 10: warp distances"), distances),
        ("lattice-size", Text("Figure 11: lattice sizes"), sizes),
    ):
        yield (
            name,
            title,
            [
                (value, render(subject.pixels, subject.faces, one).pixels, caption)
                for value, one, caption in warps
            ],
        )


def _run(work: Work) -> Report:
    subjects = [at_paper_size(subject) for subject in work.subjects]
    parts, document = list[Part](), dict[str, object]()
    for subject in subjects:
        for name, title, pictures in _figures(subject, work.recipe):
            work.keep((f"{subject.stem}-{name}-{one}.png", rgb8(made)) for one, made, _ in pictures)
            shown = [Picture(made, caption, caption) for _, made, caption in pictures]
            parts += [
                Heading(Text("{photo}: {title}", photo=subject.name, title=title)),
                Row(shown),
            ]
    for one in _PARTS:
        given: dict[str, object] = {
            option.key: [] if option.read else option.default for option in one.options
        }
        found = one.run(dataclasses.replace(work, subjects=iter(subjects), given=given))
        parts += [Heading(found.title), found.lead, *found.parts]
        work.keep([(f"{one.name}.csv", found.csv())])
        document[one.name] = found.document
    records: list[dict[str, object]] = [
        {"experiment": one.name, "title": str(one.title), "file": f"{one.name}.csv"}
        for one in _PARTS
    ]
    lead = Text("Landmarks, warps, Tables 1 and 2 and domains, at the paper's size.")
    return Report(Text("The paper's figures and tables"), lead, parts, records, document)


EXPERIMENT: Final = Experiment(
    "paper",
    Text("The &paper…"),
    Text("The paper's figures and tables"),
    Text("All figures and tables of the paper in one folder, with one page for a browser."),
    _run,
)
