"""Tasks shared with helpers: all done, none lost, and nobody at work afterwards."""

import sys
import threading

import pytest
from programs import ran
from timeouts import LONGEST_S

from kogao_core.base import threads
from kogao_core.base.threads import ObjectPool, Stopped, parallel_for, parallel_in_order, stoppable


@pytest.fixture
def gate():
    """What holds helpers up; opened at the end of a test, whatever came of it."""
    gate = threading.Event()
    yield gate
    gate.set()


def is_helper() -> bool:
    return threading.current_thread().name.startswith("kogao-warp")


@pytest.mark.parametrize("count", [1, 2, 4])
def test_every_task_is_done_once(count):
    done = []
    parallel_for(range(1000), lambda: done.append, count)
    assert sorted(done) == list(range(1000))


def test_nobody_waits_for_helpers_that_queue_behind_others_work(gate):
    """As a preview would behind an export: every thread of the pool is taken."""
    for _ in range(3):
        threads._pool(3).submit(gate.wait, LONGEST_S)
    done = []
    caller = threading.Thread(target=parallel_for, args=(range(100), lambda: done.append, 3))
    caller.start()
    caller.join(LONGEST_S / 2)
    assert not caller.is_alive()
    assert done == list(range(100))


@pytest.mark.parametrize("failing", ["caller", "helper"])
def test_an_exception_comes_out_when_everyone_has_stopped(gate, failing):
    """Whoever fails, the other one is in the middle of a task."""
    busy, ended = threading.Event(), []

    def do(task):
        if is_helper() == (failing == "helper"):
            assert busy.wait(LONGEST_S)
            threading.Timer(0.1, gate.set).start()
            raise MemoryError
        busy.set()
        assert gate.wait(LONGEST_S)
        ended.append(task)

    with pytest.raises(MemoryError):
        parallel_for(range(1000), lambda: do, 2)
    assert len(ended) == 1, "nobody begins another task"


@pytest.mark.parametrize("count", [1, 2])
def test_nothing_is_begun_any_more_once_nobody_wants_it(count):
    done = []
    with pytest.raises(Stopped), stoppable(lambda: len(done) >= 3):
        parallel_for(range(1000), lambda: done.append, count)
    assert 3 <= len(done) < 3 + count
    done.clear()
    parallel_for(range(10), lambda: done.append, count)
    assert sorted(done) == list(range(10)), "what comes later is wanted"


@pytest.mark.parametrize("count", [1, 2, 4])
def test_results_are_taken_in_the_order_of_the_tasks(count):
    taken = []
    parallel_in_order(range(300), str, lambda task, result: taken.append((task, result)), count)
    assert taken == [(task, str(task)) for task in range(300)]


def test_a_result_waits_for_those_before_it():
    second, taken = threading.Event(), []

    def do(task):
        if task == 1:
            second.set()
        assert second.wait(LONGEST_S)

    parallel_in_order(range(2), do, lambda task, _: taken.append(task), 2)
    assert taken == [0, 1]


def test_nobody_shares_what_is_lent():
    spares = ObjectPool(object)
    with spares.one() as first, spares.one() as second:
        assert first is not second
    with spares.one() as again:
        assert again in (first, second)


# As when a photo is searched for faces while Qt is loaded.
LOADING = """
    import threading, numpy
    from kogao_core.base import threads

    loaded = threading.Event()

    def look():
        while not loaded.is_set():
            threads._controller.__wrapped__()

    looking = threading.Thread(target=look)
    looking.start()
    import cv2, PIL.ImageCms, PySide6.QtWidgets, PySide6.QtNetwork
    loaded.set()
    looking.join()
"""


def test_looking_for_blas_holds_up_nobody_who_loads_a_library():
    """The loader's lock was held for a callback in Python, which waited for whoever loads."""
    ran(LOADING)


COMMAND = """
    import os
    os.environ.pop("OPENBLAS_NUM_THREADS", None)
    from kogao_core.cli import main
    try:
        main(["--version"])
    except SystemExit:
        import numpy
        from threadpoolctl import threadpool_info
        counts = [one["num_threads"] for one in threadpool_info() if one["user_api"] == "blas"]
        print(max(counts, default=1))
"""


def test_a_command_has_no_blas_threads_that_wait_at_full_speed():
    assert ran(COMMAND).stdout.endswith("\n1\n")


FREEING = """
    import resource, sys
    from kogao_core.base.threads import reuse_freed_memory
    if not reuse_freed_memory():
        sys.exit(print("0 told"))
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
    found = ran(FREEING).stdout
    if "told" in found:
        pytest.skip("this C library can't be told")
    assert int(found) < 100  # of 10,240 pages


GIVING_BACK = """
    import sys
    from pathlib import Path
    from kogao_core.base.threads import give_back_freed_memory
    pages = lambda: int(Path("/proc/self/statm").read_text().split()[1])
    blocks = [b"1" * 100_000 for _ in range(1000)]
    held = blocks[-1:]  # at the end of the heap
    del blocks
    before = pages()
    give_back_freed_memory()
    print(before - pages())
"""


@pytest.mark.skipif(sys.platform != "linux", reason="only glibc keeps it")
def test_freed_blocks_below_one_in_use_are_given_back():
    assert int(ran(GIVING_BACK).stdout) > 20_000  # of 24,000 pages
