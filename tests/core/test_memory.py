"""Memory that was freed is used again by programs that end."""

import subprocess
import sys
import textwrap

import pytest

PROGRAM = """
    import resource, sys
    from kogao_core.base.memory import keep_freed
    if not keep_freed():
        sys.exit("this C library can't be told")
    faults = lambda: resource.getrusage(resource.RUSAGE_SELF).ru_minflt
    for _ in range(2):
        before = faults()
        block = b"1" * (40 << 20)
        found = faults() - before
        del block
    print(found)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="only glibc can be told")
def test_a_block_that_was_freed_costs_no_page_faults_the_second_time():
    command = [sys.executable, "-c", textwrap.dedent(PROGRAM)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        pytest.skip(done.stderr)
    assert int(done.stdout) < 100  # of 10,240 pages
