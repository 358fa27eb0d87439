"""Reading and writing photos: every byte of pixels and metadata that goes in comes out."""

import dataclasses
import io
import os
import struct
import tempfile
from unittest.mock import Mock

import cv2
import files
import numpy as np
import pytest
from PIL import Image, PngImagePlugin
from scenes import textured_photo

from kogao_core import photo
from kogao_core.photo import CannotWrite, RefusedOutput, UnreadablePhoto
from kogao_core.photo.formats import colour, png

XMP = b'<x:xmpmeta xmlns:x="adobe:ns:meta/"><r tiff:Orientation="6" keep="me"/></x:xmpmeta>'
EXIF = files.exif_block(6, 72, 48)


@pytest.fixture
def picture():
    rng = np.random.default_rng(7)
    return np.kron(rng.integers(0, 256, (6, 9, 3)), np.ones((8, 8, 1))).astype(np.uint8)


@pytest.fixture
def deep_picture():
    return np.random.default_rng(8).integers(0, 65536, (13, 17, 3), dtype=np.uint16)


def saved(path, picture, **options):
    Image.fromarray(picture).save(path, **options)
    return path


def inverted(source):
    return np.iinfo(source.pixels.dtype).max - source.pixels


# ---- metadata -------------------------------------------------------------------------------


def test_orientation_of_xmp_counts_where_exif_has_none(tmp_path, picture):
    stored = np.rot90(picture)
    source = photo.read(saved(tmp_path / "in.jpg", stored, xmp=XMP, quality=100, subsampling=0))
    np.testing.assert_allclose(source.pixels, picture, atol=8)
    photo.write(source, inverted(source), tmp_path / "out.jpg")
    again = photo.read(tmp_path / "out.jpg")
    assert again.pixels.shape == picture.shape
    assert again.xmp == XMP
    photo.write(source, inverted(source), tmp_path / "out.png")
    assert photo.read(tmp_path / "out.png").xmp == XMP.replace(b'"6"', b'"1"')


def test_a_damaged_exif_block_is_kept_and_does_not_stop_reading(tmp_path, picture):
    block = EXIF[:30]
    source = photo.read(saved(tmp_path / "in.jpg", picture, exif=block))
    photo.write(source, inverted(source), tmp_path / "out.jpg")
    assert photo.read(tmp_path / "out.jpg").exif == block


def test_png_metadata_after_the_pixels_are_found(tmp_path, deep_picture):
    source = photo.Photo(deep_picture, tmp_path / "none", "PNG", exif=EXIF)
    photo.write(source, deep_picture, tmp_path / "early.png")
    png = (tmp_path / "early.png").read_bytes()
    at = png.index(b"eXIf") - 4
    chunk = png[at : at + 12 + int.from_bytes(png[at : at + 4], "big")]
    late = png.replace(chunk, b"")
    turned = files.chunk(b"eXIf", EXIF[6:])
    again = files.opened(tmp_path / "late.png", late[:-12] + turned + late[-12:])
    assert again.orientation == 6
    assert again.pixels.shape == (17, 13, 3)


# ---- depth, colour and layout ---------------------------------------------------------------


@pytest.mark.parametrize("channels", [1, 3, 4])
def test_numbers_above_white_go_through_a_float_tiff(tmp_path, channels):
    pixels = np.squeeze(np.random.default_rng(9).random((40, 33, channels), np.float32) * 1.5)
    photo.write(photo.Photo(pixels, tmp_path / "none", "PNG"), pixels, tmp_path / "out.tif")
    np.testing.assert_array_equal(photo.read(tmp_path / "out.tif").pixels, pixels)


@pytest.mark.parametrize("suffix", [".png", ".tif", ".webp"])
def test_grey_with_alpha_round_trip(tmp_path, picture, suffix):
    source = photo.read(saved(tmp_path / "in.png", np.ascontiguousarray(picture[..., :2])))
    assert source.pixels.shape == (48, 72, 2)
    source = dataclasses.replace(source, lossless_webp=True)
    photo.write(source, inverted(source), tmp_path / f"out{suffix}")
    again = photo.read(tmp_path / f"out{suffix}").pixels
    np.testing.assert_array_equal(again[..., [0, -1]], 255 - picture[..., :2])


def test_grey_written_as_colour_leaves_its_grey_profile_behind(tmp_path, picture):
    grey = np.ascontiguousarray(picture[..., 0])
    source = photo.Photo(grey, tmp_path / "none", "PNG", icc_profile=b"a profile of grey")
    for suffix, kept in ((".webp", None), (".tif", b"a profile of grey")):
        photo.write(source, grey, tmp_path / f"out{suffix}")
        assert photo.read(tmp_path / f"out{suffix}").icc_profile == kept


