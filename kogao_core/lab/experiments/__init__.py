"""The paper's experiments and those beside them, each a module with one declaration."""

from __future__ import annotations

from typing import Final

from kogao_core.lab.experiments import distortion, domains, lens, methods_report, timing_report
from kogao_core.lab.experiments.experiment import Experiment

# In the order of the editor's menu.
EXPERIMENTS: Final[tuple[Experiment, ...]] = (
    timing_report.EXPERIMENT,
    domains.EXPERIMENT,
    distortion.EXPERIMENT,
    methods_report.EXPERIMENT,
    lens.EXPERIMENT,
)
