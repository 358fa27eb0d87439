"""Blocks of a JPEG in which nothing changed keep their coefficients, bit for bit."""

import sys
from concurrent.futures import ThreadPoolExecutor

import cv2
import files
import jpeglib
import numpy as np
import pytest
from PIL import Image, ImageFile
from scenes import textured_photo
from systems import needs_linux

from kogao_core import photo
from kogao_core.photo.formats.jpeg import JPEG
from kogao_core.photo.jpeg import coefficients
from kogao_core.photo.writing import encode

SIZES = [(157, 107), (160, 96), (33, 17)]


def jpeg_file(path, pixels, **options):
    Image.fromarray(pixels).save(path, "JPEG", quality=88, **options)
    return path


ImageFile.MAXBLOCK = 1 << 20  # Pillow's own guess is too small for progressive RGB
RARE = {
    "4:1:1": cv2.IMWRITE_JPEG_SAMPLING_FACTOR_411,
    "4:4:0": cv2.IMWRITE_JPEG_SAMPLING_FACTOR_440,
}


def file_of_kind(path, pixels, kind, orientation=1, *, progressive=False):
    """Write a grey JPEG, one of RGB, or one whose chroma is subsampled so."""
    exif = Image.Exif()
    exif[0x112] = orientation
    options = {"progressive": progressive, "exif": exif}
    if kind == "grey":
        return jpeg_file(path, pixels[..., 0].copy() if pixels.ndim > 2 else pixels, **options)
    if kind not in RARE:
        how = {"keep_rgb": True} if kind == "RGB" else {"subsampling": kind}
        return jpeg_file(path, pixels, **how, **options)
    flags = [cv2.IMWRITE_JPEG_SAMPLING_FACTOR, RARE[kind], cv2.IMWRITE_JPEG_QUALITY, 88]
    flags += [cv2.IMWRITE_JPEG_PROGRESSIVE, int(progressive)]
    data = cv2.imencode(".jpg", pixels[..., ::-1], flags)[1].tobytes()
    path.write_bytes(data[:20] + files.segment(0xE1, exif.tobytes()) + data[20:])
    return path


