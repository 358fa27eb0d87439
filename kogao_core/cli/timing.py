"""``kogao-cli experiment timing``: table 2."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from kogao_core.cli import common, reports

if TYPE_CHECKING:
    from kogao_core.experiments.sessions import Session


@click.command("timing")
@reports.takes_photos
@click.option(
    "--size", type=click.Choice(["own", "960x720", "both"]), default="both", show_default=True,
    help="The photo's own size, or the paper's (cut to its shape and scaled).",
)  # fmt: skip
@click.option("--repeats", type=click.IntRange(1), default=10, show_default=True)
@click.option("--warm-up", type=click.IntRange(0), default=2, show_default=True)
@click.option(
    "--setting-time", "sessions_file", type=click.Path(path_type=Path), metavar="FILE",
    help="Sessions of setting by hand that the editor recorded (JSON lines).",
)  # fmt: skip
def command(size: str, repeats: int, warm_up: int, sessions_file: Path | None, **given: Any) -> int:
    """Table 2: setting and computing time by hand and found, whole and reduced."""
    from kogao_core.experiments import timing, timing_report

    work = reports.Work("timing", given)
    sessions = _sessions(sessions_file)
    sizes = timing.SIZES if size == "both" else [one for one in timing.SIZES if one == size]
    timings: list[timing.Timing] = []
    source = work.source()
    for subject in work.subjects(source):
        found, missing = timing.measure(
            subject, source, work.recipe, sizes=sizes, repeats=repeats, warm_up=warm_up
        )
        timings += found
        for sentence in missing:
            work.leave_out(sentence)
    result = timing.Result(tuple(timings), tuple(sessions), work.recipe, repeats, warm_up)
    return work.deliver(result, timing_report)


def _sessions(file: Path | None) -> list[Session]:
    from kogao_core.experiments.sessions import read
    from kogao_core.strict import BadFile

    if file is None:
        return []
    try:
        return read(file)
    except BadFile as error:
        raise common.Stop(error, common.USAGE) from error
    except OSError as error:
        raise common.Stop(f"{file} can't be read ({error.strerror})", common.UNREADABLE) from error
