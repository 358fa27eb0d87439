"""One search for the faces of a photo: its thread adds to it, the window looks on."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from kogao_core.face import Face, LandmarkSource
from kogao_core.photo import Photo
from kogao_core.threads import stoppable


class FaceSearch:
    """A search that is under way, or over.

    Parameters
    ----------
    source : LandmarkSource
        What finds the faces.
    first : bool
        False for one that was asked for in place of what is there.

    Attributes
    ----------
    found : list of Face
        What it has found so far.
    shown : tuple of Face
        Those of them that went into the document.
    took_s : float
        How long it took, once it is over.
    came : callable
        Called after each face, in any thread.
    """

    def __init__(self, source: LandmarkSource, *, first: bool = True) -> None:
        self._source, self.first = source, first
        self.found: list[Face] = []
        self.shown: tuple[Face, ...] = ()
        self.took_s = 0.0
        self.came: Callable[[], object] = lambda: None
        self._faces: list[Face] | None = None
        self._one_at_a_time, self._unwanted = threading.Lock(), threading.Event()

    def run(self, photo: Photo) -> list[Face]:
        """Return the faces of a photo; who asks while they are sought waits for them.

        Raises
        ------
        Stopped
            If nobody wants them any more.
        Exception
            What the source raises.
        """
        with self._one_at_a_time:
            if self._faces is None:
                start = time.perf_counter()
                with stoppable(self._unwanted.is_set):
                    self._faces = self._source.find(photo.pixels, self._add)
                self.took_s = time.perf_counter() - start
            return self._faces

    def stop(self) -> None:
        """End it soon, if it is under way."""
        self._unwanted.set()

    def _add(self, face: Face) -> None:
        self.found.append(face)
        self.came()
