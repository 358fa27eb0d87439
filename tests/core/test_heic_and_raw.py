"""HEIC and raw photos come in with their metadata, and go out in formats that last."""

import builtins
from importlib.util import find_spec
from pathlib import Path

import files
import numpy as np
import pytest
from PIL import Image

from kogao_core import batch, photo
from kogao_core.photo import UnreadablePhoto, bits_of
from kogao_core.retouch import RetouchJob

WIDTH, HEIGHT = 112, 80
needs_heic, needs_raw = (
    pytest.mark.skipif(
        not all(map(find_spec, modules)), reason=f"needs the extra [{extra}] and {modules[-1]}"
    )
    for extra, modules in (("heic", ("pi_heif", "pillow_heif")), ("raw", ("rawpy",)))
)


def smooth():
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH]
    return np.stack([y * 2 + x, 200 - x + y // 2, 60 + y * 2], -1).clip(0, 255).astype(np.uint8)


def written(source, suffix, tmp_path):
    photo.write(source, source.pixels // 2, tmp_path / f"out{suffix}")
    return photo.read(tmp_path / f"out{suffix}")


# ---- HEIC -----------------------------------------------------------------------------------


@needs_heic
@pytest.mark.parametrize("channels", [1, 3, 4])
def test_heic_comes_in_and_goes_out_with_its_metadata(tmp_path, channels):
    pixels = np.dstack([smooth(), smooth()[..., :1]])[..., :channels]
    pixels = np.ascontiguousarray(pixels[..., 0] if channels == 1 else pixels)
    profile, exif = files.profile_for(pixels), files.exif_block(1, WIDTH, HEIGHT)
    data = files.heic(pixels, exif=exif, xmp=files.XMP.format(1).encode(), icc_profile=profile)
    source = files.opened(tmp_path / "in.heic", data)
    assert (source.format, source.bits, source.notes) == ("HEIF", 8, ())
    assert np.abs(source.pixels.astype(int) - pixels).mean() < 2.0
    for suffix in (".png", ".tif", *((".jpg",) if channels != 4 else ())):
        again = written(source, suffix, tmp_path)
        assert again.xmp == files.XMP.format(1).encode()
        assert again.icc_profile == profile
        assert files.MAKER_NOTE in again.exif
        assert files.THUMBNAIL not in (tmp_path / f"out{suffix}").read_bytes()
        if suffix != ".jpg":
            np.testing.assert_array_equal(again.pixels, source.pixels // 2)


@needs_heic
def test_heic_of_ten_bits_is_deep_or_not_as_asked(tmp_path):
    deep = smooth().astype(np.uint16) * 257
    source = files.opened(tmp_path / "in.heic", files.heic(deep))
    assert source.bits == 16
    assert np.abs(source.pixels.astype(int) - deep).mean() < 300
    np.testing.assert_array_equal(written(source, ".png", tmp_path).pixels, source.pixels // 2)
    shallow = photo.read(tmp_path / "in.heic", bits=8)
    assert np.abs(shallow.pixels.astype(int) - smooth()).mean() < 2.0


@needs_heic
def test_a_turned_heic_is_upright_once(tmp_path):
    """libheif turns it, and its EXIF block still asks for a turn."""
    import pillow_heif as encoder

    encoder.register_heif_opener()
    stored = np.ascontiguousarray(np.rot90(smooth()))
    exif = Image.Exif()
    exif[0x0112] = 6
    Image.fromarray(stored).save(tmp_path / "in.heic", quality=95, exif=exif.tobytes())
    source = photo.read(tmp_path / "in.heic")
    assert np.abs(source.pixels.astype(int) - smooth()).mean() < 2.0
    again = written(source, ".png", tmp_path)
    assert again.orientation == 1
    np.testing.assert_array_equal(again.pixels, source.pixels // 2)


# ---- raw ------------------------------------------------------------------------------------


@needs_raw
@pytest.mark.parametrize("orientation", [1, 6])
def test_raw_is_developed_upright_with_its_metadata(tmp_path, orientation):
    source = files.opened(tmp_path / "in.dng", files.dng(orientation))
    assert (source.format, source.bits) == ("RAW", 16)
    assert "white balance" in source.notes[0]
    assert source.pixels.shape == ((48, 64, 3) if orientation == 1 else (64, 48, 3))
    along = source.pixels.mean(axis=(0, 2) if orientation == 1 else (1, 2))
    assert (np.diff(along[4:-4]) > 0).all()
    for suffix in (".png", ".tif"):
        again = written(source, suffix, tmp_path)
        np.testing.assert_array_equal(again.pixels, source.pixels // 2)
        assert again.orientation == 1
        assert files.MAKER_NOTE in again.exif
        assert again.xmp == files.XMP.format(1).encode()
    shallow = photo.read(tmp_path / "in.dng", bits=8)
    np.testing.assert_allclose(shallow.pixels, source.pixels / 257, atol=1.0)
    assert written(shallow, ".jpg", tmp_path).pixels.shape == source.pixels.shape


@needs_raw
def test_raw_of_a_camera_without_colours_is_grey_in_every_format(tmp_path):
    (tmp_path / "in.dng").write_bytes(files.dng(colours=1))
    source = photo.read(tmp_path / "in.dng", bits=8)
    assert source.pixels.shape == (48, 64, 3)
    assert (np.ptp(source.pixels, axis=2) == 0).all()
    assert (np.diff(source.pixels[4, 4:-4, 0].astype(int)) >= 0).all()
    for suffix in (".jpg", ".png", ".tif", ".webp"):
        written(source, suffix, tmp_path)


@needs_raw
def test_a_tiff_called_raw_is_refused(tmp_path):
    (tmp_path / "in.nef").write_bytes(files.tiff(smooth()))
    with pytest.raises(UnreadablePhoto, match="LibRaw knows; develop"):
        photo.read(tmp_path / "in.nef")


# ---- both -----------------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "module"), [("in.heic", "pi_heif"), ("in.cr2", "rawpy")])
def test_without_the_extra_a_sentence_names_it(tmp_path, monkeypatch, name, module):
    (tmp_path / name).write_bytes(b"\0\0\0\x18ftypheic" + bytes(40))
    plain = builtins.__import__

    def lacking(asked, *arguments, **options):
        if asked == module:
            raise ImportError(asked)
        return plain(asked, *arguments, **options)

    monkeypatch.setattr(builtins, "__import__", lacking)
    extra = {"pi_heif": "heic", "rawpy": "raw"}[module]
    with pytest.raises(UnreadablePhoto, match=rf"pip install .*\[{extra}\]"):
        photo.read(tmp_path / name)


@needs_heic
@needs_raw
@pytest.mark.parametrize("name", ["in.heic", "in.dng"])
def test_large_files_are_refused_in_a_sentence(tmp_path, name):
    (tmp_path / name).write_bytes(files.heic(smooth()) if name == "in.heic" else files.dng())
    with pytest.raises(UnreadablePhoto, match="megapixels; the limit"):
        photo.read(tmp_path / name, max_megapixels=0.001)


@needs_heic
@needs_raw
def test_a_batch_names_results_after_the_whole_photo_and_in_a_format_that_lasts(tmp_path):
    inputs = tmp_path / "in"
    inputs.mkdir()
    for name, data in (("a.dng", files.dng()), ("a.heic", files.heic(smooth())), ("a.jpg", b"")):
        (inputs / name).write_bytes(data)
    places = {
        Path(task.source).name: Path(task.output).name
        for task in batch.plan([inputs], tmp_path / "out", RetouchJob(), suffix=".tif")
    }
    assert places == {"a.dng": "a.dng.tif", "a.heic": "a.heic.tif", "a.jpg": "a.jpg"}
    assert [bits_of(f"a{suffix}") for suffix in (".tif", ".png", ".jpg", ".webp")] == [16, 16, 8, 8]
