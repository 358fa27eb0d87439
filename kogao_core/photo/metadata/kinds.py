"""Kinds of data in a photo file other than pixels.

`formats` defines the treatment of each kind. The table in `docs/fidelity.md` lists all kinds. The
readers of all formats report extras by kind, and `write` reports lost kinds.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from kogao_core.base.language import Text


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of data in a photo file other than pixels."""

    name: Text  # for notes, in photographers' words
    seen: str  # signature in the file, for the documentation
    why: str = ""  # the reason for leaving out this kind
    # Whether to report the loss of this kind. False: only copies of other content are lost.
    is_reported: bool = True


@dataclass(frozen=True, slots=True)
class Extra:
    """An item in a file: a kind, with an optional specific name."""

    kind: Kind
    more: str = ""
    data: bytes = b""  # data between scans or after the picture that a changed photo can preserve

    @property
    def name(self) -> str:
        """Name for notes."""
        return self.more or self.kind.name


_OLD_FACE: Final = "shows the face as it was"
_UNKNOWN: Final = "may tell of the face as it was, or of places in the file"

EXIF: Final = Kind(Text("EXIF with GPS"), "APP1, `eXIf`, tag 34665")
EXIF_TAGS: Final = Kind(
    Text("EXIF tags"),
    "rare numbers in the first directory of an EXIF block",
    "in a TIFF they would be its own",
)
MAKER_NOTE: Final = Kind(
    Text("the maker's note"), "EXIF tag 37500", "the directory of a TIFF is written anew"
)
MOVED_NOTE: Final = Kind(
    Text("the maker's note of a TIFF or raw photo"),
    "EXIF tag 37500",
    "the directory is written anew",
)
THUMBNAIL: Final = Kind(
    Text("thumbnails"),
    "IFD1, `JFXX`, Photoshop resources 1033 and 1036, `xmp:Thumbnails`, HEIC's",
    "EXIF's is made anew of the result; the others show the face as it was",
    is_reported=False,
)
XMP: Final = Kind(Text("XMP"), "APP1, `iTXt`, tag 700, `XMP `")
XMP_EXTENSION: Final = Kind(
    Text("the extended XMP"), "APP1 `xmp/extension`", "no place in other formats"
)
SECOND_XMP: Final = Kind(Text("a second XMP packet"), "APP1, more than once", "a segment of JPEG's")
PHOTOSHOP_XMP: Final = Kind(
    Text("the XMP among Photoshop's resources"),
    "resource 1060, unless it equals the XMP packet",
    "a copy that programs read instead of the XMP packet would be out of date",
)
SECOND_EXIF: Final = Kind(
    Text("a second EXIF block"),
    "APP1 `Exif` with a TIFF header, more than once",
    "programs read the first; its thumbnail shows the face as it was",
)
PLACES: Final = Kind(
    Text("places in the picture as it lay"),
    "Lightroom's crops, masks and spots, ACDSee's, IPTC's and panoramas' regions, Photoshop's "
    "paths, guides and slices, where a photo is turned upright",
    "would point elsewhere; a JPEG from a JPEG lies as it lay",
)
IPTC: Final = Kind(
    Text("the IPTC record"), "APP13, raw profile, tags 33723 and 34377", "no place in WebP or AVIF"
)
ICC: Final = Kind(Text("the colour profile"), "APP2, `iCCP`, tag 34675")
GREY_PROFILE: Final = Kind(
    Text("grey with its colour profile"), "a profile beside grey pixels", "grey becomes RGB"
)
SECOND_PROFILE: Final = Kind(
    Text("a second colour profile"), "APP2, a second series", "segments of JPEG's"
)
RESOLUTION: Final = Kind(
    Text("the print resolution"), "JFIF, `pHYs`, tag 282", "no place in WebP or AVIF"
)
ASPECT: Final = Kind(
    Text("the pixels' shape"),
    "JFIF, `pHYs` or tag 296 without a unit, HEIC `pasp`",
    "no place in WebP or AVIF",
)
COMMENTS: Final = Kind(Text("comments"), "JPEG `COM`", "a segment of JPEG's")
SEGMENTS: Final = Kind(
    Text("makers' segments"), "JPEG APP0 to APP15, unknown", "segments of JPEG's"
)
PREVIEW: Final = Kind(
    Text("a maker's segment with a preview"), "APPn that holds a picture or film", _OLD_FACE
)
LATE_SEGMENTS: Final = Kind(
    Text("comments or segments between the scans"),
    "`COM`, unknown APPn after the first scan",
    "segments of JPEG's; there they lie ahead of the one scan",
)
JUMBF: Final = Kind(
    Text("JUMBF data"), "APP11 `JP`: JSON, XML or CBOR without C2PA", "a segment of JPEG's"
)
TEXTS: Final = Kind(Text("PNG texts"), "`tEXt`, `zTXt`, `iTXt`", "PNG's own")
COLOURS: Final = Kind(
    Text("gamma and colours without a profile"),
    "`gAMA`, `cHRM`, `cICP`, `mDCV`, `cLLI`",
    "PNG's own",
)
CHUNKS: Final = Kind(
    Text("PNG chunks"),
    "`sBIT`, `bKGD`, `oFFs`, `sTER`, `sCAL`, any that are safe to copy",
    "PNG's own",
)
UNSAFE_CHUNKS: Final = Kind(
    Text("PNG chunks that hang on the old pixels"),
    "`tIME`, `hIST`, any that aren't safe to copy",
    "PNG's rule for copying",
)
RIFF_CHUNKS: Final = Kind(
    Text("WebP chunks"), "unknown chunks without a picture in them", "WebP's own"
)
LAYERS: Final = Kind(Text("Photoshop layers"), "TIFF tag 37724", _OLD_FACE)
TIFF_TAGS: Final = Kind(
    Text("TIFF tags"), "private and rare tags of texts and numbers", "TIFF's own"
)
CHANNELS: Final = Kind(Text("extra channels"), "more samples than colours and alpha", "not read")
GAIN_MAP: Final = Kind(
    Text("the HDR gain map"),
    "a JPEG behind the picture with `hdrgm:`, ISO 21496-1 or Apple's `HDRGainMap:`; HEIC and "
    "AVIF: auxiliary, `tmap`",
    "warped with the photo; no place in other formats",
)
JPEG_HDR: Final = Kind(Text("JPEG-HDR's picture of ratios"), "APP11 `HDR_RI`", _OLD_FACE)
VIDEO: Final = Kind(
    Text("the motion photo's video"),
    "`MotionPhoto`, `MicroVideo` in XMP, an MP4 at the end, `mpvd`",
    _OLD_FACE,
)
DEPTH: Final = Kind(
    Text("the depth map or portrait matte"), "`GDepth:`, Dynamic Depth, HEIC auxiliary", _OLD_FACE
)
ORIGINAL: Final = Kind(Text("the picture kept inside the XMP"), "`GImage:`", _OLD_FACE)
FURTHER: Final = Kind(
    Text("further pictures"), "MPF, pages, frames, sub-directories, HEIC", "one picture is read"
)
CREDENTIALS: Final = Kind(
    Text("content credentials (C2PA)"),
    "APP11, `caBX`, tag 52545, `C2PA`, `uuid`",
    "they describe other pixels",
)
CREDENTIALS_LINK: Final = Kind(
    Text("a link to content credentials (C2PA)"),
    "`dcterms:provenance`",
    "they describe other pixels",
)
SAMSUNG: Final = Kind(
    Text("Samsung's data at the end"),
    "`SEFT` behind texts alone",
    "texts and numbers that a JPEG from a JPEG keeps, unless a film is behind it",
)
AFCP: Final = Kind(Text("AFCP data at the end"), "`AXS!`, `AXS*`", "hangs on places in the file")
PHOTO_MECHANIC: Final = Kind(
    Text("Photo Mechanic's data at the end"),
    "`cbipcbbl`",
    "texts and numbers that a JPEG from a JPEG keeps, unless a film is behind it",
)
FOTOSTATION: Final = Kind(
    Text("FotoStation's data at the end"),
    "`A1B2C3D4` without a picture",
    "texts and numbers that a JPEG from a JPEG keeps, unless a film is behind it",
)
UNKNOWN: Final = Kind(
    Text("unknown data"),
    "anything else after the end of the picture; tags of bytes and places, boxes, JUMBF data",
    _UNKNOWN,
)
INDEX: Final = Kind(
    Text("indexes of what isn't kept"),
    "`MPF`, `Container:Directory`, `HasExtendedXMP`, `iDOT`",
    "would tell of what is gone",
    is_reported=False,
)

RECORDS: Final = (SAMSUNG, PHOTO_MECHANIC, FOTOSTATION)
"""What programs put behind a picture, which tells of itself alone."""