def test_palette_becomes_rgb_or_rgba(tmp_path, picture):
    indexed = Image.fromarray(picture).quantize(40)
    indexed.save(tmp_path / "p.png")
    indexed.save(tmp_path / "t.png", transparency=bytes([0, 128] + [255] * 38))
    indexed.save(tmp_path / "p.tif")
    expected = np.asarray(indexed.convert("RGB"))
    for name in ("p.png", "p.tif"):
        np.testing.assert_array_equal(photo.read(tmp_path / name).pixels, expected)
    assert set(np.unique(photo.read(tmp_path / "t.png").pixels[..., 3])) == {0, 128, 255}
    assert photo.read(tmp_path / "t.png").notes == ("converted from a palette to RGB",)


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".tif", ".webp"])
def test_one_pixel_is_a_photo(tmp_path, suffix):
    source = photo.read(saved(tmp_path / f"one{suffix}", np.full((1, 1, 3), 90, np.uint8)))
    photo.write(source, inverted(source), tmp_path / f"out{suffix}")
    np.testing.assert_allclose(photo.read(tmp_path / f"out{suffix}").pixels, 165, atol=3)


@pytest.mark.parametrize(
    ("shape", "dtype"),
    [
        *(((1, 1), np.uint8), ((1, 3000, 3), np.uint16), ((3000, 1), np.uint16)),
        *(((900, 700, 3), np.uint8), ((500, 800, 4), np.uint16)),
    ],
)
def test_decoders_find_the_pixels_of_a_png_whatever_the_number_of_threads(
    tmp_path, monkeypatch, shape, dtype
):
    pixels = np.random.default_rng(5).integers(0, 60_000, shape).astype(dtype)
    source, found = photo.Photo(pixels, tmp_path / "none", "TIFF"), set()
    for threads in (1, 2, 4):
        monkeypatch.setattr(png, "default_threads", lambda threads=threads: threads)
        photo.write(source, pixels, tmp_path / "out.png", force=True)
        found.add((tmp_path / "out.png").read_bytes())
    (data,) = found
    with Image.open(io.BytesIO(data)) as image:
        image.verify()  # the sums of all chunks
    with Image.open(io.BytesIO(data)) as image:
        image.load()  # and that of the stream
    np.testing.assert_array_equal(colour.decoded_deep(data), pixels)


# ---- JPEG -----------------------------------------------------------------------------------


def test_other_sources_become_fine_jpegs(tmp_path, picture):
    source = photo.read(saved(tmp_path / "in.png", picture))
    photo.write(source, picture, tmp_path / "out.jpg")
    with Image.open(tmp_path / "out.jpg") as seen:
        assert [layer[1:3] for layer in seen.layer] == [(1, 1)] * 3
        reference = io.BytesIO()
        Image.fromarray(picture).save(reference, "JPEG", quality=95)
        with Image.open(reference) as fine:
            assert seen.quantization == fine.quantization


def test_opaque_alpha_fits_into_jpeg_and_transparency_does_not(tmp_path, picture):
    opaque = np.dstack([picture, np.full(picture.shape[:2], 255, np.uint8)])
    source = photo.read(saved(tmp_path / "in.png", opaque))
    photo.write(source, opaque, tmp_path / "out.jpg")
    assert photo.read(tmp_path / "out.jpg").pixels.shape == picture.shape
    opaque[0, 0, 3] = 254
    with pytest.raises(RefusedOutput, match="transparency"):
        photo.write(source, opaque, tmp_path / "out2.jpg")


# ---- zero means zero ------------------------------------------------------------------------


def test_a_photo_is_never_written_over(tmp_path, picture):
    path, same = saved(tmp_path / "in.jpg", picture), tmp_path / "IN.jpg"
    before, source = path.read_bytes(), photo.read(path)
    if os.name != "nt":  # there it is the photo anyway
        same.symlink_to(path)
    for target in (path, same):
        with pytest.raises(RefusedOutput, match="the photo itself"):
            photo.write(source, inverted(source), target, force=True)
    assert path.read_bytes() == before


# ---- bad input ------------------------------------------------------------------------------


def assert_refused(path, words, **options):
    with pytest.raises(UnreadablePhoto, match=words) as refusal:
        photo.read(path, **options)
    message = str(refusal.value)
    assert "\n" not in message
    assert str(path) in message


def test_what_cannot_be_read_says_what_to_do(tmp_path):
    assert_refused(tmp_path / "missing.jpg", "doesn't exist; check")
    assert_refused(tmp_path, "is a folder; name")
    bad = tmp_path / "bad.jpg"
    for content, words in (
        (b"", "empty .0 bytes.; copy"),
        (b"this is no photo at all", "not a JPEG.*convert"),
        (b"GIF89a" + bytes(20), "not a JPEG.*convert"),
        (b"II*\0" + bytes(20), "damaged.*copy"),
        (b"\x89PNG\r\n\x1a\n", "not a JPEG|damaged"),
    ):
        bad.write_bytes(content)
        assert_refused(bad, words)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
