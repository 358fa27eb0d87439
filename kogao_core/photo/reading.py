"""Read a photo: upright pixels at full bit depth, with metadata."""

from __future__ import annotations

import dataclasses
import math
import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from io import BufferedReader
from pathlib import Path
from types import ModuleType
from typing import IO, Final, Literal

from PIL import Image as Pillow
from PIL import PngImagePlugin, UnidentifiedImageError

from kogao_core.base.language import Text
from kogao_core.base.stderr import hushed
from kogao_core.base.wording import system_reason
from kogao_core.photo import formats
from kogao_core.photo.errors import UnreadablePhoto
from kogao_core.photo.formats import common
from kogao_core.photo.formats.base import Source
from kogao_core.photo.metadata import kinds, photoshop, references, tiff, tiff_extras
from kogao_core.photo.metadata.kinds import Extra, Kind
from kogao_core.photo.model import Photo, Stamp
from kogao_core.photo.picture import hashes_of

MAX_MEGAPIXELS: Final = 300.0
_RGB_BYTES: Final = 3
_COPIES: Final = 3  # copies of the pixels in memory while a photo is read and rotated
_PILLOWS: Final = tuple(form.name for form in formats.ALL if form.decode is None)
# Test for raw photos first, by file name: most raw files are also valid TIFF files.
_OTHERS: Final = sorted(formats.ALL, key=lambda form: form.name != "RAW")
_LOCK: Final = threading.Lock()
_TEXT_BYTES: Final = 1 << 24  # most bytes of an unpacked text or profile of a PNG


def read(
    path: str | os.PathLike[str],
    *,
    max_megapixels: float = MAX_MEGAPIXELS,
    bits: Literal[8, 16] = 16,
) -> Photo:
    """Read a JPEG, PNG, TIFF, WebP or AVIF file; with optional packages also HEIC and raw files.

    Parameters
    ----------
    path : path
        The file. The format is detected from the content, except for raw files.
    max_megapixels : float
        Larger pictures are rejected before decoding.
    bits : {8, 16}
        Bit depth for raw files and for HEIC files with 10 or 12 bits.

    Returns
    -------
    Photo
        Upright pixels at the file's bit depth: 16-bit PNG and TIFF stay uint16, float TIFF stays
        float32. Palettes and CMYK become RGB(A).

    Raises
    ------
    UnreadablePhoto
        If the file is missing, damaged, too large or no photo; the message says what to do.

    Examples
    --------
    >>> import kogao_core as kogao
    >>> kogao.read(kogao.sample()).pixels.shape
    (900, 900, 3)
    >>> try:
    ...     kogao.read("no-such.jpg")
    ... except kogao.UnreadablePhoto as problem:
    ...     print(problem)
    no-such.jpg doesn't exist; check the name and the folder
    """
    path = Path(path)
    try:  # refusals lack their subject, the path
        if (problem := _why_absent(path)) is not None:
            raise UnreadablePhoto(problem)
        with path.open("rb") as file:
            return _read_open(file, path, max_megapixels, bits)
    except UnreadablePhoto as error:
        why, cause = str(error), error.__cause__
    except PermissionError:
        why, cause = Text("may not be read; check its permissions"), None
    except OSError as error:
        reason, cause = system_reason(error), error
        why = Text("can't be read ({reason}); try again or copy it", reason=reason)
    raise UnreadablePhoto(Text.joined(" ", [str(path), why])) from cause


def _why_absent(path: Path) -> Text | None:
    if path.is_dir():
        return Text("is a folder; name a photo inside it")
    if path.is_symlink() and not path.exists():
        return Text(
            "is a link to {target}, where there is nothing; name the photo itself",
            target=path.readlink(),
        )
    if not path.exists():
        return Text("doesn't exist; check the name and the folder")
    if not path.is_file():
        return Text("is not an ordinary file; copy the photo to a file first")
    if path.stat().st_size == 0:
        return Text("is empty (0 bytes); copy it again from where it came")
    return None


def _read_open(file: BufferedReader, path: Path, max_megapixels: float, bits: int) -> Photo:
    def check(width: int, height: int, pixel_bytes: int) -> None:
        _check_size(width, height, pixel_bytes, max_megapixels)

    stamp = Stamp.of(os.fstat(file.fileno()))
    with _own_limits(), hushed() as complaints:
        try:
            photo = _decoded(Source(file, path, bits, check))
            picture, sha256 = hashes_of(file, photo)
            photo = dataclasses.replace(
                photo, stamp=stamp, extras=extras_of(photo, file), picture=picture, sha256=sha256
            )
        except UnreadablePhoto:
            raise
        except UnidentifiedImageError:
            known = formats.either([form.title for form in formats.ALL])
            raise UnreadablePhoto(
                "is not a {known} photo; convert it to one of them first", known=known
            ) from None
        except MemoryError:
            raise UnreadablePhoto(
                "doesn't fit into memory; make it smaller or close other programs"
            ) from None
        except Exception as error:  # decoders raise almost anything on damaged files
            # A function that a library lacks is no fault of the file.
            if isinstance(error, ImportError) or isinstance(getattr(error, "obj", 0), ModuleType):
                raise
            raise UnreadablePhoto(
                "is damaged or incomplete; copy it again from where it came"
            ) from error
    photo.pixels.setflags(write=False)
    notes = (
        *photo.notes,
        *(Text("the file is slightly damaged: {one}", one=one) for one in complaints[:1]),
    )
    return dataclasses.replace(photo, notes=notes)


