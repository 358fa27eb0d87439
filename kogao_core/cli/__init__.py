"""``kogao-cli``: the same rendering as the editor, without Qt.

It may import all packages. Only ``declarations`` names a module of the laboratory.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence

from kogao_core.base import interrupts


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the program and exit. `arguments` default to ``sys.argv[1:]``."""
    is_program = arguments is None
    if is_program:
        interrupts.exit_on_signals("kogao-cli")
    # Slow imports come last, so that a signal can interrupt them.
    from kogao_core.cli.commands import run

    code = run(arguments)
    if is_program:
        interrupts.ignore_signals()
    sys.exit(code)
