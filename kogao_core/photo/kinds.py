"""The kinds of things that a file holds beside its pixels, and what becomes of each.

This is the table of `docs/fidelity.md`. The readers of all formats name what they find by these
kinds, and `write` says what an output doesn't keep.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

if TYPE_CHECKING:
    from kogao_core.photo.model import Format

Fate = Literal["kept", "moved", "left out"]


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of thing beside the pixels.

    Parameters
    ----------
    name : str
        In a photographer's words, as notes say it.
    seen : str
        How it is recognised.
    jpeg, png, tiff, webp : {"kept", "moved", "left out"}
        What becomes of it in a changed photo of that format.
    why : str
        Why it isn't kept.
    is_said : bool
        Whether a note names it where it isn't kept; not, where only copies of the picture or of
        what else is in the file go.
    """

    name: str
    seen: str
    jpeg: Fate = "left out"
    png: Fate = "left out"
    tiff: Fate = "left out"
    webp: Fate = "left out"
    why: str = ""
    is_said: bool = True

    def fate(self, form: Format) -> Fate:
        """Return what becomes of it in a format."""
        return {"JPEG": self.jpeg, "PNG": self.png, "TIFF": self.tiff, "WEBP": self.webp}[form]


@dataclass(frozen=True, slots=True)
class Extra:
    """Something that a file holds: its kind, and words that tell it more exactly."""

    kind: Kind
    more: str = ""

    @property
    def name(self) -> str:
        """What a note calls it."""
        return self.more or self.kind.name


_OLD_FACE: Final = "shows the face as it was"
_UNKNOWN: Final = "may tell of the face as it was, or of places in the file"

