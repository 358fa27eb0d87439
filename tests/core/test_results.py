"""Results are known as such, wherever they go; photos never are."""

from __future__ import annotations

import json
import shutil
from datetime import UTC, datetime

import pytest
from PIL import Image

from kogao_core.photo.disclosure import disclosing
from kogao_core.projects.results import REPORT, Results


@pytest.fixture
def results(tmp_path):
    return Results(tmp_path / "home")


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


def test_a_listed_result_is_known_by_its_bytes_wherever_it_goes(results, photo):
    result = made(photo)
    assert results.origin(result) is None
    results.add(photo, result, "edit")
    assert results.origin(photo) is None
    assert results.edits_of(photo) == {"edit"}
    assert str(photo).encode() not in (results.folder / "index.db").read_bytes()
    (moved := photo.parent / "out" / "elsewhere.jpg").parent.mkdir()
    shutil.move(result, moved)
    assert results.origin(moved).source == photo
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
    assert results.forget(photo.with_name("never-there.jpg")) == 0
    assert results.forget(photo) == 1


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
    packet = disclosing.added(None, "a face made smaller", datetime.now(UTC))
    assert results.origin(made(photo, xmp=packet)).source is None
    theirs = packet.replace(b"Kogao ", b"Other ")
    assert results.origin(made(photo, xmp=theirs)) is None


DAMAGED = [
    '{"source": 3}',
    "[]",
    '{"source": "a", "more": 1}',
    "nonsense",
    '{"source": "a", "name": "b", "size": {}, "sha256": "c", "edit": ""}',
    '{"source": {}, "name": "b", "size": 1, "sha256": "c", "edit": ""}',
    '{"source": "a", "name": "b", "size": 1, "sha256": [], "edit": ""}',
    "[" * 9999,
    "\\ud800",
]


@pytest.mark.parametrize("line", DAMAGED)
def test_damaged_lines_are_skipped_with_a_warning_that_names_the_file(results, photo, line, caplog):
    result = made(photo)
    results.folder.mkdir()
    (results.folder / "results.jsonl").write_text(line + "\n")
    results.add(photo, result)
    assert results.origin(result).source == photo
    assert f"{results.folder / 'results.jsonl'}: skipped 1 damaged line" in caplog.text


def test_a_list_that_cannot_be_written_or_read_is_none(photo, tmp_path):
    results = Results(tmp_path / "in" / "portrait.jpg")
    results.add(photo, made(photo))
    assert results.edits_of(photo) == set()
    assert results.origin(tmp_path / "gone.jpg") is None
