"""Stars and labels of photos are read as other programs write them."""

from __future__ import annotations

import numpy as np
import pytest
from named import HEAD, microsoft, mwg
from PIL import Image

from kogao_core.photo.metadata.rating import Rated, rating_of

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
def test_a_sidecar_comes_before_the_photo(photo, name):
    photo.with_name(name).write_bytes(ELEMENTS)
    assert rating_of(photo) == Rated(-1, "")
    photo.with_name(name).write_bytes(ELEMENTS.replace(b"<xmp:Label/>", b""))
    assert rating_of(photo) == Rated(-1, "Sélection & co")


def test_names_of_people_are_read_in_every_form(tmp_path):
    place = ((0.5, 0.5), (0.2, 0.2))
    named = [("Zoë Ann", place), ("Tom &amp; Jo", place)]
    for content in (mwg(named, (8, 8)), mwg(named, (8, 8), as_elements=True), microsoft(named)):
        (tmp_path / "x.jpg").write_bytes(HEAD.format(content).encode())
        assert rating_of(tmp_path / "x.jpg").people == {"Zoë Ann", "Tom & Jo"}
