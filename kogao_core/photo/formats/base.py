"""A file format as one value."""

from __future__ import annotations

import io
from collections.abc import Callable, Container, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any, Final, Literal

from PIL import Image as Pillow

from kogao_core.base.atomic import Chunks
from kogao_core.base.geometry import Box, Image
from kogao_core.base.language import Text
from kogao_core.photo.metadata import kinds
from kogao_core.photo.metadata.kinds import Extra, Kind
from kogao_core.photo.model import Photo, channels_of

Encode = Callable[[Photo, Box | None], Chunks]
Fate = Literal["kept", "on request", "moved", "left out"]
# BLOCKS: preserved by JPEG, PNG, WebP and AVIF. OF_PRINTS: preserved by JPEG, PNG and TIFF.
BLOCKS: Final = frozenset(
    {kinds.EXIF, kinds.EXIF_TAGS, kinds.MAKER_NOTE, kinds.THUMBNAIL, kinds.XMP, kinds.ICC}
)
OF_PRINTS: Final = frozenset({kinds.IPTC, kinds.GREY_PROFILE, kinds.RESOLUTION, kinds.ASPECT})


@dataclass(frozen=True, slots=True)
class Source:
    """A file to read a photo from."""

    file: IO[bytes]  # open, at its start
    path: Path  # for messages
    bits: int  # requested bit depth, if the decoder has a choice
    # Size check to call before decoding: width and height in px, and bytes per pixel.
    check: Callable[[int, int, int], None]

    def data(self) -> bytes:
        """Return the content of the file."""
        self.file.seek(0)
        return self.file.read()


@dataclass(frozen=True, slots=True)
class Content:
    """Pixels and metadata to write."""

    photo: Photo  # the source, for the compression settings
    # (H, W) or (H, W, C), in a depth and layout of the format; an unsupported alpha channel is
    # allowed.
    pixels: Image
    blocks: dict[str, Any]  # metadata by Pillow's names; None for a missing block
    resources: bytes | None = None  # photoshop image resources
    carried: tuple[bytes, ...] = ()  # segments or chunks of the source, if it is of the same format
    # Whether the source is lossless. The output must then be lossless too.
    is_lossless: bool = False
    quality: int = 0  # lossy quality, 1 to 100; 0 uses the source's or the format's default

    def saved(self, form: str, **options: Any) -> bytes:
        """Encode pixels and blocks with Pillow. Return the file content."""
        known = {name: block for name, block in self.blocks.items() if block is not None}
        with io.BytesIO() as out:
            Pillow.fromarray(self.pixels).save(out, form, **known, **options)
            return out.getvalue()


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class FileFormat:
    """A file format: properties, decoder, encoder and supported metadata."""

    name: str  # value of `Photo.format`; Pillow's name for formats that Pillow reads
    title: str  # name for messages
    suffixes: tuple[str, ...]  # file extensions, the usual extension first
    is_lossless: bool  # whether every file of this format stores the pixels exactly
    # Yields the extras of an open file: all content except pixels and metadata blocks.
    inside: Callable[[Photo, IO[bytes]], Iterator[Extra]]
    # Returns the pieces of a file. None for a read-only format.
    encode: Callable[[Content], Chunks] | None = None
    # Supported channel counts by dtype name: 1 is grey, 2 grey + alpha, 3 RGB, 4 RGBA. Empty for a
    # read-only format.
    layouts: Mapping[str, tuple[int, ...]] = field(default_factory=dict)
    longest_side_px: int | None = None  # maximum length of a side
    deep_bits: int = 16  # stored bits per channel of uint16 pixels
    # Whether the format names PQ and HLG colours. Other formats get tone-mapped pixels.
    holds_hdr: bool = False
    # Kinds preserved in a changed photo, kinds stored at another file offset, and kinds preserved
    # on request (`Photo.companions`). All other kinds are left out.
    kept: frozenset[Kind] = frozenset()
    moved: frozenset[Kind] = frozenset({kinds.MOVED_NOTE})
    companions: frozenset[Kind] = frozenset()
    # Detects this format and rewinds the file; decodes a file. None: Pillow does.
    recognises: Callable[[IO[bytes], Path], bool] | None = None
    decode: Callable[[Source], Photo] | None = None
    # Yields the extras after the end of the picture. The file must be at its start.
    behind: Callable[[IO[bytes]], Iterator[Extra]] | None = None
    note: Kind = kinds.MAKER_NOTE  # kind of a maker's note in EXIF
    # Returns False for an EXIF block too damaged for this format.
    holds_exif: Callable[[bytes], bool] = lambda _: True
    # Whether saving in this format preserves the stored orientation and EXIF's orientation tag.
    keeps_turn: bool = False
    # Called with a photo of this format, new pixels, an encoder for a region (photo, and a `Box` or
    # None for all) and the output path. Returns the file with the preserved data, and a note. None:
    # the format always re-encodes the whole picture.
    keep: Callable[[Photo, Image, Encode, Path], tuple[Chunks, str]] | None = None

    def holds_alpha(self, depth: str) -> bool:
        """Return True if the format can store an alpha channel with this dtype."""
        return 4 in self.layouts.get(depth, ())

    def becomes_colour(self, pixels: Image) -> bool:
        """Return True if the pixels are grey and the format can store only RGB."""
        depth, channels = pixels.dtype.name, channels_of(pixels)
        if channels > 2:
            return False
        wanted = channels if self.holds_alpha(depth) else 1
        return wanted not in self.layouts[depth]

    def fate(self, kind: Kind) -> Fate:
        """Return the treatment of a kind of data in a changed photo of this format."""
        if kind is kinds.VIDEO and kind in self.companions:
            return "on request"
        if kind in self.companions:
            return "kept"
        if kind in self.kept:
            return "kept"
        # A maker's note can move only within EXIF.
        return "moved" if kind in self.moved and kinds.EXIF in self.kept else "left out"

    def turns(self, photo: Photo, *, is_export: bool = False) -> bool:
        """Return True if saving in this format rotates the stored pixels."""
        lies = self.keeps_turn and photo.format == self.name and not is_export
        return photo.orientation != 1 and not lies

    def not_kept(
        self,
        photo: Photo,
        extras: Iterable[Extra],
        along: Container[Kind] = (),
        *,
        is_export: bool = False,
    ) -> str:
        """Return a note about the extras that are lost when saving, in file order.

        `along`: the companions to copy. `is_export`: the whole picture is re-encoded.
        """
        turns = self.turns(photo, is_export=is_export)
        lost: dict[str, None] = {}
        moved = has_note = False
        for extra in extras:
            gone = extra.kind in self.companions and extra.kind not in along
            is_behind = photo.format == self.name and not is_export and kinds.VIDEO not in along
            gone |= extra.kind in kinds.RECORDS and not is_behind
            gone |= extra.kind is kinds.PLACES and turns
            is_converted = photo.jpeg is None and extra.kind in (kinds.SECOND_PROFILE, kinds.ADOBE)
            gone |= is_converted
            fate = "left out" if gone else self.fate(extra.kind)
            moved |= fate == "moved"
            has_note |= extra.kind in (kinds.MAKER_NOTE, kinds.MOVED_NOTE)
            if fate == "left out" and (extra.kind.is_reported or is_converted):
                lost[extra.name] = None
        notes = [Text("not kept: {lost}", lost=Text.joined(", ", lost))] if lost else []
        if moved:
            notes.append(Text("the maker's note has moved: programs may miss parts of it"))
        if has_note and turns:
            notes.append(Text("positions in the maker's note are those of the unrotated picture"))
        return Text.joined("; ", notes)
