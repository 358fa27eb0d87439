"""A file format as one value."""

from __future__ import annotations

import io
from collections.abc import Callable, Container, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any, Final, Literal

from PIL import Image as Pillow

from kogao_core.base.atomic import Pieces
from kogao_core.base.geometry import Box, Image
from kogao_core.base.language import Text
from kogao_core.photo.metadata import kinds
from kogao_core.photo.metadata.kinds import Extra, Kind
from kogao_core.photo.model import Photo, channels_of

Encode = Callable[[Photo, Box | None], Pieces]
Fate = Literal["kept", "on request", "moved", "left out"]
# What JPEG, PNG, WebP and AVIF keep; what JPEG, PNG and TIFF do.
BLOCKS: Final = frozenset(
    {kinds.EXIF, kinds.EXIF_TAGS, kinds.MAKER_NOTE, kinds.THUMBNAIL, kinds.XMP, kinds.ICC}
)
OF_PRINTS: Final = frozenset({kinds.IPTC, kinds.GREY_PROFILE, kinds.RESOLUTION, kinds.ASPECT})


@dataclass(frozen=True, slots=True)
class Source:
    """A file to read a photo from."""

    file: IO[bytes]  # open, at its start
    path: Path  # where it lies, for messages
    bits: int  # how deep pixels are to be where the reader may choose
    # To be called with the width and height in px before anything is decoded.
    check: Callable[[int, int], None]

    def data(self) -> bytes:
        """Return all of the file."""
        self.file.seek(0)
        return self.file.read()


@dataclass(frozen=True, slots=True)
class Content:
    """Pixels to write and the metadata there is."""

    photo: Photo  # the source, for how it was compressed
    # (H, W) or (H, W, C): of a depth and layout that the format holds, but for alpha where it holds
    # none.
    pixels: Image
    blocks: dict[str, Any]  # by Pillow's names, None where there is none
    resources: bytes | None = None  # photoshop image resources
    carried: tuple[bytes, ...] = ()  # segments or chunks of the source, if it is of the same format
    # Whether nothing was lost in the source, so that nothing may be lost now.
    is_lossless: bool = False
    quality: int = 0  # of what loses something, 1 to 100; 0 is the source's, or the format's own

    def saved(self, form: str, **options: Any) -> bytes:
        """Return the file that Pillow makes of the pixels and blocks."""
        known = {name: block for name, block in self.blocks.items() if block is not None}
        with io.BytesIO() as out:
            Pillow.fromarray(self.pixels).save(out, form, **known, **options)
            return out.getvalue()


