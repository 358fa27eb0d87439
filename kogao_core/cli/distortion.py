"""``kogao-cli experiment distortion``: table 1's grid, measured instead of asked about."""

from __future__ import annotations

from typing import Any

import click

from kogao_core.cli import common, reports


@click.command("distortion")
@reports.takes_photos
def command(**given: Any) -> int:
    """Table 1 and figure 11 beside numbers: area, folds, bent lines, missed targets."""
    from kogao_core.experiments import distortion, distortion_report

    if given["percent"] is not None:
        raise common.Stop("it tries every distance of table 1; leave --percent out", common.USAGE)
    work = reports.Work("distortion", given)
    found: list[distortion.Distortion] = []
    for subject in work.subjects(work.source()):
        found += distortion.measure(subject, work.recipe)
    return work.deliver(distortion.Result(tuple(found), work.recipe), distortion_report)
