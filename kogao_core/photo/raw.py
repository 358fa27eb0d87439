"""Raw photos of cameras, developed by LibRaw: read, but never written."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path
from typing import IO, Any

from PIL import ImageCms

from kogao_core.photo import tiff
from kogao_core.photo.errors import UnreadablePhoto


def developed(
    file: IO[bytes], path: Path, bits: int, check: Callable[[int, int], None]
) -> dict[str, Any]:
    """Return pixels in sRGB, upright, as the camera balanced them, and metadata; see `Photo`.

    Parameters
    ----------
    file : file
        Open, at its start.
    path : Path
        For messages.
    bits : {8, 16}
        How deep.
    check : callable
        Called with the width and height in px before anything is developed.

    Raises
    ------
    UnreadablePhoto
        If LibRaw isn't installed or doesn't know the file.
    """
    try:
        import rawpy
    except ImportError:
        raise UnreadablePhoto(
            f"{path} is a raw photo; to read it, install the extra: pip install 'kogao[raw]'"
        ) from None
    data = file.read()
    try:
        with rawpy.imread(io.BytesIO(data)) as raw:
            check(raw.sizes.iwidth, raw.sizes.iheight)
            pixels = raw.postprocess(
                use_camera_wb=True,
                output_bps=bits,
                no_auto_bright=True,
                output_color=rawpy.ColorSpace.sRGB,
            )
    except rawpy.LibRawFileUnsupportedError:
        raise UnreadablePhoto(
            f"{path} is no raw photo that LibRaw knows; develop it elsewhere and open the result"
        ) from None
    profile = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    note = f"developed to {bits} bits with the camera's white balance"
    blocks = {"pixels": pixels, "icc_profile": profile}
    if not data.startswith(tiff.HEADS):
        return {**blocks, "notes": (f"{note}; its metadata are of a kind that isn't kept",)}
    tags = tiff.TiffTags.read(io.BytesIO(data))
    return {**blocks, "exif": tags.exif, "xmp": tags.xmp, "notes": (note,)}
