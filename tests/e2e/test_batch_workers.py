"""Workers don't outlive the program they work for."""

import os
import signal
import subprocess
import sys
import time

import pytest

# Names its worker's process, and waits to be killed.
PROGRAM = """
import os, time
from kogao_core.batch import Workers
if __name__ == "__main__":
    executor = Workers.processes(1)._make()
    print(executor.submit(os.getpid).result(), flush=True)
    time.sleep(60)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="needs SIGKILL")
def test_an_idle_worker_ends_with_a_killed_program(tmp_path):
    script = tmp_path / "program.py"
    script.write_text(PROGRAM)
    program = subprocess.Popen([sys.executable, str(script)], stdout=subprocess.PIPE, text=True)
    worker = int(program.stdout.readline())
    os.kill(worker, 0)
    program.kill()
    program.wait()
    program.stdout.close()
    deadline = time.monotonic() + 20
    while time.monotonic() < deadline:
        try:
            os.kill(worker, 0)
        except ProcessLookupError:
            return
        time.sleep(0.05)
    os.kill(worker, signal.SIGKILL)
    pytest.fail("the worker waits for a program that is gone")