@pytest.mark.parametrize("number", [1, 5, 8, 32773])
def test_a_tiff_is_compressed_as_its_source_was(tmp_path, dtype, number):
    picture = textured_photo(60, 40, dtype=dtype)
    how = (cv2.IMWRITE_TIFF_COMPRESSION, number)
    cv2.imwrite(str(tmp_path / "in.tif"), picture[..., ::-1], how)
    source = photo.read(tmp_path / "in.tif")
    photo.write(source, picture[::-1].copy(), tmp_path / "out.tif")
    for name in ("in.tif", "out.tif"):
        with Image.open(tmp_path / name) as seen:
            assert seen.tag_v2[259] == number
    np.testing.assert_array_equal(photo.read(tmp_path / "out.tif").pixels, picture[::-1])


def test_a_tiff_from_elsewhere_is_compressed_by_lzw(tmp_path):
    picture = textured_photo(60, 40)
    Image.fromarray(picture).save(tmp_path / "in.tif", compression="jpeg")
    for source in (photo.read(tmp_path / "in.tif"), photo.Photo(picture, tmp_path / "a", "PNG")):
        photo.write(source, picture, tmp_path / "out.tif", force=True)
        with Image.open(tmp_path / "out.tif") as seen:
            assert seen.tag_v2[259] == 5


