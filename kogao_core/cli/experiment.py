"""``kogao-cli experiment``: the paper's tables and figures, one command each."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from kogao_core.cli import common, figures, options, reports, study, words
from kogao_core.language import Text

if TYPE_CHECKING:
    from kogao_core.experiments.setting_times import SettingTime


@words.group("experiment")
def command() -> None:
    """Repeat the paper's tables and figures on your own photos."""


@command.command("timing")
@reports.takes_photos
@options.chooses_percent
@words.option(
    "--size", type=click.Choice(["own", "960x720", "both"]), default="both", show_default=True,
    help="The photo's own size, or the paper's (cut to its shape and scaled).",
)  # fmt: skip
@words.option("--repeats", type=click.IntRange(1), default=10, show_default=True)
@words.option("--warm-up", type=click.IntRange(0), default=2, show_default=True)
@words.option(
    "--setting-time", "setting_times_file", type=click.Path(path_type=Path), metavar="FILE",
    help="Sessions of setting by hand that the editor recorded (JSON lines).",
)  # fmt: skip
def timing_command(
    size: str, repeats: int, warm_up: int, setting_times_file: Path | None, **given: Any
) -> int:
    """Table 2: setting and computing time by hand and found, whole and reduced."""
    from kogao_core.experiments import timing, timing_report

    work = reports.Work("timing", given)
    setting_times = _setting_times(setting_times_file)
    sizes = timing.SIZES if size == "both" else [one for one in timing.SIZES if one == size]
    timings: list[timing.Timing] = []
    for subject in work.subjects():
        found, missing = timing.measure(
            subject, work.source, work.recipe, sizes=sizes, repeats=repeats, warm_up=warm_up,
            progress=work.progress.step,
        )  # fmt: skip
        timings += found
        for sentence in missing:
            work.leave_out(sentence)
    result = timing.TimingResult(
        tuple(timings), tuple(setting_times), work.recipe, repeats, warm_up
    )
    return work.deliver(timing_report.report(result))


def _setting_times(file: Path | None) -> list[SettingTime]:
    from kogao_core.experiments.setting_times import read
    from kogao_core.strict import BadFile

    with (
        common.refusing(
            lambda reason: Text("{file} can't be read ({reason})", file=file, reason=reason)
        ),
        common.stopping(BadFile, common.USAGE),
    ):
        return [] if file is None else read(file)


@command.command("domains")
@reports.takes_photos
@options.chooses_percent
@words.option("--repeats", type=click.IntRange(1), default=5, show_default=True)
def domains_command(repeats: int, **given: Any) -> int:
    """Figures 14 and 15: pixels of the domains, and the error of each threshold."""
    from kogao_core.experiments import domains, domains_report

    work = reports.Work("domains", given)
    photos = []
    for subject in work.subjects():
        found = domains.measure(subject, work.recipe, repeats=repeats, progress=work.progress.step)
        work.outputs.keep(domains_report.pictures(subject.stem, found.masks))
        photos.append(found.without_masks())
    result = domains.DomainsResult(tuple(photos), work.recipe)
    return work.deliver(domains_report.report(result))


@command.command("distortion")
@reports.takes_photos
def distortion_command(**given: Any) -> int:
    """Table 1 and figure 11 beside numbers: area, folds, bent lines, missed targets."""
    from kogao_core.experiments import distortion, distortion_report

    work = reports.Work("distortion", given)
    found: list[distortion.Distortion] = []
    for subject in work.subjects():
        found += distortion.measure(subject, work.recipe, progress=work.progress.step)
    result = distortion.DistortionResult(tuple(found), work.recipe)
    return work.deliver(distortion_report.report(result))


@command.command("methods")
@reports.takes_photos
@options.chooses_percent
@words.option("--repeats", type=click.IntRange(1), default=3, show_default=True)
def methods_command(repeats: int, **given: Any) -> int:
    """B-splines beside other warps: speed, exactness, folds, domain, pictures."""
    from kogao_core.experiments.methods import comparing, methods_report

    work = reports.Work("methods", given)
    for sentence in comparing.missing():
        work.name_absent(sentence)
    photos = []
    for subject in work.subjects():
        comparison, failed = comparing.measure(
            subject, work.recipe, repeats=repeats, progress=work.progress.step
        )
        for sentence in failed:
            work.leave_out(sentence)
        work.outputs.keep(methods_report.pictures(comparison))
        photos.append(comparison.views())
    result = comparing.MethodsResult(tuple(photos), work.recipe, repeats)
    return work.deliver(methods_report.report(result))


command.add_command(figures.command)
command.add_command(study.command)
