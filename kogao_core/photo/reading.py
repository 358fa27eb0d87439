"""Open a photo: upright pixels at full depth, with the metadata that must survive."""

from __future__ import annotations

import dataclasses
import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Final, Literal

import numpy as np
from PIL import Image as Pillow
from PIL import JpegImagePlugin, UnidentifiedImageError

from kogao_core.photo import (
    colour,
    contents,
    deep,
    extras,
    heif,
    jpeg_data,
    metadata,
    raw,
    riff,
    tiff,
)
from kogao_core.photo.errors import UnreadablePhoto
from kogao_core.photo.model import READ_ONLY, Format, Photo, Stamp
from kogao_core.photo.turning import turn_upright
from kogao_core.stderr import hushed

MAX_MEGAPIXELS: Final = 300.0
# TIFF has a way of its own.
_COMMON: Final[tuple[Format, ...]] = ("JPEG", "PNG", "WEBP")
_LOCK: Final = threading.Lock()


def read(
    path: str | os.PathLike[str],
    *,
    max_megapixels: float = MAX_MEGAPIXELS,
    bits: Literal[8, 16] = 16,
) -> Photo:
    """Read a JPEG, PNG, TIFF or WebP file; HEIC and raw files where their extras are installed.

    Parameters
    ----------
    path : path
        The file; its content decides the format, not its name.
    max_megapixels : float
        Larger pictures are refused before they are decoded.
    bits : {8, 16}
        How deep raw files, and HEIC files of 10 or 12 bits, are to be.

    Returns
    -------
    Photo
        Its pixels are upright and as deep as the file: 16-bit PNG and TIFF stay uint16, float TIFF
        stays float32. Palettes and CMYK become RGB(A).

    Raises
    ------
    UnreadablePhoto
        If the file is missing, damaged, too large or no photo; the message says what to do.
    """
    path = Path(path)
    try:
        with _present(path).open("rb") as file:
            return _read_open(file, path, max_megapixels, bits)
    except PermissionError:
        raise UnreadablePhoto(f"{path} may not be read; check its permissions") from None
    except OSError as error:
        reason = error.strerror or error
        raise UnreadablePhoto(f"{path} can't be read ({reason}); try again or copy it") from error


def _present(path: Path) -> Path:
    if path.is_dir():
        raise UnreadablePhoto(f"{path} is a folder; name a photo inside it")
    if path.is_symlink() and not path.exists():
        raise UnreadablePhoto(
            f"{path} is a link to {path.readlink()}, where there is nothing; name the photo itself"
        )
    if not path.exists():
        raise UnreadablePhoto(f"{path} doesn't exist; check the name and the folder")
    if not path.is_file():
        raise UnreadablePhoto(f"{path} is not an ordinary file; copy the photo to a file first")
    if path.stat().st_size == 0:
        raise UnreadablePhoto(f"{path} is empty (0 bytes); copy it again from where it came")
    return path


def _read_open(file: IO[bytes], path: Path, max_megapixels: float, bits: int) -> Photo:
    stamp = Stamp.of(os.fstat(file.fileno()))
    with _own_limits(), hushed() as said:
        try:
            if READ_ONLY.get(path.suffix.lower()) == "RAW":
                photo = _read_raw(file, path, max_megapixels, bits)
            elif heif.is_heif(file):
                photo = _read_heif(file, path, max_megapixels, bits)
            elif tiff.is_tiff(file, path):
                photo = _read_tiff(file, path, max_megapixels)
            else:
                photo = _read_common(file, path, max_megapixels)
            photo = dataclasses.replace(photo, stamp=stamp, extras=extras.found(photo, file))
        except UnreadablePhoto:
            raise
        except UnidentifiedImageError:
            if contents.is_rare_jpeg(file):
                raise _rare(path) from None
            raise UnreadablePhoto(
                f"{path} is not a JPEG, PNG, TIFF, WebP, HEIC or raw photo; convert it to one of "
                "them first"
            ) from None
        except MemoryError:
            raise UnreadablePhoto(
                f"{path} doesn't fit into memory; make it smaller or close other programs"
            ) from None
        except Exception as error:  # decoders raise almost anything on damaged files
            raise UnreadablePhoto(
                f"{path} is damaged or incomplete; copy it again from where it came"
            ) from error
    photo.pixels.setflags(write=False)
    notes = (*photo.notes, *(f"the file is slightly damaged: {one}" for one in said[:1]))
    return dataclasses.replace(photo, notes=notes)


def _rare(path: Path) -> UnreadablePhoto:
    return UnreadablePhoto(
        f"{path} is a JPEG of a rare kind (hierarchical, or deeper than 8 bits); save it as an "
        "ordinary JPEG or as PNG first"
    )