@pytest.mark.parametrize("kind", ["jpg", "png", "webp", "tif", "deep.png", "deep.tif"])
def test_a_truncated_file_is_refused_without_noise(tmp_path, deep_picture, kind, capfd):
    deep_picture = np.tile(deep_picture, (9, 9, 1))
    path = tmp_path / f"in.{kind}"
    pixels = deep_picture if kind.startswith("deep") else (deep_picture >> 8).astype(np.uint8)
    photo.write(photo.Photo(pixels, path, "PNG"), pixels, path)
    whole = path.read_bytes()
    # An 8-bit PNG that lacks its last bytes alone still holds every pixel.
    tail = 2000 if kind == "png" else 20
    for size in (len(whole) // 10, len(whole) // 2, len(whole) - tail):
        path.write_bytes(whole[:size])
        assert_refused(path, "damaged or incomplete; copy|not a JPEG")
    assert capfd.readouterr() == ("", "")


def test_too_large_is_refused_before_decoding(tmp_path):
    path, pillows = tmp_path / "large.png", Image.MAX_IMAGE_PIXELS
    path.write_bytes(files.empty_png(40_000, 40_000))
    assert_refused(path, "40000 x 40000 px, 1600 megapixels; the limit is 300: raise it")
    path.write_bytes(files.empty_png(14_000, 14_000))  # beyond Pillow's own limit, within ours
    assert_refused(path, "damaged or incomplete")
    assert_refused(path, "the limit is 100", max_megapixels=100)
    path.write_bytes(files.empty_png(300, 200))
    assert_refused(path, "0.06 megapixels; the limit is 0.01", max_megapixels=0.01)
    assert pillows == Image.MAX_IMAGE_PIXELS


def test_a_deep_layout_that_opencv_gets_wrong_is_refused(tmp_path, deep_picture):
    path = tmp_path / "in.tif"
    data = cv2.imencode(".tiff", deep_picture[..., 0])[1].tobytes()
    # Two thirds of the picture would be what happens to lie in memory.
    rgb = struct.pack("<HHIHH", 262, 3, 1, 2, 0)
    path.write_bytes(data.replace(struct.pack("<HHIHH", 262, 3, 1, 1, 0), rgb))
    assert_refused(path, "TIFF of a kind")


def test_numbers_without_a_profile_are_said_to_be_seen_as_srgb(tmp_path, deep_picture):
    floating = deep_picture[..., 0].astype(np.float32) / 65535.0
    assert photo.read(saved(tmp_path / "with.tif", floating, icc_profile=files.SRGB)).notes == ()
    bare = photo.read(saved(tmp_path / "bare.tif", floating))
    assert bare.icc_profile is None
    (note,) = bare.notes
    assert "seen as sRGB" in note
    assert note in photo.write(bare, 0.5 * bare.pixels, tmp_path / "changed.tif")
    assert photo.write(bare, bare.pixels, tmp_path / "same.tif") == ""


# ---- bad output -----------------------------------------------------------------------------


def test_outputs_that_are_refused_leave_nothing_behind(tmp_path, picture, deep_picture):
    source = photo.read(saved(tmp_path / "in.png", picture))
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    (tmp_path / "folder.png").mkdir()
    floating = deep_picture.astype(np.float32)
    wide = np.zeros((1, 70_000, 3), np.uint8)
    for name, pixels, words, kind in (
        ("in.png", picture, "exists; choose", RefusedOutput),
        ("out.gif", picture, "must end in", RefusedOutput),
        ("out", picture, "must end in", RefusedOutput),
        ("folder.png", picture, "is a folder; name", RefusedOutput),
        ("missing/out.png", picture, "doesn't exist; make it", CannotWrite),
        ("out.jpg", deep_picture, "16-bit photo; write it as .png", RefusedOutput),
        ("out.webp", deep_picture, "16-bit photo; write it as .png", RefusedOutput),
        ("out.png", floating, "32-bit float photo; write it as .tif", RefusedOutput),
        ("out.jpg", wide, "more than 65500", RefusedOutput),
        ("out.webp", wide, "more than 16383", RefusedOutput),
    ):
        with pytest.raises(kind, match=words) as refusal:
            photo.write(source, pixels, tmp_path / name)
        assert "\n" not in str(refusal.value)
    (tmp_path / "folder.png").rmdir()
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_a_failing_disk_leaves_the_old_file_whole(tmp_path, picture, monkeypatch):
    source = photo.read(saved(tmp_path / "in.png", picture))
    (path := tmp_path / "out.png").write_bytes(b"before")
    monkeypatch.setattr(os, "fsync", Mock(side_effect=OSError(28, "No space left on device")))
    with pytest.raises(CannotWrite, match=r"No space left on device.*make room"):
        photo.write(source, inverted(source), path, force=True)
    assert path.read_bytes() == b"before"
    assert set(tmp_path.iterdir()) == {path, source.path}


def test_metadata_too_long_for_jpeg_is_a_sentence(tmp_path, picture):
    text = PngImagePlugin.PngInfo()
    text.add_itxt("XML:com.adobe.xmp", "x" * 70_000)
    source = photo.read(saved(tmp_path / "in.png", picture, pnginfo=text))
    with pytest.raises(CannotWrite, match=r"can't be encoded as JPEG.*write it as"):
        photo.write(source, picture, tmp_path / "out.jpg")
    assert not (tmp_path / "out.jpg").exists()


@pytest.mark.parametrize("exif", [b"Exif\0\0nonsense", b"Exif\0\0II*\0\x08\0\0\0\xff\xff"])
def test_an_exif_block_that_no_tiff_can_hold_is_left_out_with_a_word(tmp_path, picture, exif):
    source = photo.read(saved(tmp_path / "in.jpg", picture))
    said = photo.write(dataclasses.replace(source, exif=exif), picture, tmp_path / "out.tif")
    if exif.endswith(b"nonsense"):
        assert "EXIF block is damaged, and TIFF can't hold it" in said
    np.testing.assert_array_equal(photo.read(tmp_path / "out.tif").pixels, picture)


@pytest.mark.parametrize(
    ("dtype", "compression", "name"),
    [(np.uint16, 50000, "zstd"), (np.uint8, 50001, "webp"), (np.float32, 7, "jpeg"),
     (np.uint8, 34712, "34712")],
)  # fmt: skip
def test_a_compression_that_nobody_reads_is_no_damage(tmp_path, dtype, compression, name):
    path = tmp_path / "in.tif"
    data = files.tiff(np.zeros((9, 9, 3), dtype))
    entry = struct.pack("<HHI", 259, 3, 1)
    at = data.index(entry) + len(entry)
    path.write_bytes(data[:at] + struct.pack("<H", compression) + data[at + 2 :])
    assert_refused(path, rf"compression that Kogao doesn't read \({name}\); save it uncomp")


def test_a_full_temporary_folder_is_no_trouble(tmp_path, picture, monkeypatch):
    source = photo.read(saved(tmp_path / "in.jpg", picture))
    pixels = source.pixels.copy()
    pixels[:8, :8] ^= 255
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "nowhere"))
    assert "of the JPEG unchanged" in photo.write(source, pixels, tmp_path / "out.jpg")


@pytest.mark.skipif(os.name == "nt", reason="POSIX files")
def test_a_name_may_be_as_long_as_the_file_system_takes(tmp_path, picture):
    path = saved(tmp_path / ("x" * 251 + ".png"), picture)
    photo.write(photo.read(path), picture, tmp_path / ("y" * 251 + ".jpg"))
    with pytest.raises(CannotWrite, match=r"name too long.*a shorter name"):
        photo.write(photo.read(path), picture, tmp_path / ("y" * 252 + ".jpg"))


def test_a_function_that_a_library_lacks_is_no_fault_of_the_photo(tmp_path, monkeypatch):
    path = tmp_path / "deep.png"
    cv2.imwrite(str(path), np.full((9, 9, 3), 40_000, np.uint16))
    monkeypatch.delattr(cv2, "imdecode")
    with pytest.raises(AttributeError, match="cv2"):
        photo.read(path)
