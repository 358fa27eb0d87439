"""Programs in a Python of their own."""

import subprocess
import sys
import textwrap

from timeouts import LONGEST_S


def ran(text, *words, ends=0, flags=(), **options):
    """Run the text of a program with arguments; return it once it has ended with a code."""
    command = [sys.executable, "-X", "utf8", *flags, "-c", textwrap.dedent(text), *map(str, words)]
    limits = {"capture_output": True, "text": True, "timeout": 4 * LONGEST_S}
    done = subprocess.run(command, **limits, **options)
    assert done.returncode == ends, done.stderr
    return done
