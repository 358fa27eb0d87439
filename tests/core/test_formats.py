"""A file format is declared once; sentences, help, documents and tests follow from it."""

import dataclasses
from pathlib import Path

import files
import numpy as np
import pytest
from click.testing import CliRunner

from kogao_core import photo
from kogao_core.cli.commands import program
from kogao_core.photo import formats, writing
from kogao_core.photo.metadata import kinds

DOCUMENT = Path(__file__).parents[2] / "docs" / "fidelity.md"
DEPTHS = {"uint8": "8", "uint16": "16", "float32": "32 float"}


def test_each_written_format_has_a_maker_of_test_files():
    assert {form.suffixes[0] for form in formats.WRITTEN} == set(files.MAKERS)


def test_a_name_and_an_ending_belong_to_one_format():
    assert len(formats.BY_NAME) == len(formats.ALL)
    endings = [suffix for form in formats.ALL for suffix in form.suffixes]
    assert len(set(endings)) == len(endings)
    assert all(ending == ending.lower() and ending[0] == "." for ending in endings)


@pytest.mark.parametrize("form", formats.WRITTEN, ids=lambda form: form.name)
def test_what_is_written_is_of_the_format_that_its_name_promises(form, tmp_path):
    source = files.opened(tmp_path / "in.png", files.png(np.full((16, 24, 3), 90, np.uint8)))
    for suffix in form.suffixes:
        photo.write(source, source.pixels // 2, tmp_path / f"out{suffix}")
        assert photo.read(tmp_path / f"out{suffix}").format == form.name


def test_a_format_that_holds_no_metadata_leaves_out_every_kind():
    bare = dataclasses.replace(formats.BY_NAME["WEBP"], kept=frozenset())
    known = [kind for kind in vars(kinds).values() if isinstance(kind, kinds.Kind)]
    assert {bare.fate(kind) for kind in known} == {"left out"}


def test_a_format_without_an_encoder_writes_nothing(tmp_path):
    source = files.opened(tmp_path / "in.png", files.png(np.full((16, 24, 3), 90, np.uint8)))
    with pytest.raises(ValueError, match="raw is read only"):
        writing.encode(source, source.pixels, formats.BY_NAME["RAW"])


def test_sentences_name_every_format(tmp_path):
    (tmp_path / "in.jpg").write_bytes(b"no photo at all")
    with pytest.raises(photo.UnreadablePhoto) as refusal:
        photo.read(tmp_path / "in.jpg")
    titles = formats.either([form.title for form in formats.ALL])
    assert f"is not a {titles} photo; convert it" in str(refusal.value)
    assert f"is not a {titles} photo" in " ".join(DOCUMENT.read_text(encoding="utf-8").split())
    with pytest.raises(photo.RefusedOutput) as refusal:
        photo.check_output(tmp_path / "out.gif")
    assert all(ending in str(refusal.value) for ending in formats.FORMATS)


def test_help_names_every_format_that_is_written():
    endings = [form.suffixes[0] for form in formats.WRITTEN]
    said = " ".join(CliRunner().invoke(program, ["warp", "--help"]).output.split())
    assert all(ending in said for ending in endings)
    said = CliRunner().invoke(program, ["batch", "--help"]).output
    assert "|".join(ending[1:] for ending in endings) in said


def test_the_document_tells_what_each_format_holds():
    rows = {}
    for line in DOCUMENT.read_text(encoding="utf-8").splitlines():
        if line.startswith("|") and len(rows) < 8:
            name, *cells = (cell.strip() for cell in line.strip("|").split("|"))
            rows[name] = cells[: len(formats.WRITTEN)]
    written = formats.WRITTEN
    assert rows[""] == [form.title for form in written]
    depths = [DEPTHS | {"uint16": str(form.deep_bits)} for form in written]
    said = [
        ", ".join(map(own.get, form.layouts)) for own, form in zip(depths, written, strict=True)
    ]
    assert rows["written"] == said
    sides = [str(form.longest_side_px or "any") for form in written]
    assert rows["longest side, px"] == sides
    grey = ["grey" if 1 in form.layouts["uint8"] else "becomes RGB" for form in written]
    assert rows["grey"] == grey
    alpha = ["kept" if form.holds_alpha("uint8") else "refused" for form in written]
    assert rows["transparency"] == alpha
