"""A photo that is read, and searched for faces, while there is no window yet."""

from __future__ import annotations

from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

from kogao_core.face import LandmarkSource
from kogao_core.photo import Photo, read

from .render.colour import pyramid_of
from .render.pyramid import PicturePyramid
from .search import FaceSearch


class Ahead:
    """Reads a photo in a thread of its own, makes its levels, then looks for faces.

    Parameters
    ----------
    path : Path
        The photo; of anything else only an exception comes.

    Attributes
    ----------
    photo, pyramid : Future
        Of a `Photo` and its `PicturePyramid`.
    search : FaceSearch or None
        The search, once it was begun.
    """

    def __init__(self, path: Path) -> None:
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="ahead")
        self.photo: Future[Photo] = self._thread.submit(read, path.absolute())
        self.pyramid: Future[PicturePyramid] = self._thread.submit(
            lambda: pyramid_of(self.photo.result())
        )
        self.search: FaceSearch | None = None

    def seek(self, source: LandmarkSource) -> None:
        """Look for faces next; nothing more is asked for."""
        self.search = search = FaceSearch(source)
        self._thread.submit(lambda: search.run(self.photo.result()))
        self._thread.shutdown(wait=False)