@dataclass(frozen=True, slots=True, eq=False)
class FileFormat:
    """A file format: all that reading, writing, messages and documents need.

    Parameters
    ----------
    name : {"JPEG", "PNG", "TIFF", "WEBP", "AVIF", "HEIF", "RAW"}
        As in `Photo.format`; Pillow's, where Pillow reads it.
    title : str
        As people say it.
    mime : str
        The type of its files, as content credentials name it.
    suffixes : tuple of str
        Endings of names, the usual one first.
    is_lossless : bool
        Whether every file of it holds its pixels exactly.
    inside : callable
        Yields what an open file of the photo holds beside pixels and metadata blocks.
    encode : callable, optional
        Given a `Content`; returns the pieces of a file. None, where it is read only.
    layouts : mapping of str to tuple of int
        Channels that can be written, by the name of the pixels' type: 1 is grey, 2 grey + alpha,
        3 RGB, 4 RGBA. Empty, where it is read only.
    longest_side_px : int, optional
        More can't be written.
    kept, moved : sets of Kind
        What a changed photo brings along, and what lies elsewhere in it; all else is left out.
    companions : set of Kind
        What a photo of this format keeps where it is accompanied by it (`Photo.companions`).
    recognises, decode : callable, optional
        Given an open file and its path, which is left at its start, whether it is of this format;
        given a `Source`, its `Photo`. None, where Pillow recognises and decodes it.
    behind : callable, optional
        Yields what follows the end of the picture in a file, open at its start.
    note : Kind, optional
        What a maker's note in its EXIF is; None, where `inside` yields it.
    lacks : callable
        Given a photo; says what of its metadata is too damaged for this format, or nothing.
    recoded : callable
        Given a photo of this format; says how it is compressed otherwise when it is written again,
        or nothing.
    keeps_turn : bool
        Whether a photo of this format lies in a file of it as it lay: EXIF's orientation stays.
    keep : callable, optional
        Given a photo of this format, new pixels, what encodes a part of them (of a photo, a `Box`,
        or None for all) and where the file goes; returns a file with as much of the photo's own as
        may stay, and what that is in words. None, where all is encoded anew.
    """

    name: str
    title: str
    mime: str
    suffixes: tuple[str, ...]
    is_lossless: bool
    inside: Callable[[Photo, IO[bytes]], Iterator[Extra]]
    encode: Callable[[Content], Pieces] | None = None
    layouts: Mapping[str, tuple[int, ...]] = field(default_factory=dict)
    longest_side_px: int | None = None
    kept: frozenset[Kind] = frozenset()
    moved: frozenset[Kind] = frozenset({kinds.MOVED_NOTE})
    companions: frozenset[Kind] = frozenset()
    recognises: Callable[[IO[bytes], Path], bool] | None = None
    decode: Callable[[Source], Photo] | None = None
    behind: Callable[[IO[bytes]], Iterator[Extra]] | None = None
    note: Kind | None = kinds.MAKER_NOTE
    lacks: Callable[[Photo], str] = lambda _: ""
    recoded: Callable[[Photo], str] = lambda _: ""
    keeps_turn: bool = False
    keep: Callable[[Photo, Image, Encode, Path], tuple[Pieces, str]] | None = None

    def __post_init__(self) -> None:
        if bool(self.layouts) != (self.encode is not None):
            raise TypeError(f"{self.name} needs both an encoder and the layouts it writes")

    def holds_alpha(self, depth: str) -> bool:
        """Tell whether transparency can be written beside channels of that type."""
        return 4 in self.layouts.get(depth, ())

    def becomes_colour(self, pixels: Image) -> bool:
        """Tell whether pixels are grey and no such grey can be written."""
        depth, channels = pixels.dtype.name, channels_of(pixels)
        if channels > 2:
            return False
        wanted = channels if self.holds_alpha(depth) else 1
        return wanted not in self.layouts[depth]

    def fate(self, kind: Kind) -> Fate:
        """Return what becomes of something in a changed photo of this format."""
        if kind is kinds.CREDENTIALS or (kind is kinds.VIDEO and kind in self.companions):
            return "on request"
        if kind in self.companions:
            return "kept"
        return "kept" if kind in self.kept else "moved" if kind in self.moved else "left out"

    def turns(self, photo: Photo, *, is_export: bool = False) -> bool:
        """Tell whether a photo's file lies otherwise than one of this format made from it."""
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
        """Return what of a photo's extras a changed one doesn't keep, in one line, as found.

        `along`: what accompanies it, and credentials where it is signed; `is_export`: all is
        encoded anew.
        """
        turns = self.turns(photo, is_export=is_export)
        lost: dict[str, None] = {}
        moved = has_note = False
        for extra in extras:
            asked = extra.kind in self.companions or extra.kind is kinds.CREDENTIALS
            gone = asked and extra.kind not in along
            is_behind = photo.format == self.name and not is_export and kinds.VIDEO not in along
            gone |= extra.kind in kinds.RECORDS and not is_behind
            gone |= extra.kind is kinds.PLACES and turns
            gone |= extra.kind is kinds.SECOND_PROFILE and photo.jpeg is None
            fate = "left out" if gone else self.fate(extra.kind)
            moved |= fate == "moved"
            has_note |= extra.kind in (kinds.MAKER_NOTE, kinds.MOVED_NOTE)
            if fate == "left out" and extra.kind.is_reported:
                lost[extra.name] = None
        notes = [Text("not kept: {lost}", lost=Text.joined(", ", lost))] if lost else []
        if moved:
            notes.append(Text("the maker's note has moved: programs may miss parts of it"))
        if has_note and turns:
            notes.append(Text("places in the maker's note are those of the picture as it lay"))
        return Text.joined("; ", notes)
