"""A batch on a Dask cluster of the loopback address: deaths, versions, folders, resuming."""

import json
import logging
import os
import shutil
import socket
import subprocess
import sys
import time
from contextlib import contextmanager
from unittest.mock import Mock

import pytest
from timeouts import LONGEST_S

from kogao_core import __version__
from kogao_core.base import installed
from kogao_core.batch import cluster

pytest.importorskip("distributed")
pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="needs signals")
DASK = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--host", "127.0.0.1"]
WORKER = [sys.executable, "-m", "distributed.cli.dask_worker", "--host", "127.0.0.1"]
# A worker dies at a photo with a mark beside it, as often as the mark says.
DYING = """
import os, signal
from pathlib import Path
from kogao_core.batch import cluster
from kogao_core.batch.tasks import work
def dies(task):
    if (mark := Path(task.source).with_suffix(".mark")).exists():
        left = int(mark.read_text()) - 1
        mark.write_text(str(left)) if left else mark.unlink()
        os.kill(os.getpid(), signal.SIGKILL)
    return work(task)
cluster.work = dies
"""
OLDER = """
from kogao_core.batch import cluster
cluster.__version__ = "0.9"
"""


@contextmanager
def process(*command, cwd):
    with (cwd / "dask.log").open("ab") as log:
        one = subprocess.Popen(command, cwd=cwd, stdout=log, stderr=log)
    try:
        yield one
    finally:
        one.terminate()
        one.wait(LONGEST_S)


def until(holds):
    deadline = time.monotonic() + LONGEST_S
    while not holds():
        assert time.monotonic() < deadline
        time.sleep(0.02)


@contextmanager
def scheduler(cwd, port=0):
    """Yield the process and the address of a scheduler."""
    file = cwd / "scheduler.json"
    file.unlink(missing_ok=True)
    options = "--port", str(port), "--no-dashboard", "--scheduler-file", str(file)
    with process(*DASK, *options, cwd=cwd) as one:
        until(lambda: file.exists() and file.read_text().endswith("}"))
        yield one, json.loads(file.read_text())["address"]


@contextmanager
def workers(address, cwd, count, preload="", before=0):
    """Start worker processes that run a text first; wait until they join those before."""
    from distributed import Client

    options = "--nworkers", str(count), "--nthreads", "1", "--no-dashboard"
    started = ("--preload", preload) if preload else ()
    with process(*WORKER, address, *options, *started, cwd=cwd) as one:
        with Client(address, set_as_default=False) as client:
            client.wait_for_workers(before + count, LONGEST_S)
        yield one


@pytest.fixture
def home(tmp_path, small_portrait):
    """A folder with six portraits, for Dask's programs and for Kogao."""
    (tmp_path / "in").mkdir()
    for n in range(6):
        shutil.copy(small_portrait, tmp_path / "in" / f"{n}.jpg")
    return tmp_path


def batch(home, address, *more):
    program = "from kogao_core.cli import main; main()"
    options = "batch", "in", "-o", "out", "--cluster", address, *more
    return subprocess.Popen(
        [sys.executable, "-c", program, *options],
        cwd=home,
        env={**os.environ, "LC_ALL": "C"},
        stderr=subprocess.PIPE,
        text=True,
    )


def ended(program):
    _, err = program.communicate(timeout=LONGEST_S)
    return program.returncode, err


def results(home):
    return sorted(path.name for path in (home / "out").glob("*.jpg"))


def statuses(home):
    report = home / "out" / "kogao-batch.jsonl"
    return [json.loads(line)["status"] for line in report.read_text().splitlines()]


EVERY = [f"{n}.jpg" for n in range(6)]


@pytest.fixture
def inside(monkeypatch, home):
    """Yield the address of a scheduler with one worker in this process."""
    from distributed import LocalCluster

    monkeypatch.chdir(home)
    settings = {"processes": False, "dashboard_address": None, "silence_logs": False}
    with LocalCluster(n_workers=1, threads_per_worker=1, **settings) as cluster:
        yield cluster.scheduler_address
    logging.disable(logging.NOTSET)


