"""``kogao-cli experiment``: the paper's tables and figures, one command each."""

from __future__ import annotations

import click

from kogao_core.cli import distortion, domains, figures, methods, study, timing

MODULES = (timing, domains, distortion, methods, figures, study)


@click.group("experiment")
def command() -> None:
    """Repeat the paper's tables and figures on your own photos."""


for module in MODULES:
    command.add_command(module.command)
