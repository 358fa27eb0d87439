"""Kinds of data in a photo file other than pixels.

`formats` defines the treatment of each kind. The table in `docs/fidelity.md` lists all kinds, with
their signatures in files. The readers of all formats report extras by kind, and `write` reports
lost kinds.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Final

from kogao_core.base.language import Text


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of data in a photo file other than pixels."""

    name: Text  # for notes, in photographers' words
    # Whether to report the loss of this kind. False: the kind tells only of other content.
    is_reported: bool = True


@dataclass(frozen=True, slots=True)
class Extra:
    """An item in a file: a kind, with an optional specific name."""

    kind: Kind
    more: str = ""
    data: bytes = b""  # data after the picture that a changed photo can preserve

    @property
    def name(self) -> str:
        return self.more or self.kind.name


def grouped(form: str, found: Iterable[tuple[Kind | None, str]]) -> Iterator[Extra]:
    """Yield an extra for each kind of chunks, with the names of chunks that have no other name."""
    names: dict[Kind, dict[str, None]] = {}
    for kind, name in found:
        if kind is not None:
            names.setdefault(kind, {})[name] = None
    for kind, members in names.items():
        listed = Text("{format} chunks {names}", format=form, names=" ".join(members))
        yield Extra(kind, listed if kind in _LISTED else "")


EXIF: Final = Kind(Text("EXIF with GPS"))
EXIF_TAGS: Final = Kind(Text("EXIF tags"))
MAKER_NOTE: Final = Kind(Text("the maker's note"))
MOVED_NOTE: Final = Kind(Text("the maker's note of a TIFF or raw photo"))
THUMBNAIL: Final = Kind(Text("thumbnails"), is_reported=False)
XMP: Final = Kind(Text("XMP"))
XMP_EXTENSION: Final = Kind(Text("the extended XMP"))
SECOND_XMP: Final = Kind(Text("a second XMP packet"))
PHOTOSHOP_XMP: Final = Kind(Text("the XMP among Photoshop's resources"))
SECOND_EXIF: Final = Kind(Text("a second EXIF block"))
PLACES: Final = Kind(Text("positions in the unrotated picture"))
IPTC: Final = Kind(Text("the IPTC record"))
ICC: Final = Kind(Text("the colour profile"))
GREY_PROFILE: Final = Kind(Text("grey with its colour profile"))
SECOND_PROFILE: Final = Kind(Text("a second colour profile"))
RESOLUTION: Final = Kind(Text("the print resolution"))
ASPECT: Final = Kind(Text("the pixel aspect ratio"))
ADOBE: Final = Kind(Text("Adobe's colour coding"), is_reported=False)
COMMENTS: Final = Kind(Text("comments"))
SEGMENTS: Final = Kind(Text("makers' segments"))
PREVIEW: Final = Kind(Text("a maker's segment with a preview"))
JUMBF: Final = Kind(Text("JUMBF data"))
TEXTS: Final = Kind(Text("PNG texts"))
COLOURS: Final = Kind(Text("gamma and colours without a profile"))
RARE_COLOURS: Final = Kind(Text("the name of rare colours"))
CHUNKS: Final = Kind(Text("PNG chunks"))
UNSAFE_CHUNKS: Final = Kind(Text("PNG chunks that depend on the old pixels"))
RIFF_CHUNKS: Final = Kind(Text("WebP chunks"))
LAYERS: Final = Kind(Text("Photoshop layers"))
TIFF_TAGS: Final = Kind(Text("TIFF tags"))
CHANNELS: Final = Kind(Text("extra channels"))
GAIN_MAP: Final = Kind(Text("the HDR gain map"))
JPEG_HDR: Final = Kind(Text("the ratio image of JPEG-HDR"))
VIDEO: Final = Kind(Text("the motion photo's video"))
DEPTH: Final = Kind(Text("the depth map or portrait matte"))
ORIGINAL: Final = Kind(Text("the picture inside the XMP"))
FURTHER: Final = Kind(Text("further pictures"))
CREDENTIALS: Final = Kind(Text("content credentials (C2PA)"))
CREDENTIALS_LINK: Final = Kind(Text("a link to content credentials (C2PA)"))
SAMSUNG: Final = Kind(Text("Samsung's data at the end"))
PHOTO_MECHANIC: Final = Kind(Text("Photo Mechanic's data at the end"))
FOTOSTATION: Final = Kind(Text("FotoStation's data at the end"))
UNKNOWN: Final = Kind(Text("unknown data"))
INDEX: Final = Kind(Text("indexes of omitted data"), is_reported=False)

_LISTED: Final = (CHUNKS, UNSAFE_CHUNKS, RIFF_CHUNKS, UNKNOWN)
RECORDS: Final = (SAMSUNG, PHOTO_MECHANIC, FOTOSTATION)
"""What programs put behind a picture, which tells of itself alone."""