def edited(source):
    """Return the photo with a patch inverted."""
    pixels = source.pixels.copy()
    patch = slice(5, max(8, source.height // 3)), slice(9, max(12, source.width // 3))
    pixels[patch] = 255 - pixels[patch]
    return pixels


def lying(upright, orientation):
    """Return upright pixels as a file holds them, by Pillow."""
    back = {2: 0, 3: 3, 4: 1, 5: 5, 6: 2, 7: 6, 8: 4}.get(orientation)
    picture = Image.fromarray(upright)
    return np.asarray(picture if back is None else picture.transpose(Image.Transpose(back)))


def components(path):
    """Return each component's coefficients with its blocks per unit, down and along."""
    jpeg = jpeglib.read_dct(str(path))
    if jpeg.Cb is None:
        return [(jpeg.Y, (1, 1))]
    return list(zip((jpeg.Y, jpeg.Cb, jpeg.Cr), jpeg.samp_factor.tolist(), strict=True))


@pytest.mark.parametrize(
    ("size", "orientation"),
    [*zip(SIZES, (1, 1, 1), strict=True), *((SIZES[0], turn) for turn in range(2, 9))],
)
@pytest.mark.parametrize("progressive", [False, True])
@pytest.mark.parametrize("kind", ["4:4:4", "4:2:2", "4:2:0", "grey", "RGB", *RARE])
def test_units_without_a_changed_pixel_keep_their_coefficients(
    tmp_path, kind, progressive, size, orientation
):
    path = file_of_kind(
        tmp_path / "in.jpg", textured_photo(*size, 3), kind, orientation, progressive=progressive
    )
    source = photo.read(path)
    pixels = edited(source)
    said = photo.write(source, pixels, tmp_path / "out.jpg")
    assert "of the JPEG unchanged" in said
    before, after = components(path), components(tmp_path / "out.jpg")
    height, width = (8 * max(factor[axis] for _, factor in before) for axis in (0, 1))
    differs = (pixels != source.pixels).reshape(*source.pixels.shape[:2], -1).any(axis=2)
    differs = lying(differs, orientation)
    rows, columns = (
        -(-side // unit) for side, unit in zip(differs.shape, (height, width), strict=True)
    )
    padded = np.zeros((rows * height, columns * width), bool)
    padded[: differs.shape[0], : differs.shape[1]] = differs
    units = padded.reshape(rows, height, columns, width).any(axis=(1, 3))
    assert units.any()
    assert not units.all()
    for (blocks, (down, along)), (written, _) in zip(before, after, strict=True):
        mine = units.repeat(down, 0).repeat(along, 1)[: blocks.shape[0], : blocks.shape[1]]
        np.testing.assert_array_equal(written[~mine], blocks[~mine])
        assert (written[mine] != blocks[mine]).any()
    with Image.open(tmp_path / "out.jpg") as seen, Image.open(path) as first:
        assert [one[1:] for one in seen.layer] == [one[1:] for one in first.layer]
    file_of_kind(tmp_path / "plain.jpg", lying(pixels, orientation), kind, orientation)
    kept_error, plain_error = (
        np.abs(photo.read(tmp_path / name).pixels.astype(int) - pixels).mean()
        for name in ("out.jpg", "plain.jpg")
    )
    assert kept_error < plain_error + 0.5


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("kind", ["4:4:4", "4:2:0"])
def test_changed_units_are_what_compressing_the_whole_picture_gives(tmp_path, kind, size):
    source = photo.read(jpeg_file(tmp_path / "in.jpg", textured_photo(*size, 3), subsampling=kind))
    pixels = source.pixels.copy()
    pixels[-20:, -30:] ^= 255  # to the border, where units are filled up
    photo.write(source, pixels, tmp_path / "out.jpg")
    (tmp_path / "whole.jpg").write_bytes(b"".join(encode(source, pixels, JPEG)))
    written, whole, first = (
        components(tmp_path / name) for name in ("out.jpg", "whole.jpg", "in.jpg")
    )
    for (blocks, (down, along)), (expected, _), (old, _) in zip(written, whole, first, strict=True):
        corner = slice(-down, None), slice(-along, None)
        # The encoder rounds colours to whole numbers first.
        np.testing.assert_allclose(blocks[corner], expected[corner], atol=1)
        assert (blocks[corner] != expected[corner]).mean() < 0.08
        assert (blocks[corner] != old[corner]).any()


def scan_of(path):
    data = path.read_bytes()
    at = data.index(b"\xff\xda")
    return data[at + 2 + int.from_bytes(data[at + 2 : at + 4], "big") :]


def test_usual_codes_stay_and_with_them_every_bit_before_the_change(tmp_path):
    picture, options = textured_photo(320, 208, 3), {"subsampling": "4:2:0"}
    source = photo.read(jpeg_file(tmp_path / "in.jpg", picture, **options))
    pixels = source.pixels.copy()
    pixels[160:] = 255 - pixels[160:]  # ten rows of units stay
    photo.write(source, pixels, tmp_path / "out.jpg")
    above = scan_of(jpeg_file(tmp_path / "above.jpg", picture[:160], **options))[:-3]  # the end
    assert scan_of(tmp_path / "out.jpg").startswith(above)
    assert len(above) > 1000


@pytest.mark.parametrize("options", [{"optimize": True}, {"progressive": True}])
def test_other_codes_are_made_anew_and_no_longer(tmp_path, options):
    path = jpeg_file(tmp_path / "in.jpg", textured_photo(320, 208, 3), **options)
    usual = jpeg_file(tmp_path / "usual.jpg", textured_photo(320, 208, 3))
    for one in (path, usual):
        source = photo.read(one)
        pixels = source.pixels.copy()
        pixels[:8, :8] = 0
        photo.write(source, pixels, tmp_path / f"out-{one.name}")
    assert len(scan_of(tmp_path / "out-in.jpg")) < len(scan_of(tmp_path / "out-usual.jpg"))


def test_a_frame_that_the_library_could_take_otherwise_is_refused(tmp_path):
    """It writes as many blocks into our arrays as it reads there itself."""
    data = jpeg_file(tmp_path / "in.jpg", textured_photo(160, 120)).read_bytes()
    assert coefficients.read(data, tmp_path / "read").frame.unit_px == (16, 16)
    at = data.index(b"\xff\xc0")
    for damaged in (
        data[: at + 3] + b"\x12" + data[at + 4 :],  # another length
        data[: at + 7] + bytes(2) + data[at + 9 :],  # no width
        data[: at + 11] + bytes(1) + data[at + 12 :],  # no sampling factors
        data[: at + 19] + data[at:],  # two frames
    ):
        with pytest.raises(coefficients.CannotKeepBlocks, match="can't be read"):
            coefficients.read(damaged, tmp_path / "read")


def test_headers_come_from_the_new_file_once(tmp_path):
    icc, exif = b"p" * 70_000, Image.Exif()
    exif[0x13B] = "Me!"
    path = jpeg_file(tmp_path / "in.jpg", textured_photo(160, 120), icc_profile=icc, exif=exif)
    source = photo.read(path)
    photo.write(source, edited(source), tmp_path / "out.jpg")
    data = (tmp_path / "out.jpg").read_bytes()
    assert data.count(b"JFIF\0") == 1
    assert data.count(b"Exif\0\0") == 1
    assert photo.read(tmp_path / "out.jpg").icc_profile == icc
    with Image.open(tmp_path / "out.jpg") as seen:
        assert seen.getexif()[0x13B] == "Me!"


def test_a_source_that_changed_since_is_not_trusted(tmp_path):
    path = jpeg_file(tmp_path / "in.jpg", textured_photo(160, 120))
    source = photo.read(path)
    jpeg_file(path, 255 - textured_photo(168, 120))
    said = photo.write(source, edited(source), tmp_path / "out.jpg")
    assert "has changed since it was read" in said
    path.unlink()
    assert "is gone" in photo.write(source, edited(source), tmp_path / "out2.jpg")
    error = np.abs(photo.read(tmp_path / "out2.jpg").pixels.astype(int) - edited(source))
    assert error.mean() < 8.0


@pytest.mark.parametrize("kind", ["grey", "RGB", "4:4:4", "4:2:0", "4:4:0"])
def test_threads_write_the_same_file(tmp_path, monkeypatch, kind):
    path = file_of_kind(tmp_path / "in.jpg", textured_photo(157, 200), kind)
    whole = coefficients.read(path.read_bytes(), tmp_path / "copy")
    assert whole.has_usual_codes
    for open_rows in ([], [3], [-1]):  # rows whose last block ends without "end of block"
        for row in open_rows:
            whole.planes[-1][row, -1, -1] = 1
        written = set()
        for threads in (1, 2, 3, 64):
            monkeypatch.setattr(coefficients, "default_threads", lambda count=threads: count)
            written.add(coefficients.write(whole, tmp_path))
        (data,) = written
        again = coefficients.read(data, tmp_path / "copy")
        for plane, other in zip(whole.planes, again.planes, strict=True):
            np.testing.assert_array_equal(plane, other)


@needs_linux("reads ahead on Linux only")
def test_blocks_read_ahead_are_used_once_and_for_the_same_file_only(tmp_path, monkeypatch):
    path = jpeg_file(tmp_path / "in.jpg", textured_photo(160, 120))
    other = jpeg_file(tmp_path / "other.jpg", textured_photo(160, 120, seed=2)).read_bytes()
    # Pytest's own handler of faults keeps stderr from being captured.
    monkeypatch.setattr(coefficients, "if_unsaid", lambda work: work())
    with ThreadPoolExecutor(1) as pool:
        sound, refused = pool.submit(photo.read, path), pool.submit(photo.read, tmp_path / "none")
        coefficients.read_ahead(path, pool, sound)
        coefficients.read_ahead(tmp_path / "absent.jpg", pool, sound)
        coefficients.read_ahead(path, pool, refused)
    plain, reads = coefficients._read, []
    monkeypatch.setattr(coefficients, "_read", lambda *one: reads.append(one) or plain(*one))
    data = path.read_bytes()
    found = [coefficients.read(one, tmp_path / "copy") for one in (other, data, data)]
    assert [one[0] for one in reads] == [other, data]
    for ahead, again in zip(found[1].planes, found[2].planes, strict=True):
        np.testing.assert_array_equal(ahead, again)
    coefficients._ahead.clear()


def test_an_rgb_jpeg_stays_one_for_every_reader(tmp_path):
    path = file_of_kind(tmp_path / "in.jpg", textured_photo(160, 120), "RGB")
    source = photo.read(path)
    photo.write(source, edited(source), tmp_path / "out.jpg")
    data = (tmp_path / "out.jpg").read_bytes()
    assert b"JFIF" not in data
    assert data.count(b"Adobe\0\x64\0\0\0\0\0") == 1
    with Image.open(tmp_path / "out.jpg") as seen:
        assert seen.info["adobe_transform"] == 0


def with_segment(path, kind, body):
    """Put a segment in the place of the JFIF header."""
    data = path.read_bytes()
    end = 4 + int.from_bytes(data[4:6], "big")
    segment = bytes([0xFF, kind]) + (len(body) + 2).to_bytes(2, "big") + body
    path.write_bytes(data[:2] + segment + data[end:])


def test_colours_are_told_by_adobes_transform_whatever_follows_it(tmp_path):
    path = jpeg_file(tmp_path / "in.jpg", textured_photo(160, 120))
    with_segment(path, 0xEE, b"Adobe\0\x64\0\0\0\0\1" + bytes(19))
    source = photo.read(path)
    assert "of the JPEG unchanged" in photo.write(source, edited(source), tmp_path / "out.jpg")


def test_coarse_tables_of_16_bits_give_a_file_that_opens(tmp_path):
    table = [40 * (1 + k // 8) for k in range(64)]
    path = tmp_path / "in.jpg"
    Image.fromarray(textured_photo(160, 120)).save(path, qtables=[table, table])
    assert b"\xff\xc1\0\x11" in path.read_bytes()
    source = photo.read(path)
    said = photo.write(source, edited(source), tmp_path / "out.jpg")
    assert "of the JPEG unchanged" in said
    with Image.open(path) as first, Image.open(tmp_path / "out.jpg") as seen:
        assert seen.layer == first.layer
    again = photo.read(tmp_path / "out.jpg").pixels
    np.testing.assert_array_equal(again[-8:], source.pixels[-8:])


def test_a_grey_jpeg_keeps_its_blocks_whatever_factors_it_names(tmp_path):
    path = jpeg_file(tmp_path / "in.jpg", textured_photo(161, 119, 3)[..., 0].copy())
    data = path.read_bytes()
    at = data.index(b"\xff\xc0") + 11
    assert data[at] == 0x11
    source = files.opened(path, data[:at] + b"\x22" + data[at + 1 :])
    said = photo.write(source, edited(source), tmp_path / "out.jpg")
    assert "of the JPEG unchanged" in said
    ((before, _),), ((after, _),) = components(path), components(tmp_path / "out.jpg")
    np.testing.assert_array_equal(after[8:], before[8:])


class OpensAsciiOnly:
    """jpeglib's C library on Windows, which takes names in the system's code page."""

    def __init__(self, library):
        self.library = library

    def read_jpeg_dct(self, name, *others):
        return name.isascii() and self.library.read_jpeg_dct(name, *others)

    def write_jpeg_dct(self, source, name, *others):
        return name.isascii() and self.library.write_jpeg_dct(source, name, *others)


@pytest.mark.parametrize("temporary", ["short", "Émile"])
def test_blocks_stay_where_the_library_opens_ascii_paths_only(tmp_path, monkeypatch, temporary):
    folder, ascii_folder = tmp_path / "写真 é", tmp_path / "ProgramData"
    for one in (folder, ascii_folder, tmp_path / temporary):
        one.mkdir()
    library = OpensAsciiOnly(coefficients._library())
    monkeypatch.setattr(coefficients, "_library", lambda: library)
    monkeypatch.setattr(coefficients, "gettempdir", lambda: str(tmp_path / temporary))
    monkeypatch.setenv("PROGRAMDATA", str(ascii_folder))
    monkeypatch.setattr(sys, "platform", "win32")
    source = photo.read(jpeg_file(folder / "写真 一.jpg", textured_photo(160, 120)))
    note = photo.write(source, edited(source), folder / "b 二.jpg")
    assert "% of the JPEG unchanged" in str(note)
    assert sorted(one.name for one in folder.iterdir()) == ["b 二.jpg", "写真 一.jpg"]
    assert not list(ascii_folder.iterdir())


def test_a_jpeg_is_compressed_again_without_jpeglib(tmp_path, monkeypatch):
    source = photo.read(jpeg_file(tmp_path / "in.jpg", textured_photo(160, 120)))
    coefficients._library.cache_clear()
    monkeypatch.setattr(coefficients, "find_spec", lambda _: None)
    note = photo.write(source, edited(source), tmp_path / "out.jpg")
    assert "compressed again: jpeglib isn't installed" in str(note)
    assert photo.read(tmp_path / "out.jpg").pixels.shape == source.pixels.shape


@needs_linux("reads ahead on Linux only")
def test_blocks_of_a_photo_that_failed_are_dropped_with_the_next_photo(tmp_path, monkeypatch):
    pictures = [textured_photo(90, 60, seed=seed) for seed in (1, 2)]
    paths = [jpeg_file(tmp_path / f"{k}.jpg", one) for k, one in enumerate(pictures)]
    # Pytest's own handler of faults keeps stderr from being captured.
    monkeypatch.setattr(coefficients, "if_unsaid", lambda work: work())
    for path in paths:
        coefficients.read_first(path)
    assert len(coefficients._ahead) == 1
    first, second = (path.read_bytes() for path in paths)
    monkeypatch.setattr(coefficients, "_read", lambda *_: None)
    assert coefficients.read(first, tmp_path / "copy") is None
    assert coefficients.read(second, tmp_path / "copy") is not None
    assert not coefficients._ahead