def _decoded(source: Source) -> Photo:
    for form in _OTHERS:
        if form.recognises and form.decode and form.recognises(source.file, source.path):
            return form.decode(source)
    return common.decode(source, _PILLOWS)


@contextmanager
def _own_limits() -> Iterator[None]:
    # Pillow's limits are global variables. `_check_size` applies Kogao's limit of the size.
    with _LOCK:
        limit, Pillow.MAX_IMAGE_PIXELS = Pillow.MAX_IMAGE_PIXELS, None
        most, PngImagePlugin.MAX_TEXT_CHUNK = PngImagePlugin.MAX_TEXT_CHUNK, _TEXT_BYTES
        try:
            yield
        finally:
            Pillow.MAX_IMAGE_PIXELS, PngImagePlugin.MAX_TEXT_CHUNK = limit, most


def _check_size(width: int, height: int, pixel_bytes: int, max_megapixels: float) -> None:
    """Reject pixels above the limit, above that of 8-bit RGB in bytes, or above the free memory.

    Raises UnreadablePhoto.
    """
    megapixels = width * height / 1e6
    if megapixels > max_megapixels:
        raise UnreadablePhoto(
            "is {width} x {height} px, {megapixels} megapixels; the limit "
            "is {max_megapixels:g}: raise it by kogao-cli --max-megapixels if the "
            "photo is genuine, or make it smaller",
            width=width,
            height=height,
            megapixels=f"{megapixels:.0f}" if megapixels >= 1.0 else f"{megapixels:.2g}",
            max_megapixels=max_megapixels,
        )
    count = width * height * pixel_bytes
    limit = min(_RGB_BYTES * max_megapixels * 1e6, _free_bytes() / _COPIES)
    if count > limit:
        raise UnreadablePhoto(
            "takes {size:.0f} MB of memory a copy; the limit is {limit:.0f} MB: close "
            "other programs, raise it by kogao-cli --max-megapixels, or save the photo with 8 "
            "bits",
            size=count / 1e6,
            limit=limit / 1e6,
        )


def _free_bytes() -> float:
    """Return the free memory in bytes, or infinity if the system doesn't report a number."""
    with suppress(OSError, StopIteration, ValueError, IndexError):
        lines = Path("/proc/meminfo").read_text().splitlines()
        line = next(one for one in lines if one.startswith("MemAvailable:"))
        return float(line.split()[1]) * 1024
    return math.inf


def extras_of(photo: Photo, file: IO[bytes]) -> tuple[Extra, ...]:
    """Return all content other than pixels, profile, EXIF, XMP, IPTC and resolution.

    Result: in file order, without duplicates.
    """
    form = formats.BY_NAME[photo.format]
    seen = [*photo.extras, *form.inside(photo, file), *_from_metadata(photo, form.note)]
    if form.behind is not None:
        file.seek(0)
        seen += form.behind(file)
    return tuple(dict.fromkeys(seen))


def _from_metadata(photo: Photo, note: Kind) -> Iterator[Extra]:
    """Yield the extras found in the metadata blocks."""
    is_turned = photo.orientation != 1
    yield from map(Extra, references.found(photo.xmp, is_turned=is_turned) if photo.xmp else ())
    if is_turned and photo.photoshop and photoshop.has_places(photo.photoshop):
        yield Extra(kinds.PLACES)
    if photo.photoshop and photoshop.xmp_of(photo.photoshop) not in (None, photo.xmp):
        yield Extra(kinds.PHOTOSHOP_XMP)
    if photo.exif is None:
        return
    tags = Pillow.Exif()
    try:
        tags.load(photo.exif)
        has_note = tiff_extras.has_maker_note(tags)
    except Exception:  # a damaged block is copied unchanged
        return
    if has_note:
        yield Extra(note)
    if note is kinds.MAKER_NOTE and (rare := list(filter(tiff.is_rare, tags))):
        yield Extra(kinds.EXIF_TAGS, Text("EXIF tags {tags}", tags=" ".join(map(str, rare))))
