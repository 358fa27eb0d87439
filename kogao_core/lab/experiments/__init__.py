"""The experiments: each module declares one."""

from __future__ import annotations

from typing import Final

from kogao_core.lab.experiments import distortion, domains, methods_report, timing_report
from kogao_core.lab.experiments.experiment import Experiment

# In the order of the editor's menu.
EXPERIMENTS: Final[tuple[Experiment, ...]] = (
    timing_report.EXPERIMENT,
    domains.EXPERIMENT,
    distortion.EXPERIMENT,
    methods_report.EXPERIMENT,
)
