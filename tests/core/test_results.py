"""Results are known as such, wherever they go; photos never are."""

from __future__ import annotations

import json
import shutil
from datetime import UTC, datetime

import pytest
from PIL import Image

from kogao_core.photo.disclosure import edit_record
from kogao_core.photo.metadata import glance, xmp
from kogao_core.projects.results import REPORT, Result, Results

XMP = (
    b'<x:xmpmeta xmlns:x="adobe:ns:meta/"><rdf:RDF xmlns:rdf='
    b'"http://www.w3.org/1999/02/22-rdf-syntax-ns#"><rdf:Description rdf:about="" '
    b'xmlns:dc="http://purl.org/dc/elements/1.1/" dc:source="me"%s</rdf:RDF></x:xmpmeta>'
)
LATER = b' xmlns:xmp="http://ns.adobe.com/xap/1.0/"'


@pytest.fixture
def results(tmp_path):
    return Results(tmp_path / "home" / "results.jsonl")


@pytest.fixture
def photo(tmp_path):
    path = tmp_path / "in" / "portrait.jpg"
    path.parent.mkdir()
    Image.new("RGB", (60, 40), "grey").save(path)
    return path


def made(photo, name="out.jpg", **how):
    path = photo.with_name(name)
    Image.new("RGB", (60, 40), "red").save(path, **how)
    return path


def test_a_listed_result_is_known_by_its_bytes_wherever_it_goes(results, photo, tmp_path):
    result = made(photo)
    assert results.origin(result) is None
    results.add(photo, result, "edit")
    assert results.origin(photo) is None
    assert results.of(photo) == [
        Result(str(photo), str(result), result.stat().st_size, results.of(photo)[0].sha256, "edit")
    ]
    moved = tmp_path / "elsewhere.jpg"
    shutil.move(result, moved)
    assert results.origin(moved).source == photo
    assert results.of(photo) == [], "it isn't there any more"
    photo.rename(moved.with_name(photo.name))
    assert results.origin(moved).source == moved.with_name(photo.name)
    moved.with_name(photo.name).unlink()
    assert results.origin(moved).source is None


def test_a_result_that_equals_its_photo_makes_no_result_of_that(results, photo):
    copy = photo.with_name("copy.jpg")
    shutil.copy(photo, copy)
    results.add(photo, copy)
    assert results.origin(photo) is None
    assert results.origin(copy) is None
    assert len(results.of(photo)) == 1


@pytest.mark.parametrize(
    ("name", "source"),
    [
        ("portrait_kogao.jpg", True),
        ("portrait_kogao.png", True),
        ("portrait_kogao-2.jpg", True),
        ("other_kogao.jpg", False),
    ],
)
def test_a_result_is_known_by_its_name(results, photo, name, source):
    origin = results.origin(made(photo, name))
    assert origin.source == (photo if source else None)
    assert name in origin.why


def test_a_result_is_known_by_the_report_of_its_batch(results, photo, tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    result = out / photo.name
    shutil.copy(made(photo), result)
    lines = [{"source": str(photo), "output": f"there/{photo.name}", "status": "done", "faces": 1}]
    (out / REPORT).write_text("\n".join(["damaged", *map(json.dumps, lines)]))
    assert results.origin(result).source == photo


def test_a_result_is_known_by_its_edit_record(results, photo):
    packet = edit_record.added(None, "a face made smaller", datetime.now(UTC))
    assert results.origin(made(photo, xmp=packet)).source is None
    assert results.origin(made(photo, xmp=XMP % b"/>")) is None


@pytest.mark.parametrize("line", ['{"source": 3}', "[]", '{"source": "a", "more": 1}', "nonsense"])
def test_a_damaged_list_loses_its_damaged_lines_alone(results, photo, line):
    result = made(photo)
    results.file.parent.mkdir()
    results.file.write_text(line + "\n")
    results.add(photo, result)
    assert results.origin(result).source == photo


def test_a_list_that_cannot_be_written_or_read_is_none(photo, tmp_path):
    results = Results(tmp_path / "in")
    results.add(photo, made(photo))
    assert results.of(photo) == []
    assert results.origin(tmp_path / "gone.jpg") is None


@pytest.mark.parametrize(
    "before",
    [
        None,
        XMP % b"/>",
        XMP % (LATER + b' xmp:Rating="1"/>'),
        XMP % (LATER + b"><xmp:Rating>1</xmp:Rating></rdf:Description>"),
        XMP % (LATER + b' xmp:Label="Red"/>'),
    ],
)
def test_stars_go_beside_the_photo_and_change_nothing_else(photo, before):
    beside = photo.with_suffix(".xmp")
    if before is not None:
        beside.write_bytes(before)
    pixels = photo.read_bytes()
    for stars in (3, 5, glance.REJECTED, 0):
        glance.rate(photo, stars)
        assert glance.rating(photo) == stars
    place = glance.sidecar_of(photo)
    assert place == (photo.with_name("portrait.jpg.xmp") if before is None else beside)
    xmp.Walk(place.read_bytes(), 2)
    assert photo.read_bytes() == pixels
    if before is not None:
        assert all(part in place.read_bytes() for part in (b'dc:source="me"', before[-20:-2][-9:]))


def test_stars_within_a_photo_are_read_and_those_beside_it_come_first(photo):
    Image.new("RGB", (60, 40)).save(photo, xmp=XMP % (LATER + b' xmp:Rating="4"/>'))
    assert glance.rating(photo) == 4
    glance.rate(photo, 2)
    assert glance.rating(photo) == 2
    assert glance.rating(made(photo)) == 0


@pytest.mark.parametrize("text", [b"no xml", b"<rdf:Description", XMP % b">"])
def test_damaged_xmp_is_left_alone(photo, text):
    photo.with_suffix(".xmp").write_bytes(text)
    with pytest.raises(xmp.BadXmp):
        glance.rate(photo, 3)
    assert photo.with_suffix(".xmp").read_bytes() == text