@contextmanager
def _own_limits() -> Iterator[None]:
    # Our limit replaces Pillow's, which is global state.
    with _LOCK:
        limit, Pillow.MAX_IMAGE_PIXELS = Pillow.MAX_IMAGE_PIXELS, None
        try:
            yield
        finally:
            Pillow.MAX_IMAGE_PIXELS = limit


def _rounded(megapixels: float) -> str:
    return f"{megapixels:.0f}" if megapixels >= 1.0 else f"{megapixels:.2g}"


def _check_size(path: Path, width: int, height: int, max_megapixels: float) -> None:
    megapixels = width * height / 1e6
    if megapixels > max_megapixels:
        raise UnreadablePhoto(
            f"{path} is {width} x {height} px, {_rounded(megapixels)} megapixels; the limit is "
            f"{max_megapixels:g}: raise --max-megapixels on the command line if it is genuine, "
            "or make it smaller"
        )


def _read_common(file: IO[bytes], path: Path, max_megapixels: float) -> Photo:
    with Pillow.open(file, formats=_COMMON) as image:
        _check_size(path, *image.size, max_megapixels)
        jpeg = contents.jpeg_coding(image)
        deep_png = deep.is_16_bit_png(image, file)
        if deep_png:
            deep.verify_png(file)
        elif jpeg is not None:
            jpeg_data.check(file, path)
        decoded, damage = _decoded(image, file, path)
        contents.settle_profile(decoded, file)
        notes: tuple[str, ...] = ()
        if deep_png:
            pixels = deep.decode(_all_of(file))
        else:
            pixels, image.info["icc_profile"], notes = colour.to_array(decoded)
        blocks = contents.blocks(image, file, 1 if pixels.ndim == 2 else pixels.shape[2])
        turn = metadata.orientation(blocks["exif"], blocks["xmp"])
        return Photo(
            turn_upright(pixels, turn),
            path,
            _format_of(image),
            **blocks,
            **contents.density(image),
            orientation=turn,
            jpeg=jpeg if not notes else None,
            lossless_webp=riff.is_lossless(file),
            notes=(*damage, *notes),
        )


def _decoded(
    image: Pillow.Image, file: IO[bytes], path: Path
) -> tuple[Pillow.Image, tuple[str, ...]]:
    """Decode an open picture; return it, or what a JPEG without its end holds, and a note."""
    try:
        image.load()  # PNG metadata may follow the pixels, so even where OpenCV decodes them
    except OSError:
        if not isinstance(image, JpegImagePlugin.JpegImageFile):
            raise
        if contents.is_rare_jpeg(file):
            raise _rare(path) from None
        whole = jpeg_data.without_end(_all_of(file))
        if whole is None:
            raise
        return whole, ("the file is slightly damaged: its end marker is missing",)
    return image, ()


def _read_tiff(file: IO[bytes], path: Path, max_megapixels: float) -> Photo:
    tags = tiff.TiffTags.read(file)
    _check_size(path, tags.width, tags.height, max_megapixels)
    tags.check_whole(os.fstat(file.fileno()).st_size)
    notes: tuple[str, ...] = ()
    profile = tags.icc_profile
    # Both decoders turn TIFF pixels upright themselves. OpenCV's takes damaged 8-bit strips for
    # good, so Pillow's is asked where it can.
    tags.check_compression(path)
    if tags.is_deep:
        tags.check_layout(path)
        pixels = tags.decode(_all_of(file))
    else:
        file.seek(0)
        with Pillow.open(file, formats=["TIFF"]) as image:
            image.load()
            pixels, profile, notes = colour.to_array(image)
    return Photo(
        np.ascontiguousarray(pixels),
        path,
        "TIFF",
        icc_profile=profile,
        exif=tags.exif,
        xmp=tags.xmp,
        dpi=contents.dpi(tags.dpi),
        aspect=contents.aspect(tags.aspect),
        orientation=tags.orientation,
        photoshop=tags.photoshop,
        notes=notes,
    )


def _read_heif(file: IO[bytes], path: Path, max_megapixels: float, bits: int) -> Photo:
    image = heif.opened(file, path, bits)
    width, height = image.size
    _check_size(path, width, height, max_megapixels)
    return Photo(path=path, format="HEIF", **heif.contents(image))


def _read_raw(file: IO[bytes], path: Path, max_megapixels: float, bits: int) -> Photo:
    def check(width: int, height: int) -> None:
        _check_size(path, width, height, max_megapixels)

    return Photo(path=path, format="RAW", **raw.developed(file, path, bits, check))


def _all_of(file: IO[bytes]) -> bytes:
    file.seek(0)
    return file.read()


def _format_of(image: Pillow.Image) -> Format:
    # MPO is what phones call a JPEG followed by a depth or gain map.
    return "JPEG" if isinstance(image, JpegImagePlugin.JpegImageFile) else _as_format(image.format)


def _as_format(name: str | None) -> Format:
    return next(known for known in _COMMON if known == name)
