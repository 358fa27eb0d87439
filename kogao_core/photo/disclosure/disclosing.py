"""Telling, for those who want to, that a photo was retouched: in its XMP and on the picture."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import partial, reduce

from kogao_core.base.geometry import Image
from kogao_core.base.language import Text
from kogao_core.photo.disclosure.credentials import Signer, signed
from kogao_core.photo.disclosure.label import draw_label
from kogao_core.photo.disclosure.label_picture import LabelPicture, lay_over
from kogao_core.photo.model import Photo, is_same
from kogao_core.photo.writing import Sign


@dataclass(frozen=True, slots=True)
class Disclosure:
    """What a result discloses of its retouching; nothing, unless it is asked for."""

    # Add an edit record to the XMP: an event in ``xmpMM:History`` and, where the photo is a plain
    # capture so far, the IPTC digital source type "human edits".
    record: bool = False
    label: str = ""  # text to draw into the bottom right corner; none if empty
    # A font file for the label, for letters that the built-in Latin font lacks.
    font: str | None = None
    picture: LabelPicture | None = None  # a picture to lay over a corner
    signer: Signer | None = None  # who signs content credentials, see `signing`
    film: bool = False  # keep a motion photo's video, which shows the face as it was

    @property
    def is_wanted(self) -> bool:
        """Whether anything is to be disclosed."""
        return self.record or self.is_labelled or self.signer is not None

    @property
    def is_labelled(self) -> bool:
        """Whether the picture shows it."""
        return bool(self.label) or self.picture is not None


NO_DISCLOSURE = Disclosure()


def disclose(
    photo: Photo,
    pixels: Image,
    disclosure: Disclosure,
    *,
    what: str = "",
    when: datetime | None = None,
) -> tuple[Photo, Image]:
    """Return a photo and its new pixels with what they disclose, ready for `write`.

    A result that equals the photo discloses nothing: there was no retouching (see `undisclosed`).
    Labels change the pixels of their own rectangles only, the record nothing but the XMP packet.
    `photo`: with the record in its XMP; `pixels`: with the labels; the very same array where there
    are none. Raises CannotDisclose.
    """
    if not disclosure.is_wanted or is_same(photo.pixels, pixels):
        return photo, pixels
    if disclosure.picture is not None:
        pixels = lay_over(photo, pixels, disclosure.picture)
    if disclosure.label:
        pixels = draw_label(pixels, disclosure.label, disclosure.font)
    if disclosure.record:
        from kogao_core.photo.disclosure import edit_record  # loads an XML writer; few ask for it

        xmp = edit_record.added(photo.xmp, what, when or datetime.now(UTC))
        photo = dataclasses.replace(photo, xmp=xmp)
    return photo, pixels


def signing(disclosure: Disclosure, what: str) -> Sign | None:
    """Return what signs a result on its way into a file, for `write`; None, where nobody does."""
    if disclosure.signer is None:
        return None
    return partial(signed, signer=disclosure.signer, what=what)


def undisclosed(photo: Photo, pixels: Image, disclosure: Disclosure) -> str:
    """Return in words what `disclose` leaves out of a result that equals the photo, or ""."""
    if not disclosure.is_wanted or not is_same(photo.pixels, pixels):
        return ""
    wanted = {
        Text("label"): disclosure.is_labelled,
        Text("edit record"): disclosure.record,
        Text("signature"): disclosure.signer is not None,
    }
    missing = reduce(_and, (name for name, asked in wanted.items() if asked))
    return Text("nothing was changed, so there is no {missing}", missing=missing)


def _and(one: Text, other: Text) -> Text:
    return Text("{one} and {other}", one=one, other=other)
