"""What a result tells about itself: only when asked, and without harming anything else."""

import dataclasses
import struct
from datetime import UTC, datetime
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image, ImageFont
from scenes import textured_photo

from kogao_core import photo
from kogao_core.photo import CannotDisclose, formats
from kogao_core.photo.disclosure import label
from kogao_core.photo.disclosure.disclosing import (
    NO_DISCLOSURE,
    Disclosure,
    added,
    disclose,
    undisclosed,
)
from kogao_core.photo.disclosure.label import LONGEST, draw_label
from kogao_core.photo.metadata.kinds import XMP

WHEN = datetime(2026, 3, 4, 5, 6, 7, tzinfo=UTC)
RDF = "{http://www.w3.org/1999/02/22-rdf-syntax-ns#}"
MEDIA = "{http://ns.adobe.com/xap/1.0/mm/}"
EVENT = "{http://ns.adobe.com/xap/1.0/sType/ResourceEvent#}"
IPTC = "{http://iptc.org/std/Iptc4xmpExt/2008-02-29/}"
KIND = "http://cv.iptc.org/newscodes/digitalsourcetype/"
EDITED = f"{KIND}humanEdits"
SPACES = (
    'xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#" '
    'xmlns:mm="http://ns.adobe.com/xap/1.0/mm/" '
    'xmlns:ev="http://ns.adobe.com/xap/1.0/sType/ResourceEvent#" '
    'xmlns:ipx="http://iptc.org/std/Iptc4xmpExt/2008-02-29/" '
    'xmlns:dc="http://purl.org/dc/elements/1.1/"'
)
OLD_EVENT = '<rdf:li ev:action="created"/>'


def packet(inside, wrapped=True):
    top = f"<rdf:RDF {SPACES}>{inside}</rdf:RDF>"
    body = f'<x:xmpmeta xmlns:x="adobe:ns:meta/" x:xmptk="A &lt;toolkit>">{top}</x:xmpmeta>'
    head, tail = '<?xpacket begin="\ufeff" id="W5M0"?>', f"{' ' * 300}\n<?xpacket end='w'?>"
    return (head + body + tail if wrapped else top).encode()


PACKETS = {
    "nothing": None,
    "an empty list": packet("", wrapped=False),
    "a caption": packet(
        '<rdf:Description rdf:about="uuid:1"><dc:title>é &amp; 顔</dc:title></rdf:Description>'
    ),
    "a history": packet(
        f"<rdf:Description><mm:History><rdf:Seq>{OLD_EVENT}</rdf:Seq></mm:History>"
        "</rdf:Description>"
    ),
    "an empty history": packet(
        "<rdf:Description><mm:History><rdf:Seq/></mm:History></rdf:Description>"
    ),
    "a capture": packet(f'<rdf:Description ipx:DigitalSourceType="{KIND}digitalCapture"/>'),
    "a capture as element": packet(
        "<rdf:Description><ipx:DigitalSourceType>"
        f"{KIND}negativeFilm</ipx:DigitalSourceType></rdf:Description>"
    ),
    "a closed top": f"<rdf:RDF {SPACES} />".encode(),
    "zeros at the end": packet("") + b"\0\0",
    "another picture's history": packet(
        "<rdf:Description><mm:Pantry><rdf:Bag><rdf:li><rdf:Description><mm:History><rdf:Seq>"
        f"{OLD_EVENT}</rdf:Seq></mm:History></rdf:Description></rdf:li></rdf:Bag></mm:Pantry>"
        "</rdf:Description>"
    ),
}


def top_of(xmp):
    root = ElementTree.fromstring(xmp.decode())
    return root if root.tag == f"{RDF}RDF" else root.find(f"{RDF}RDF")


def told(xmp):
    """Return the events of the history and the source types, as an independent reader sees them."""
    descriptions = top_of(xmp).findall(f"{RDF}Description")
    events = [e for d in descriptions for e in d.findall(f"{MEDIA}History/{RDF}Seq/{RDF}li")]
    kinds = [e.text for d in descriptions for e in d.findall(f"{IPTC}DigitalSourceType")]
    kinds += [d.attrib[f"{IPTC}DigitalSourceType"] for d in descriptions
              if f"{IPTC}DigitalSourceType" in d.attrib]  # fmt: skip
    return events, kinds


