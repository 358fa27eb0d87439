"""Hand the tasks of a batch to a Dask cluster (package ``distributed``)."""

from __future__ import annotations

import contextlib
import logging
import tempfile
import threading
from concurrent.futures import Executor, Future
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import cv2

from kogao_core import __version__
from kogao_core.base import installed
from kogao_core.base.language import Text
from kogao_core.batch.planning import NothingToDo
from kogao_core.batch.tasks import Outcome, Task, work
from kogao_core.batch.workers import Workers
from kogao_core.projects.results import Results

_ALONE: Final = threading.Lock()  # networks and the current folder serve one task at a time


class _Cluster(Executor):
    """Runs tasks on the workers of a Dask client, in the current folder of this process."""

    def __init__(self, client: Any) -> None:
        # A pure task that is tried again could get the answer of its first try.
        self._client, self._executor = client, client.get_executor(pure=False)

    def submit(self, _: Any, task: Task) -> Any:  # type: ignore[override]
        """Submit a task for `work`. Raises NothingToDo if the scheduler is gone."""
        # The index of results is a database, which a shared folder can't serve.
        if task.results and Results(Path(task.results)).origin(Path(task.source)):
            (known := Future[Outcome]()).set_result(work(task))
            return known
        if self._client.status != "running":
            raise NothingToDo("the scheduler is gone; start it, then run the batch again")
        return self._executor.submit(_work, __version__, Path.cwd(), replace(task, results=""))


def connect(address: str, folder: Path) -> Workers:
    """Return the workers of a scheduler, all with this version and a view of the current folder.

    `folder`: for results; created if missing, and all must see it. Raises NothingToDo.
    """
    logging.disable()  # of a lost connection, Dask logs tracebacks
    try:
        from distributed import Client

        client = Client(address, set_as_default=False)
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=folder.absolute(), prefix=".kogao-") as mark:
            seen = client.run(_fault, __version__, Path.cwd(), Path(mark.name), on_error="return")
    except Exception as error:  # of sockets, TLS, addresses and folders, each of its own type
        reason = installed.adding("cluster") if isinstance(error, ImportError) else error
        raise NothingToDo("the cluster can't be used: {reason}", reason=reason) from error
    for worker, fault in seen.items() or [(address, Text("no workers are there; start some"))]:
        if fault:
            raise NothingToDo("{worker}: {fault}", worker=worker, fault=fault)
    return Workers(lambda: _Cluster(client), len(seen))


def _fault(version: str, *paths: Path) -> str:
    """Return why this process can't do tasks of that version on those paths, or ""."""
    if version != __version__:
        return Text("it has Kogao {its}, not {version}", its=__version__, version=version)
    if unseen := [path for path in paths if not path.exists()]:
        return Text("it can't see {path}; share that folder at that path", path=unseen[0])
    return ""


def _work(version: str, folder: Path, task: Task) -> Outcome:
    if fault := _fault(version, folder):  # of a worker that joined late
        return Outcome(task.source, task.output, "failed", reason=fault)
    with _ALONE, contextlib.chdir(folder):
        cv2.setNumThreads(1)
        return work(task)