def test_a_batch_on_a_cluster_is_resumed_on_this_machine(cli, home, inside):
    for photo in EVERY[2:]:
        (home / "in" / photo).unlink()
    asked = "batch", "in", "-o", "out"
    assert cli(*asked, "--cluster", inside)[0] == 0
    assert results(home) == EVERY[:2]
    (home / "out" / "1.jpg").unlink()
    assert cli(*asked, "--cluster", inside)[0] == 0
    assert "2 skipped" in cli(*asked, "--jobs", 1)[2]
    assert statuses(home).count("done") == 3
    assert not list((home / "out").glob(".kogao-*"))


def test_another_version_or_folder_is_named(home):
    assert cluster._fault(__version__, home) == ""
    assert cluster._fault("0.9", home) == f"it has Kogao {__version__}, not 0.9"
    assert str(home / "away") in cluster._fault(__version__, home, home / "away")


def test_without_the_package_the_command_to_install_it_is_named(cli, home, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    code, _, err = cli("batch", home / "in", "-o", home / "out", "--cluster", "tcp://127.0.0.1:1")
    logging.disable(logging.NOTSET)
    assert (code, installed.adding("cluster") in err) == (2, True)
    assert not (home / "out").exists()


def test_without_the_option_a_batch_connects_to_nothing(cli, home, monkeypatch):
    connect = Mock(side_effect=OSError("connected"))
    monkeypatch.setattr(socket.socket, "connect", connect)
    assert cli("batch", home / "in" / "0.jpg", "-o", home / "out", "--jobs", 1)[0] == 0
    connect.assert_not_called()
    code, _, err = cli(
        "batch", home / "in", "-o", home / "out", "--cluster", "tcp://127.0.0.1", "--jobs", 1
    )
    assert (code, "--cluster and --jobs" in err) == (2, True)


@pytest.mark.slow
def test_two_workers_resume_and_refuse_another_version(home):
    with scheduler(home) as (_, address):
        assert "no workers are there" in ended(batch(home, address))[1]
        with workers(address, home, 2):
            assert ended(batch(home, address))[0] == 0
            assert results(home) == EVERY
            code, err = ended(batch(home, address))
            assert (code, err) == (0, "6 of 6: 6 skipped; see out/kogao-batch.jsonl\n")
            with workers(address, home, 1, OLDER, before=2):
                code, err = ended(batch(home, address, "--again"))
                assert (code, f"it has Kogao 0.9, not {__version__}" in err) == (2, True)
        assert statuses(home) == ["done"] * 6 + ["skipped"] * 6


@pytest.mark.slow
@pytest.mark.parametrize("deaths", [1, 99])
def test_a_killed_worker_loses_no_photo_of_others(home, deaths):
    (home / "in" / "3.mark").write_text(str(deaths))
    with scheduler(home) as (_, address), workers(address, home, 2, DYING):
        code, err = ended(batch(home, address))
    if deaths == 1:
        assert (code, results(home)) == (0, EVERY)
    else:
        assert (code, results(home)) == (5, [*EVERY[:3], *EVERY[4:]])
        assert "3.jpg: the worker process died" in err
    assert len(statuses(home)) == 6


@pytest.mark.slow
def test_a_scheduler_that_stops_leaves_a_batch_to_resume(home):
    report = home / "out" / "kogao-batch.jsonl"
    with scheduler(home) as (one, address), workers(address, home, 1):
        program = batch(home, address)
        until(lambda: report.is_file() and report.read_text().count("\n") >= 2)
        one.terminate()
        code, err = ended(program)
        assert code == 2
        assert err.endswith("the scheduler is gone; start it, then run the batch again\n")
    done = statuses(home)
    assert 2 <= len(done) < 6
    with scheduler(home) as (_, address), workers(address, home, 1):
        assert ended(batch(home, address, "--force"))[0] == 0
    assert results(home) == EVERY
    assert statuses(home).count("skipped") == len(done)