EXIF: Final = Kind("EXIF with GPS", "APP1, `eXIf`, tag 34665", "kept", "kept", "kept", "kept")
EXIF_TAGS: Final = Kind(
    "EXIF tags", "rare numbers in the first directory of an EXIF block",
    "kept", "kept", "left out", "kept", "in a TIFF they would be its own",
)  # fmt: skip
MAKER_NOTE: Final = Kind(
    "the maker's note", "EXIF tag 37500", "kept", "kept", "moved", "kept",
    "the directory of a TIFF is written anew",
)  # fmt: skip
MOVED_NOTE: Final = Kind(
    "the maker's note of a TIFF or raw photo", "EXIF tag 37500", "moved", "moved", "moved", "moved",
    "the directory is written anew",
)  # fmt: skip
THUMBNAIL: Final = Kind(
    "thumbnails", "IFD1, `JFXX`, Photoshop resources 1033 and 1036, `xmp:Thumbnails`, HEIC's",
    why=_OLD_FACE, is_said=False,
)  # fmt: skip
XMP: Final = Kind("XMP", "APP1, `iTXt`, tag 700, `XMP `", "kept", "kept", "kept", "kept")
XMP_EXTENSION: Final = Kind(
    "the extended XMP", "APP1 `xmp/extension`", "kept", why="no place in other formats"
)
SECOND_XMP: Final = Kind("a second XMP packet", "APP1, more than once", why="one is read")
IPTC: Final = Kind(
    "the IPTC record", "APP13, raw profile, tags 33723 and 34377", "kept", "kept", "kept",
    why="no place in WebP",
)  # fmt: skip
ICC: Final = Kind("the colour profile", "APP2, `iCCP`, tag 34675", "kept", "kept", "kept", "kept")
GREY_PROFILE: Final = Kind(
    "grey with its colour profile", "a profile beside grey pixels", "kept", "kept", "kept",
    why="grey becomes RGB",
)  # fmt: skip
SECOND_PROFILE: Final = Kind(
    "a second colour profile", "APP2, a second series", why="the first whole one counts"
)
RESOLUTION: Final = Kind(
    "the print resolution", "JFIF, `pHYs`, tag 282", "kept", "kept", "kept", why="no place in WebP"
)
ASPECT: Final = Kind(
    "the pixels' shape", "JFIF, `pHYs` or tag 296 without a unit, HEIC `pasp`",
    "kept", "kept", "kept", why="no place in WebP",
)  # fmt: skip
COMMENTS: Final = Kind("comments", "JPEG `COM`", "kept", why="a segment of JPEG's")
SEGMENTS: Final = Kind(
    "makers' segments", "JPEG APP0 to APP15, unknown", "kept", why="segments of JPEG's"
)
PREVIEW: Final = Kind("a maker's segment with a preview", "APPn that holds a JPEG", why=_OLD_FACE)
LATE_SEGMENTS: Final = Kind(
    "comments or segments between the scans", "`COM`, APPn after the first scan", why="rare"
)
JUMBF: Final = Kind("JUMBF data", "APP11 `JP` without C2PA", why=_UNKNOWN)
TEXTS: Final = Kind("PNG texts", "`tEXt`, `zTXt`, `iTXt`", png="kept", why="PNG's own")
COLOURS: Final = Kind(
    "gamma and colours without a profile", "`gAMA`, `cHRM`, `cICP`, `mDCV`, `cLLI`", png="kept",
    why="PNG's own",
)  # fmt: skip
CHUNKS: Final = Kind(
    "PNG chunks", "`sBIT`, `bKGD`, `oFFs`, `sTER`, `sCAL`, any that are safe to copy", png="kept",
    why="PNG's own",
)  # fmt: skip
UNSAFE_CHUNKS: Final = Kind(
    "PNG chunks that hang on the old pixels", "`tIME`, `hIST`, any that aren't safe to copy",
    why="PNG's rule for copying",
)  # fmt: skip
RIFF_CHUNKS: Final = Kind("WebP chunks", "unknown chunks", why=_UNKNOWN)
LAYERS: Final = Kind("Photoshop layers", "TIFF tag 37724", why=_OLD_FACE)
TIFF_TAGS: Final = Kind("TIFF tags", "private and rare tags", why=_UNKNOWN)
CHANNELS: Final = Kind("extra channels", "more samples than colours and alpha", why="not read")
GAIN_MAP: Final = Kind(
    "the HDR gain map",
    "`hdrgm:` or Apple's `HDRGainMap:` in XMP, ISO 21496-1 in APP2, JPEG-HDR, HEIC auxiliary",
    why=_OLD_FACE,
)
VIDEO: Final = Kind(
    "the motion photo's video", "`MotionPhoto`, `MicroVideo` in XMP, an MP4 at the end, `mpvd`",
    why=_OLD_FACE,
)  # fmt: skip
DEPTH: Final = Kind(
    "the depth map or portrait matte", "`GDepth:`, Dynamic Depth, HEIC auxiliary", why=_OLD_FACE
)
ORIGINAL: Final = Kind("the picture kept inside the XMP", "`GImage:`", why=_OLD_FACE)
FURTHER: Final = Kind(
    "further pictures", "MPF, pages, frames, sub-directories, HEIC", why="one picture is read"
)
CREDENTIALS: Final = Kind(
    "content credentials (C2PA)", "APP11, `caBX`, tag 52545, `C2PA`, `uuid`; `dcterms:provenance`",
    why="no changed photo fulfils them",
)  # fmt: skip
SAMSUNG: Final = Kind("Samsung's data at the end", "`SEFT`, `sefd`", why=_UNKNOWN)
AFCP: Final = Kind("AFCP data at the end", "`AXS!`, `AXS*`", why="hangs on places in the file")
PHOTO_MECHANIC: Final = Kind("Photo Mechanic's data at the end", "`cbipcbbl`", why=_UNKNOWN)
FOTOSTATION: Final = Kind("FotoStation's data at the end", "`A1B2C3D4`", why=_UNKNOWN)
UNKNOWN: Final = Kind("unknown data", "anything else after the end of the picture", why=_UNKNOWN)
INDEX: Final = Kind(
    "indexes of what isn't kept", "`MPF`, `Container:Directory`, `HasExtendedXMP`, `iDOT`",
    why="would tell of what is gone", is_said=False,
)  # fmt: skip

KINDS: Final = tuple(value for value in list(globals().values()) if isinstance(value, Kind))


def not_kept(extras: Iterable[Extra], form: Format) -> str:
    """Return what an output of that format doesn't keep, in one line and in the order found."""
    lost: dict[str, None] = {}
    moved = False
    for extra in extras:
        fate = extra.kind.fate(form)
        moved |= fate == "moved"
        if fate == "left out" and extra.kind.is_said:
            lost[extra.name] = None
    said = [f"not kept: {', '.join(lost)}"] if lost else []
    if moved:
        said.append("the maker's note has moved: programs may miss parts of it")
    return "; ".join(said)
