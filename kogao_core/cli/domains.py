"""``kogao-cli experiment domains``: figures 14 and 15."""

from __future__ import annotations

from typing import Any

import click

from kogao_core.cli import reports


@click.command("domains")
@reports.takes_photos
@click.option("--repeats", type=click.IntRange(1), default=5, show_default=True)
def command(repeats: int, **given: Any) -> int:
    """Figures 14 and 15: pixels of the domains, and the error of each threshold."""
    from kogao_core.experiments import domains, domains_report

    work = reports.Work("domains", given)
    photos = []
    for subject in work.subjects(work.source()):
        found = domains.measure(subject, work.recipe, repeats=repeats)
        work.keep(domains_report.pictures(subject.stem, found.masks))
        photos.append(found.without_masks())
    return work.deliver(domains.Result(tuple(photos), work.recipe), domains_report)
