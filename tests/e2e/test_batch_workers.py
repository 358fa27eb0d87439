"""Workers don't outlive the program they work for."""

import os
import signal
import subprocess
import sys
import time

import pytest
from few_cases import few_of
from timeouts import LONGEST_S

BEGINNING = """
import os, signal, sys, threading, time
from concurrent.futures.process import BrokenProcessPool
from kogao_core.base.threads import without_blas_threads
without_blas_threads()
from kogao_core.batch import Outcome, Task, Workers, run, workers
from kogao_core.retouch import RetouchJob
"""
# Prints the process of its worker, and waits to be killed.
PROGRAM = """
if __name__ == "__main__":
    executor = Workers.processes(1)._make()
    print(executor.submit(os.getpid).result(), flush=True)
    time.sleep(60)
"""
# Interrupts its worker, as Ctrl+C does, before the worker has done anything.
INTERRUPTED = """
if __name__ == "__main__":
    # A program with threads starts its worker anew, which takes longer than a copy.
    threading.Thread(target=threading.Event().wait, daemon=True).start()
    with Workers.processes(1) as pool:
        outcome = pool.submit(Task("none.jpg", "out.jpg", RetouchJob()))
        for worker in pool._executor._processes:
            os.kill(worker, signal.SIGINT)
        print(outcome.result().reason)
"""
# Prints whether its worker has a module that only the program has loaded.
COPIED = """
def is_loaded():
    return "colorsys" in sys.modules
if __name__ == "__main__":
    import colorsys
    if sys.argv[1:]:
        threading.Thread(target=threading.Event().wait, daemon=True).start()
    with Workers.processes(1)._make() as executor:  # Python's race of an open one goes to stderr
        print(executor.submit(is_loaded).result())
"""
# Ends its worker, as systems do, and has a handler of its own for that.
ENDED = """
if __name__ == "__main__":
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    executor = Workers.processes(1)._make()
    os.kill(executor.submit(os.getpid).result(), signal.SIGTERM)
    try:
        executor.submit(time.sleep, 60).result()
    except BrokenProcessPool:
        print("gone")
    executor.shutdown()
"""
# Hands out photos at some of which a worker dies; prints what becomes of each.
DYING = """
def dies(task):
    if "poison" in task.source:
        os.kill(os.getpid(), signal.SIGKILL)
    return Outcome(task.source, task.output, "done")
if __name__ == "__main__":
    workers.work = dies
    count, *sources = sys.argv[1:]
    tasks = [Task(source, f"{k}.jpg", RetouchJob()) for k, source in enumerate(sources)]
    for one in run(tasks, Workers.processes(int(count))):
        print(one.output, one.source, one.status, one.reason)
"""


@pytest.fixture
def told(tmp_path):
    """Run a program, from a file that its workers can begin with; return what it prints."""

    def run(program, *arguments):
        script = tmp_path / "program.py"
        script.write_text(BEGINNING + program)
        done = subprocess.run(
            [sys.executable, script, *arguments], cwd=tmp_path, timeout=LONGEST_S,
            capture_output=True, text=True, check=False,
        )  # fmt: skip
        assert done.stderr == ""
        return done.stdout

    return run


@pytest.mark.skipif(sys.platform == "win32", reason="needs signals")
def test_an_interrupt_while_workers_start_is_not_for_them(told):
    assert told(INTERRUPTED) == "none.jpg doesn't exist; check the name and the folder\n"


@pytest.mark.skipif(sys.platform == "win32", reason="needs SIGKILL")
def test_an_idle_worker_ends_with_a_killed_program():
    command = [sys.executable, "-c", BEGINNING + PROGRAM]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as program:
        worker = int(program.stdout.readline())
        os.kill(worker, 0)
        program.kill()
    deadline = time.monotonic() + LONGEST_S
    while time.monotonic() < deadline:
        try:
            os.kill(worker, 0)
        except ProcessLookupError:
            return
        time.sleep(0.05)
    os.kill(worker, signal.SIGKILL)
    pytest.fail("the worker waits for a program that is gone")


@pytest.mark.skipif(sys.platform != "linux", reason="workers begin afresh elsewhere")
@pytest.mark.parametrize(("threads", "is_copy"), [([], "True"), (["more"], "False")])
def test_a_worker_is_a_copy_of_a_program_of_one_thread(told, threads, is_copy):
    assert told(COPIED, *threads) == f"{is_copy}\n"


@pytest.mark.skipif(sys.platform == "win32", reason="needs signals")
def test_what_ends_a_program_in_a_word_ends_its_workers_at_once(told):
    assert told(ENDED) == "gone\n"


@pytest.mark.skipif(sys.platform == "win32", reason="needs SIGKILL")
@pytest.mark.parametrize(("count", "poisoned"), few_of([(1, {1}), (2, {4, 9})], 1))
def test_a_worker_that_dies_fails_its_own_photo_only(told, count, poisoned):
    sources = ["poison" if k in poisoned else "good" for k in range(max(poisoned) + 3)]
    ends = {"good": "done ", "poison": "failed the worker process died; run fewer photos at a time"}
    expected = [f"{k}.jpg {source} {ends[source]}" for k, source in enumerate(sources)]
    assert sorted(told(DYING, str(count), *sources).splitlines()) == sorted(expected)
