"""Face search, and reading of a photo before the window exists."""

from __future__ import annotations

import threading
import time
import weakref
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

from kogao_core.base.threads import stoppable
from kogao_core.faces.face import Face, LandmarkSource
from kogao_core.photo import Photo, read
from kogao_core.photo.profiles import for_search

from .pyramid import PicturePyramid
from .render.colour import pyramid_of


class Ahead:
    """Reads a photo in a background thread, builds the pyramid, then searches for faces."""

    def __init__(self, path: Path) -> None:
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="ahead")
        self.photo: Future[Photo] = self._thread.submit(read, path.absolute())
        self.pyramid: Future[PicturePyramid] = self._thread.submit(
            lambda: pyramid_of(self.photo.result())
        )
        self.search: FaceSearch | None = None

    def seek(self, source: LandmarkSource) -> None:
        """Search for faces after reading; accept no further jobs."""
        self.search = search = FaceSearch(source)
        self._thread.submit(lambda: search.run(self.photo.result()))
        self._thread.shutdown(wait=False)


# Sources with loaded networks.
_warm: weakref.WeakSet[LandmarkSource] = weakref.WeakSet()


class FaceSearch:
    """A search for the faces of a photo: a thread adds faces, the window polls."""

    def __init__(self, source: LandmarkSource, *, first: bool = True) -> None:
        self._source, self.first = source, first
        self.found: list[Face] = []
        self.shown: tuple[Face, ...] = ()
        self.took_s = 0.0
        self.cold = False  # whether the time includes loading of networks
        self.came: Callable[[], object] = lambda: None
        self._faces: list[Face] | None = None
        self._one_at_a_time, self._unwanted = threading.Lock(), threading.Event()

    def run(self, photo: Photo) -> list[Face]:
        """Return the faces of a photo; a second caller waits for the running search.

        Raises Stopped.
        """
        with self._one_at_a_time:
            if self._faces is None:
                self.cold = self._source not in _warm
                _warm.add(self._source)
                start = time.perf_counter()
                with stoppable(self._unwanted.is_set):
                    self._faces = self._source.find(for_search(photo), self._add)
                self.took_s = time.perf_counter() - start
            return self._faces

    def stop(self) -> None:
        """Request the end of a running search."""
        self._unwanted.set()

    def _add(self, face: Face) -> None:
        self.found.append(face)
        self.came()
