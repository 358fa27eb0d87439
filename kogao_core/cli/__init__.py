"""``kogao-cli``: the same rendering as the editor, without Qt.

It may use all rooms; of the laboratory it knows the name of one module.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence

from kogao_core.base import interrupts


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the program and exit; `arguments` default to the process's own."""
    is_program = arguments is None
    if is_program:
        interrupts.end_when_told("kogao-cli")
    # All else takes its time to load, and may be interrupted meanwhile.
    from kogao_core.cli.commands import run

    code = run(arguments)
    if is_program:
        interrupts.let_be()
    sys.exit(code)
