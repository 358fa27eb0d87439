"""What else is in a photo's file: one reader for all formats, by the table in `kinds`."""

from __future__ import annotations

from collections.abc import Iterator
from typing import IO

from PIL import Image as Pillow

from kogao_core.base.language import Text
from kogao_core.photo import formats
from kogao_core.photo.metadata import kinds, stale, tiff_extras
from kogao_core.photo.metadata.kinds import Extra, Kind
from kogao_core.photo.model import Photo


def found(photo: Photo, file: IO[bytes]) -> tuple[Extra, ...]:
    """Return what an open file holds beside pixels, profile, EXIF, XMP, IPTC and resolution.

    Result: in the order things are found; each of them once.
    """
    form = formats.BY_NAME[photo.format]
    seen = [*photo.extras, *form.inside(photo, file), *_from_metadata(photo, form.note)]
    if form.behind is not None:
        file.seek(0)
        seen += form.behind(file)
    return tuple(dict.fromkeys(seen))


def _from_metadata(photo: Photo, note: Kind | None) -> Iterator[Extra]:
    """Yield the extras that the metadata blocks name."""
    yield from map(Extra, stale.found(photo.xmp) if photo.xmp else ())
    if photo.exif is None:
        return
    tags = Pillow.Exif()
    try:
        tags.load(photo.exif)
        has_note = tiff_extras.has_maker_note(tags)
    except Exception:  # a damaged block, which is kept as it is
        return
    if note is not None and has_note:
        yield Extra(note)
    if note is kinds.MAKER_NOTE and (rare := tiff_extras.rare_tags(tags)):
        yield Extra(kinds.EXIF_TAGS, Text("EXIF tags {tags}", tags=" ".join(map(str, rare))))
