"""What a copy will need of the photo's own file, read while nobody waits for it."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from kogao_core.photo import FORMATS, Photo, read_ahead

from ..faces import Faces
from ..feature import Context, Feature

# Of memory, for as long as the photo is open: 26 megapixels of a JPEG at 4:4:4, 53 at 4:2:0.
MOST_BYTES: Final = 160_000_000
_SAMPLE_BYTES: Final = 2


class ReadAhead(Feature):
    """Reads ahead of saving, once faces are known; forgets it when another photo is opened."""

    def __init__(self, context: Context, faces: Faces) -> None:
        super().__init__(context)
        self._known: tuple[Photo, object] | None = None
        # Whoever saves tries again, and hears of it.
        self._reading = self.lane(self._take, lambda _: None)
        self.document.opened.connect(self._forget)
        faces.found.connect(self._read)

    def of(self, photo: Photo) -> object | None:
        """Return what was read of a photo; None where nothing was, or not yet."""
        known = self._known
        return known[1] if known is not None and known[0] is photo else None

    def _forget(self) -> None:
        self._reading.drop()
        self._known = None

    def _read(self, faces: int) -> None:
        photo = self.document.photo
        if not faces or photo is None or self.of(photo) is not None:
            return
        if _bytes_of(photo) <= MOST_BYTES:
            folder = self.storage.data
            self._reading.submit(lambda: (photo, _read(photo, folder)))

    def _take(self, known: tuple[Photo, object]) -> None:
        self._known = known


def _bytes_of(photo: Photo) -> int:
    """Return how much memory the coefficients of a photo take."""
    shares = {1: 2.0, 2: 1.5}  # of the luma, by Pillow's number of the subsampling
    samples = (
        1.0 if photo.channels == 1 else shares.get(photo.jpeg.subsampling if photo.jpeg else 0, 3.0)
    )
    return round(_SAMPLE_BYTES * samples * photo.width * photo.height)


def _read(photo: Photo, folder: Path) -> object:
    """Read in a worker; what has to be a file for a moment lies in a folder of the editor."""
    suffix = next((ending for ending, name in FORMATS.items() if name == photo.format), None)
    if suffix is None:
        return None
    folder.mkdir(parents=True, exist_ok=True)
    return read_ahead(photo, folder / f"copy{suffix}")
