"""An evidence file holds what the engine computed, and is read only if it is whole."""

import io
import json
import re
from pathlib import Path

import cv2
import numpy as np
import pytest
from scenes import oval_face, textured_photo

import kogao_core as kogao
from kogao_core.base.json_reader import BadFile
from kogao_core.cli.licences import manifest
from kogao_core.field.field import Field
from kogao_core.paper.domain import mask_of

PHOTO = textured_photo(240, 180)
FACES = [oval_face(240, 180, size=0.3), kogao.template_face((200, 40), 40)]


@pytest.fixture(scope="module")
def rendering():
    return kogao.render(PHOTO, FACES, kogao.PAPER)


@pytest.fixture
def file(rendering, tmp_path):
    rendering.save_evidence(tmp_path / "e.npz", photo_sha256="ab")
    return tmp_path / "e.npz"


def test_the_file_holds_what_the_engine_computed(rendering, file):
    found = kogao.load_evidence(file)
    xs, ys = np.arange(240.0), np.arange(180.0)
    field = rendering.field
    np.testing.assert_allclose(
        found.displacement_px, field.on_grid(xs, ys).transpose(1, 2, 0), atol=1e-5
    )
    np.testing.assert_allclose(found.det_j, field.det_jacobian(xs, ys), atol=1e-5)
    for name, mask in found.masks.items():
        image = rendering.domain.image
        expected = mask_of(field.lattices, image, name, rendering.threshold_px)
        np.testing.assert_array_equal(mask, expected)
    np.testing.assert_array_equal(found.points_px[found.face == 1], rendering.pairs[1].source_px)
    np.testing.assert_array_equal(found.targets_px[found.face == 0], rendering.pairs[0].target_px)
    np.testing.assert_array_equal(found.centers_px[1], rendering.pairs[1].center_px)
    assert found.recipe == kogao.PAPER
    assert (found.size, found.made["photo_sha256"]) == ((240, 180), "ab")
    assert len(found.made["result_sha256"]) == 64
    # The lattices alone give the displacement again.
    again = Field(found.lattices).on_grid(xs, ys)
    np.testing.assert_allclose(again, field.on_grid(xs, ys), atol=1e-12)


def test_numpy_alone_reads_every_array_that_is_documented(file):
    arrays = np.load(file)
    page = (Path(__file__).parents[2] / "docs" / "python.md").read_text(encoding="utf-8")
    table = page.partition("| array | content |")[2].partition("\n\n")[0]
    names = re.findall(r"^\| `(\w+)` \|", table, re.MULTILINE)
    assert {*arrays.files} == {one.replace("_K", f"_{k}") for one in names for k in range(2)}
    assert json.loads(str(arrays["recipe"]))["percent"] == 4.0


def test_opencv_makes_the_picture_from_the_displacement(rendering, file):
    xs, ys = np.arange(240, dtype=np.float32), np.arange(180, dtype=np.float32)
    x, y = np.moveaxis(np.load(file)["displacement_px"], 2, 0)
    shown = cv2.remap(PHOTO, x + xs, y + ys[:, None], cv2.INTER_LINEAR)
    apart = np.abs(shown.astype(int) - rendering.pixels)
    assert apart.max() <= 2, "except for rounding to 1/32 px"


def changed(file, **arrays):
    with np.load(file) as whole:
        return {name: whole[name] for name in whole.files} | arrays


@pytest.mark.parametrize(
    "spoil",
    [
        lambda _: b"no archive",
        lambda data: data[: len(data) // 2],
        lambda data: _saved(data, det_j=np.zeros((3, 3), np.float32)),
        lambda data: _saved(data, domain_image=np.zeros((180, 240))),
        lambda data: _saved(data, made=np.array('{"version": 9}')),
        lambda data: _saved(data, recipe=np.array("[]")),
        lambda data: _saved(data, points_px=np.array([object()], dtype=object)),
    ],
)
def test_a_file_that_is_not_whole_is_refused_in_a_sentence(file, spoil):
    file.write_bytes(spoil(file.read_bytes()))
    with pytest.raises(BadFile, match=r"e\.npz is not an evidence file") as refused:
        kogao.load_evidence(file)
    assert "\n" not in str(refused.value)


def _saved(data, **arrays):
    out = io.BytesIO()
    np.savez(out, allow_pickle=True, **changed(io.BytesIO(data), **arrays))
    return out.getvalue()


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(BadFile, match="can't be read"):
        kogao.load_evidence(tmp_path / "none.npz")


def test_a_file_names_its_photo_the_machine_and_the_networks(tmp_path):
    photo = kogao.read(kogao.sample())
    kogao.render(photo, [], kogao.PAPER).save_evidence(tmp_path / "e.npz")
    made = kogao.load_evidence(tmp_path / "e.npz").made
    assert made["photo_sha256"] == photo.sha256 != ""
    assert made["packages"]["numpy"] == np.__version__
    assert "openblas" in made["blas"] or "mkl" in made["blas"] or "accelerate" in made["blas"]
    locked = {one["file"]: one["sha256"] for one in manifest()}
    assert locked == made["networks"]
