"""``kogao-cli experiment methods``: warps side by side on the same points."""

from __future__ import annotations

from typing import Any

import click

from kogao_core.cli import reports


@click.command("methods")
@reports.takes_photos
@click.option("--repeats", type=click.IntRange(1), default=3, show_default=True)
def command(repeats: int, **given: Any) -> int:
    """B-splines beside other warps: speed, exactness, folds, domain, pictures."""
    from kogao_core.experiments.methods import comparing, telling

    work = reports.Work("methods", given)
    for sentence in comparing.missing():
        work.name_absent(sentence)
    photos = []
    for subject in work.subjects(work.source()):
        comparison, failed = comparing.measure(subject, work.recipe, repeats=repeats)
        for sentence in failed:
            work.leave_out(sentence)
        work.keep(telling.pictures(comparison))
        photos.append(comparison.views())
    return work.deliver(comparing.Result(tuple(photos), work.recipe, repeats), telling)