@pytest.mark.parametrize("xmp", PACKETS.values(), ids=PACKETS.keys())
def test_a_record_is_added_and_nothing_else_changes(xmp):
    once = added(xmp, 'made "smaller" & <slimmer>', WHEN)
    events, kinds = told(once)
    created = ["created"] * (xmp == PACKETS["a history"])
    assert [event.attrib[f"{EVENT}action"] for event in events] == [*created, "edited"]
    last = events[-1].attrib
    assert last[f"{EVENT}when"] == "2026-03-04T05:06:07+00:00"
    assert last[f"{EVENT}softwareAgent"].startswith("Kogao ")
    assert last[f"{EVENT}parameters"] == 'made "smaller" & <slimmer>'
    assert kinds == [EDITED]
    abouts = {d.attrib.get(f"{RDF}about", "") for d in top_of(once).findall(f"{RDF}Description")}
    assert len(abouts) == 1
    if xmp is not None and b"digitalsourcetype" not in xmp and b"/>" not in xmp:
        # What was there is still there, in order, around one insertion each.
        rest = iter(once)
        assert all(byte in rest for byte in xmp.rstrip(b"\0"))
    twice, kinds = told(added(once, "again", WHEN))
    assert len(twice) == len(events) + 1
    assert kinds == [EDITED]


@pytest.mark.parametrize("kind", ["trainedAlgorithmicMedia", "compositeCapture", "unheardOf"])
def test_a_source_type_that_tells_more_stays(kind):
    xmp = packet(f'<rdf:Description ipx:DigitalSourceType="{KIND}{kind}"/>')
    assert told(added(xmp, "", WHEN))[1] == [KIND + kind]


@pytest.mark.parametrize(
    "xmp",
    [
        b"no XML at all",
        b"<a/>",
        packet("")[:-40].replace(b"</rdf:RDF>", b""),
        packet("<rdf:Description><mm:History/></rdf:Description>"),
        packet('<rdf:Description mm:History="long"/>'),
        packet("").decode().encode("utf-16"),
        b'<!DOCTYPE a [<!ENTITY b "c">]>' + packet("", wrapped=False),
    ],
)
def test_a_packet_that_cannot_take_a_record_is_a_sentence(xmp):
    with pytest.raises(CannotDisclose, match="XMP can't take an edit record") as refused:
        added(xmp, "", WHEN)
    assert "\n" not in str(refused.value)


def test_a_packet_of_endless_depth_is_no_trouble():
    deep = "<dc:a>" * 200_000 + "</dc:a>" * 200_000
    xmp = packet(f"<rdf:Description>{deep}</rdf:Description>")
    assert added(xmp, "", WHEN).count(b"stEvt:action") == 1


# ---- label ----------------------------------------------------------------------------------


@pytest.mark.parametrize("channels", [0, 2, 3, 4])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
def test_a_label_changes_its_corner_only(dtype, channels):
    shape = (120, 200, channels) if channels else (120, 200)
    white = np.iinfo(dtype).max if dtype != np.float32 else 1.0
    pixels = (np.random.default_rng(2).random(shape) * white).astype(dtype)
    before = pixels.copy()
    labelled = draw_label(pixels, "Retouched")
    assert (labelled.dtype, labelled.shape) == (dtype, shape)
    np.testing.assert_array_equal(pixels, before)
    differs = (labelled != pixels).reshape(120, 200, -1).any(axis=2)
    rows, columns = np.flatnonzero(differs.any(axis=1)), np.flatnonzero(differs.any(axis=0))
    assert rows[-1] == 119
    assert columns[-1] == 199
    assert rows[0] > 60
    assert columns[0] > 20
    colours = labelled[rows[0] :, columns[0] :]
    colours = colours[..., : channels - (channels in (2, 4))] if channels else colours
    assert colours.max() == white
    assert np.median(colours) < 0.4 * white
    if channels in (2, 4):
        assert (labelled[rows[0] :, columns[0] :, -1] == white).all()


def test_letters_grow_with_the_photo_and_shrink_to_fit():
    def area(width, height, text):
        pixels = np.full((height, width), 200, np.uint8)
        return int((draw_label(pixels, text) != pixels).sum())

    assert area(2000, 1600, "Retouched") > 3 * area(500, 400, "Retouched")
    assert area(60, 60, "Retouched") < area(500, 400, "Retouched")


@pytest.mark.parametrize(
    ("text", "font", "words"),
    [
        ("two\nlines", None, "one line"),
        ("x" * (LONGEST + 1), None, "one line"),
        ("x" * LONGEST, None, "too small"),
        ("加工", None, "has no '加'"),
        ("a\u3000b", None, r"has no '\\u3000'"),
        ("Retouched", "missing.ttf", "can't be used as a font"),
    ],
)
def test_a_label_that_cannot_be_drawn_is_a_sentence(text, font, words, monkeypatch):
    monkeypatch.setattr(label, "_OF_SYSTEM", ("missing.ttf",))
    with pytest.raises(CannotDisclose, match=words):
        draw_label(np.zeros((40, 60, 3), np.uint8), text, font)


