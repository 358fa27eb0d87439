"""All figures and tables of the paper in one report and one folder."""

import numpy as np
import pytest
from scenes import oval_face, textured_photo

from kogao_core.lab.experiments import distortion, domains, paper
from kogao_core.lab.experiments.experiment import Work
from kogao_core.lab.reports.report import Heading, Picture, Row
from kogao_core.lab.subjects import Subject, no_progress
from kogao_core.recipe.recipe import PAPER


@pytest.fixture
def subject():
    return Subject("a.png", textured_photo(960, 720), (oval_face(960, 720),))


def test_figures_show_points_targets_lattice_distances_and_lattice_sizes(subject):
    made = {name: pictures for name, _, pictures in paper._figures(subject, PAPER)}
    assert [len(made[name]) for name in ("points", "distance", "lattice-size")] == [3, 5, 4]
    for pictures in made.values():
        assert len({pixels.tobytes() for _, pixels, _ in pictures}) == len(pictures)
    (_, targets, _), center = made["points"][1], oval_face(960, 720).outline.mean(axis=0)
    changed = (targets != subject.pixels).any(axis=2)
    inside = np.hypot(*(np.argwhere(changed)[:, ::-1] - center).T)
    assert inside.max() < np.hypot(*(subject.faces[0].outline - center).T).max() + 6.0


def test_one_report_holds_the_tables_of_the_experiments(subject, monkeypatch):
    monkeypatch.setattr(paper, "_PARTS", (domains.EXPERIMENT, distortion.EXPERIMENT))
    kept = {}
    work = Work(
        iter([subject]), PAPER, lambda: None, {}, no_progress, pytest.fail, lambda f: kept.update(f)
    )
    report = paper.EXPERIMENT.run(work)
    headings = [part.text for part in report.parts if isinstance(part, Heading)]
    assert sum("a.png" in str(one) for one in headings) >= 3
    assert len(report.tables) >= 4
    assert isinstance(report.parts[1], Row)
    assert all(isinstance(one, Picture) for one in report.parts[1].parts)
    assert {"domains.csv", "distortion.csv", "a-png-threshold.png"} <= kept.keys()
    assert kept["domains.csv"].count("\n") > 2
    assert report.csv()
    assert report.document.keys() == {"domains", "distortion"}
