"""Stars and labels of photos: read as other programs write them, written beside the photo only."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

from kogao_core.photo.metadata.rating import LABELS, Rated, rate, rating_of
from kogao_core.photo.metadata.xmp import EMPTY

RDF = b'xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#"'
XMP = b'xmlns:xmp="http://ns.adobe.com/xap/1.0/"'
# As Lightroom, darktable and digiKam write them, with what must stay.
ATTRIBUTES = (
    b'<x:xmpmeta xmlns:x="adobe:ns:meta/"><rdf:RDF ' + RDF + b">\n <rdf:Description "
    b'rdf:about="" ' + XMP + b" xmlns:crs='http://ns.adobe.com/camera-raw-settings/1.0/'\n"
    b'  xmp:Rating=\'2\'\txmp:Label="S\xc3\xa9lection &amp; co" crs:Exposure2012="+0.50"/>\n'
    b"</rdf:RDF></x:xmpmeta>\n"
)
ELEMENTS = (
    b'<?xml version="1.0" encoding="UTF-8"?>\n<rdf:RDF ' + RDF + b"><rdf:Description " + XMP + b">"
    b"<xmp:Label/><xmp:Rating>-1</xmp:Rating><xmp:Nested><rdf:Bag><rdf:li>3</rdf:li></rdf:Bag>"
    b"</xmp:Nested></rdf:Description></rdf:RDF>"
)


@pytest.fixture
def photo(tmp_path):
    path = tmp_path / "portrait.jpg"
    Image.fromarray(np.zeros((8, 8, 3), np.uint8)).save(path, xmp=ATTRIBUTES)
    return path


def test_a_photos_own_rating_is_read(photo):
    assert rating_of(photo) == Rated(2, "Sélection & co")


@pytest.mark.parametrize(
    ("said", "stars"), [("5", 5), ("3.6", 4), ("17", 5), ("-1", -1), ("nan", 0), ("many", 0)]
)
def test_odd_ratings_are_taken_for_what_they_come_near(tmp_path, said, stars):
    (tmp_path / "x.jpg.xmp").write_bytes(ATTRIBUTES.replace(b"'2'", f"'{said}'".encode()))
    assert rating_of(tmp_path / "x.jpg").stars == stars


@pytest.mark.parametrize("name", ["portrait.jpg.xmp", "portrait.xmp"])
def test_a_sidecar_comes_before_the_photo_and_takes_what_is_set(photo, name):
    before, sidecar = photo.read_bytes(), photo.with_name(name)
    sidecar.write_bytes(ELEMENTS)
    assert rating_of(photo) == Rated(-1, "")
    rate(photo, stars=4)
    rate(photo, label="Green")
    assert rating_of(photo) == Rated(4, "Green")
    wanted = ELEMENTS.replace(b">-1<", b">4<").replace(
        b"<xmp:Label/>", b"<xmp:Label>Green</xmp:Label>"
    )
    assert sidecar.read_bytes() == wanted
    assert photo.read_bytes() == before
    assert {path.name for path in photo.parent.iterdir()} == {photo.name, name}


def test_every_other_byte_of_a_sidecar_stays(photo):
    sidecar = photo.with_name("portrait.jpg.xmp")
    sidecar.write_bytes(ATTRIBUTES)
    rate(photo, stars=5)
    assert sidecar.read_bytes() == ATTRIBUTES.replace(b"'2'", b"'5'")


@pytest.mark.parametrize("there", [None, EMPTY, b"<rdf:RDF " + RDF + b"/>"])
def test_where_nothing_is_said_it_is_added(photo, there):
    sidecar = photo.with_name("portrait.jpg.xmp")
    if there is not None:
        sidecar.write_bytes(there)
    for label in LABELS:
        rate(photo, 3, label)
        assert rating_of(photo) == Rated(3, label)
    rate(photo, 0, "")
    assert rating_of(photo) == Rated(), "and not what the photo itself says"
    assert sidecar.read_bytes().count(b"Rating") == 1


@pytest.mark.parametrize("broken", [b"", b"<rdf:RDF", b"<a/>", b"<!DOCTYPE a><a/>"])
def test_a_sidecar_that_is_none_is_left_alone_with_a_sentence(photo, broken):
    sidecar = photo.with_name("portrait.jpg.xmp")
    sidecar.write_bytes(broken)
    with pytest.raises(ValueError, match=r"portrait.jpg.xmp isn't XMP \("):
        rate(photo, 3)
    assert sidecar.read_bytes() == broken