def test_a_font_whose_letters_have_no_height_is_refused(tmp_path):
    data = bytearray(ImageFont.load_default(14).font_bytes)
    at = data.index(b"hhea")
    (table,) = struct.unpack_from(">I", data, at + 8)
    struct.pack_into(">hh", data, table + 4, 0, 2000)  # the letters' rise, and what hangs down
    (tmp_path / "f.ttf").write_bytes(data)
    with pytest.raises(CannotDisclose, match="can't be used as a font"):
        draw_label(np.zeros((400, 600, 3), np.uint8), "Retouched", str(tmp_path / "f.ttf"))


def test_letters_that_the_built_in_font_lacks_are_drawn_by_one_of_the_system():
    pixels = np.full((300, 300), 200, np.uint8)
    there = [font for font in label._OF_SYSTEM if label._is_there(font)]
    if not there:
        pytest.skip("this system has no font with Japanese letters")
    changed = draw_label(pixels, "レタッチ\u3000済み") != pixels
    assert changed[-1, -1]
    assert not changed[:200].any()


# ---- both, and files ------------------------------------------------------------------------


def smaller(source):
    pixels = source.pixels.copy()
    pixels[5:20, 9:30] = 255 - pixels[5:20, 9:30]
    return pixels


def test_nothing_is_told_unless_asked_or_where_nothing_was_done(tmp_path):
    Image.fromarray(textured_photo(160, 120)).save(tmp_path / "in.jpg")
    source = photo.read(tmp_path / "in.jpg")
    pixels = smaller(source)
    assert disclose(source, pixels, NO_DISCLOSURE) == (source, pixels)
    everything = Disclosure(record=True, label="Retouched")
    assert disclose(source, source.pixels, everything) == (source, source.pixels)


@pytest.mark.parametrize(
    "form", [one for one in formats.WRITTEN if XMP in one.kept], ids=lambda form: form.name
)
def test_files_tell_what_was_asked(tmp_path, form):
    suffix = form.suffixes[0]
    Image.fromarray(textured_photo(320, 240)).save(tmp_path / "in.jpg", subsampling="4:2:0")
    source = photo.read(tmp_path / "in.jpg")
    pixels = smaller(source)
    told_of, labelled = disclose(
        source, pixels, Disclosure(True, "Retouched"), what="one face", when=WHEN
    )
    said = photo.write(told_of, labelled, tmp_path / f"out{suffix}")
    written = photo.read(tmp_path / f"out{suffix}")
    events, kinds = told(written.xmp)
    assert events[0].attrib[f"{EVENT}parameters"] == "one face"
    assert kinds == [EDITED]
    differs = (labelled != pixels).any(axis=2)
    if suffix == ".jpg":
        assert "of the JPEG unchanged" in said
        away = np.ones_like(differs)
        away[:40, :50] = away[-40:, -130:] = False
        np.testing.assert_array_equal(written.pixels[away], source.pixels[away])
    elif form.is_lossless:
        np.testing.assert_array_equal(written.pixels[~differs], pixels[~differs])


def test_a_format_that_holds_no_metadata_names_the_loss_and_refuses_a_record(tmp_path, monkeypatch):
    bare = dataclasses.replace(formats.BY_NAME["PNG"], kept=frozenset())
    monkeypatch.setitem(formats.BY_NAME, "PNG", bare)
    exif = Image.Exif()
    exif[0x10F] = "Maker"
    Image.fromarray(textured_photo(64, 48)).save(tmp_path / "in.jpg", exif=exif)
    source = photo.read(tmp_path / "in.jpg")
    assert "EXIF with GPS" in photo.write(source, smaller(source), tmp_path / "out.png")
    told_of, pixels = disclose(source, smaller(source), Disclosure(record=True), when=WHEN)
    with pytest.raises(photo.RefusedOutput, match="can't hold the edit record"):
        photo.write(told_of, pixels, tmp_path / "told.png")
    assert not (tmp_path / "told.png").exists()


def test_what_an_unchanged_photo_isnt_told_is_said(tmp_path):
    pixels = textured_photo(64, 48)
    Image.fromarray(pixels).save(tmp_path / "a.png")
    source = photo.read(tmp_path / "a.png")
    assert "no label and edit record" in undisclosed(source, pixels, Disclosure(True, "AI"))
    assert undisclosed(source, pixels, Disclosure(True)).endswith("there is no edit record")
    assert undisclosed(source, pixels, NO_DISCLOSURE) == ""
    assert undisclosed(source, 255 - pixels, Disclosure(True, "AI")) == ""
