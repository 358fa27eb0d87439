"""Good files that few programs write: read, or refused in the right sentence; no silent loss."""

from __future__ import annotations

import io
import json
import re
import shutil
import struct
import subprocess
import zlib
from pathlib import Path

import cv2
import files
import metadata_cases
import numpy as np
import pytest
from PIL import Image, PngImagePlugin
from scenes import textured_photo

from kogao_core import photo
from kogao_core.photo import in_place, profiles
from kogao_core.photo.export import Export
from kogao_core.photo.metadata import photoshop
from kogao_core.photo.originals import Originals

RGB = textured_photo(64, 48)
GREY = np.ascontiguousarray(RGB[..., 0])
PAGE = Path(__file__).parents[2] / "docs" / "fidelity.md"
XMP = files.XMP.format(1).encode()


def read(tmp_path, data, name):
    return files.opened(tmp_path / name, data)


def written(tmp_path, source, name, *, force=True):
    note = photo.write(source, np.invert(source.pixels), tmp_path / name, force=force)
    return note, photo.read(tmp_path / name)


def jpeg(*more, **options):
    data = files.saved(RGB, "JPEG", quality=90, **options)
    return data[:20] + b"".join(more) + data[20:]


# -- read -------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["in.nef", "in.CR2", "in.dng", "in.raf"])
@pytest.mark.parametrize("form", ["JPEG", "PNG", "WEBP"])
def test_the_content_of_a_file_with_a_raw_ending_counts(tmp_path, name, form):
    source = read(tmp_path, files.saved(RGB, form), name)
    assert source.format == form
    with pytest.raises(photo.RefusedOutput, match="by its content; name it"):
        in_place.check_in_place(source)


@pytest.mark.parametrize("bits", [10, 12])
def test_grey_heic_of_more_bits_is_read(tmp_path, bits):
    heif = pytest.importorskip("pillow_heif")
    deep = GREY.astype(np.uint16) * 257
    before, heif.options.SAVE_HDR_TO_12_BIT = heif.options.SAVE_HDR_TO_12_BIT, bits == 12
    try:
        data = files.heic(deep)
    finally:
        heif.options.SAVE_HDR_TO_12_BIT = before
    source = read(tmp_path, data, "in.heic")
    assert source.pixels.shape == deep.shape
    assert np.abs(source.pixels.astype(int) - deep).mean() < 1500
    np.testing.assert_array_equal(written(tmp_path, source, "o.png")[1].pixels, ~source.pixels)


def test_white_of_a_heic_with_10_bits_is_white(tmp_path):
    pytest.importorskip("pillow_heif")
    white = np.full((64, 64, 3), 65535, np.uint16)
    assert read(tmp_path, files.heic(white), "in.heic").pixels.min() == 65535


@pytest.mark.parametrize("coding", [b"unci", b"av01", b"j2k1", b"vvc1"])
def test_a_heic_of_another_coding_is_not_called_damaged(tmp_path, coding):
    pytest.importorskip("pillow_heif")
    data = files.heic(RGB)
    item = re.search(rb"infe.{8}(hvc1)", data, re.DOTALL).start(1)
    with pytest.raises(photo.UnreadablePhoto, match=f"a rare kind .{coding.decode()}.; save it"):
        read(tmp_path, data[:item] + coding + data[item + 4 :], "in.heic")


@pytest.mark.parametrize("body", [b"", b"JFIF\0", b"JFIF\0\1", b"JFIF\0\1\1\0\0"])
def test_a_short_jfif_segment_does_not_stop_reading(tmp_path, body):
    plain = files.saved(RGB, "JPEG")
    source = read(tmp_path, plain[:2] + files.segment(0xE0, body) + plain[20:], "in.jpg")
    np.testing.assert_array_equal(source.pixels, np.asarray(Image.open(io.BytesIO(plain))))
    assert "of the JPEG unchanged" in written(tmp_path, source, "o.jpg")[0]


def test_png_texts_above_1_mb_are_read_and_kept_up_to_a_stated_limit(tmp_path):
    text = b"Comment\0\0" + zlib.compress(b"0123456789abcdef" * 130_000)
    data = files.saved(RGB, "PNG")
    chunk = files.chunk(b"zTXt", text)
    source = read(tmp_path, data[:33] + chunk + data[33:], "in.png")
    written(tmp_path, source, "o.png")
    assert chunk in (tmp_path / "o.png").read_bytes()
    bomb = files.chunk(b"zTXt", b"Comment\0\0" + zlib.compress(bytes(17 << 20)))
    with pytest.raises(photo.UnreadablePhoto):
        read(tmp_path, data[:33] + bomb + data[33:], "bomb.png")
    assert "at most 16 MiB" in " ".join(PAGE.read_text(encoding="utf-8").split())
    assert PngImagePlugin.MAX_TEXT_CHUNK == 1 << 20  # for others in this process


@pytest.mark.parametrize("suffix", [".jpg", ".tif", ".webp", ".png"])
def test_a_profile_above_1_mb_becomes_a_png_that_everybody_reads(tmp_path, suffix):
    noise = np.random.default_rng(1).integers(0, 256, 400_000, np.uint8).repeat(4).tobytes()
    tags = {**profiles._tags(files.SRGB), b"DevD": b"data\0\0\0\0" + noise}
    icc = profiles._assembled(files.SRGB, tags)
    form = {".jpg": "JPEG", ".tif": "TIFF", ".webp": "WEBP", ".png": "PNG"}[suffix]
    source = read(tmp_path, files.saved(RGB, form, icc_profile=icc), f"in{suffix}")
    assert source.icc_profile == icc
    for name in ("o.png", "again.png"):
        note, source = written(tmp_path, source, name)
        assert note == ""
        assert source.icc_profile == icc
        with Image.open(tmp_path / name) as image:  # with Pillow's own limit
            image.load()
            small = profiles._tags(image.info["icc_profile"])
        assert {one: tags[one] for one in small} == small
        assert {b"rXYZ", b"gTRC", b"wtpt", b"chad"} <= small.keys()
        assert cv2.imread(str(tmp_path / name)) is not None  # libpng


def packed(pixels, bits):
    """Return rows of channels with fewer than 8 bits."""
    rows = np.unpackbits(pixels.reshape(len(pixels), -1, 1), axis=2)[..., 8 - bits :]
    return np.packbits(rows.reshape(len(pixels), -1), axis=1).tobytes()


def tiff(pixels, bits, meaning, more=None):
    """Return an uncompressed TIFF file; pixels are in the lowest bits of uint8."""
    samples = 1 if pixels.ndim == 2 else pixels.shape[2]
    data = packed(pixels, bits)
    tags = {
        256: (4, pixels.shape[1]), 257: (4, len(pixels)), 258: (3, [bits] * samples), 259: (3, 1),
        262: (3, meaning), 273: (4, 8), 277: (3, samples), 278: (4, len(pixels)),
        279: (4, len(data)), 284: (3, 1), **(more or {}),
    }  # fmt: skip
    data += bytes(len(data) % 2)
    return b"II*\0" + struct.pack("<I", 8 + len(data)) + data + files.directory(tags, 8 + len(data))


RARE = {
    "2 bits": tiff(RGB >> 6, 2, 2),
    "4 bits": tiff(RGB >> 4, 4, 2),
    "6 bits": tiff(GREY >> 2, 6, 1),
    "Lab and alpha": tiff(np.dstack([RGB, GREY]), 8, 8, {338: (3, 2)}),
    "signed": tiff(GREY, 8, 1, {339: (3, 2)}),
    "signed RGB": tiff(RGB, 8, 2, {339: (3, [2, 2, 2])}),
}


@pytest.mark.parametrize("data", RARE.values(), ids=RARE)
def test_a_tiff_of_a_rare_depth_is_called_a_tiff(tmp_path, data):
    with pytest.raises(photo.UnreadablePhoto, match="is a TIFF of a kind that Kogao doesn't read"):
        read(tmp_path, data, "in.tif")


def test_half_floats_are_refused_as_the_page_says(tmp_path):
    half = (GREY / 255).astype("<f2").tobytes()
    tags = {
        256: (4, 64), 257: (4, 48), 258: (3, 16), 259: (3, 1), 262: (3, 1), 273: (4, 8),
        277: (3, 1), 278: (4, 48), 279: (4, len(half)), 339: (3, 3),
    }  # fmt: skip
    place = 8 + len(half)
    data = b"II*\0" + struct.pack("<I", place) + half + files.directory(tags, place)
    with pytest.raises(photo.UnreadablePhoto, match="TIFF of a kind"):
        read(tmp_path, data, "in.tif")
    page = PAGE.read_text(encoding="utf-8")
    read_row = next(one for one in page.splitlines() if one.startswith("| read |"))
    assert "16 float" not in read_row
    assert "half floats" in page.partition("## What is refused")[2]


@pytest.mark.parametrize("channels", [3, 4])
@pytest.mark.parametrize("within", [False, True])
def test_the_still_of_an_animated_png_is_read(tmp_path, channels, within):
    """`within`: the still is the first picture of the animation."""
    red, blue = (np.zeros((20, 30, channels), np.uint16) for _ in range(2))
    red[..., 0] = blue[..., 2] = 60000
    if channels == 4:
        red[..., 3] = blue[..., 3] = 65535

    def packed_rows(pixels):
        rows = pixels.astype(">u2").reshape(20, -1)
        return zlib.compress(b"".join(b"\0" + row.tobytes() for row in rows))

    def frame(number):
        return files.chunk(b"fcTL", struct.pack(">5I2H2B", number, 30, 20, 0, 0, 1, 10, 0, 0))

    kind = 2 if channels == 3 else 6
    parts = [
        files.chunk(b"IHDR", struct.pack(">IIBBBBB", 30, 20, 16, kind, 0, 0, 0)),
        files.chunk(b"acTL", struct.pack(">II", 2 + within, 0)),
        *([frame(0)] if within else []),
        files.chunk(b"IDAT", packed_rows(red)),
        frame(int(within)),
        files.chunk(b"fdAT", struct.pack(">I", 1 + within) + packed_rows(blue)),
        frame(2 + within),
        files.chunk(b"fdAT", struct.pack(">I", 3 + within) + packed_rows(blue // 2)),
        files.chunk(b"IEND", b""),
    ]
    source = read(tmp_path, b"\x89PNG\r\n\x1a\n" + b"".join(parts), "in.png")
    np.testing.assert_array_equal(source.pixels, red)
    assert "not kept: further pictures" in written(tmp_path, source, "o.png")[0]


# -- JPEGs with rare factors ------------------------------------------------------------------


def sampled(factors, size=(72, 96)):
    """Return a JPEG with any sampling factors: flat blocks, one scan for each component."""
    height, width = size
    most = [max(one[axis] for one in factors) for axis in (0, 1)]
    sizes = [(-(-height * down // most[0]), -(-width * along // most[1])) for along, down in
             ((one[1], one[0]) for one in factors)]  # fmt: skip
    frame = struct.pack(">BHHB", 8, height, width, len(factors))
    for k, (down, along) in enumerate(factors, 1):
        frame += bytes([k, along << 4 | down, 0])
    lengths = bytes([0, 0, 0, 0, 12, *[0] * 12])  # twelve codes of 4 bits
    symbols = bytes(range(12))
    data = b"\xff\xd8" + files.segment(0xDB, b"\0" + bytes([8] * 64))
    data += files.segment(0xC0, frame)
    data += files.segment(0xC4, b"\0" + lengths[1:] + symbols)
    data += files.segment(0xC4, b"\x10" + lengths[1:] + symbols)
    rng = np.random.default_rng(4)
    for k, (rows, columns) in enumerate(sizes, 1):
        bits, last = "", 0
        for value in rng.integers(-60, 60, -(-rows // 8) * -(-columns // 8)).tolist():
            off, last = value - last, value
            count = abs(off).bit_length()
            bits += f"{count:04b}" + (
                f"{off if off > 0 else off + 2**count - 1:0{count}b}" if count else ""
            )
            bits += "0000"  # end of block
        bits += "1" * (-len(bits) % 8)
        scan = bytes(int(bits[at : at + 8], 2) for at in range(0, len(bits), 8))
        data += files.segment(0xDA, bytes([1, k, 0, 0, 63, 0])) + scan.replace(b"\xff", b"\xff\0")
    return data + b"\xff\xd9"


@pytest.mark.parametrize("luma", [(4, 4), (3, 3), (4, 2), (1, 4), (3, 1), (2, 2), (1, 1)])
@pytest.mark.parametrize("chroma", [(1, 1), (1, 2)])
def test_a_jpeg_of_any_factors_is_saved_also_in_place(tmp_path, luma, chroma):
    if luma[0] % chroma[0] or luma[1] % chroma[1]:
        pytest.skip("a fraction, which no decoder reads")
    data = sampled([luma, chroma, chroma])
    source = read(tmp_path, data, "in.jpg")
    np.testing.assert_array_equal(source.pixels, np.asarray(Image.open(io.BytesIO(data))))
    pixels = source.pixels.copy()
    pixels[:16, :16] = 128
    note = photo.write(source, pixels, tmp_path / "o.jpg")
    assert "of the JPEG unchanged" in note or "compressed again: its blocks can't be" in note
    off = np.abs(photo.read(tmp_path / "o.jpg").pixels.astype(int) - pixels)
    assert off.mean() < 6
    store = Originals(tmp_path / "store")
    assert photo.write_in_place(source, pixels, store)
    store.restore(tmp_path / "in.jpg")
    assert (tmp_path / "in.jpg").read_bytes() == data


def test_a_source_that_cannot_be_copied_is_no_matter_of_room(tmp_path, monkeypatch):
    from kogao_core.photo.jpeg import coefficients

    class Library:
        def write_jpeg_dct(self, *_):
            return 0

        read_jpeg_dct = coefficients._library().read_jpeg_dct

    monkeypatch.setattr(coefficients, "_library", Library)
    source = read(tmp_path, jpeg(), "in.jpg")
    note, _ = written(tmp_path, source, "o.jpg")
    assert "compressed again: its blocks can't be written" in note


# -- nothing lost without a word --------------------------------------------------------------


@pytest.mark.parametrize("sign", [b"8BIM", b"AgHg", b"DCSR", b"PHUT", b"MeSa"])
def test_iptc_under_any_signature_is_kept(tmp_path, sign):
    resources = files.resources().replace(b"8BIM", sign)
    segment = files.segment(0xED, b"Photoshop 3.0\0" + resources)
    source = read(tmp_path, jpeg(segment), "in.jpg")
    for name in ("o.jpg", "o.png", "o.tif"):
        note, again = written(tmp_path, source, name)
        assert "IPTC" not in note
        assert photoshop.iptc_of(again.photoshop) == files.IPTC
    assert files.THUMBNAIL not in (tmp_path / "o.jpg").read_bytes()


def test_a_bare_iptc_record_in_a_png_is_kept(tmp_path):
    text = PngImagePlugin.PngInfo()
    lines = f"\niptc\n{len(files.IPTC):8}\n{files.IPTC.hex()}\n"
    text.add_text("Raw profile type iptc", lines, zip=True)
    source = read(tmp_path, files.saved(RGB, "PNG", pnginfo=text), "in.png")
    for name in ("o.png", "o.jpg", "o.tif"):
        note, again = written(tmp_path, source, name)
        assert "IPTC" not in note
        assert photoshop.iptc_of(again.photoshop) == files.IPTC
    assert "the IPTC record" in written(tmp_path, source, "o.webp")[0]


def test_an_iptc_record_alone_gets_no_second_copy_in_a_tiff(tmp_path):
    source = read(tmp_path, tiff(RGB, 8, 2, {33723: (7, files.IPTC)}), "in.tif")
    _, again = written(tmp_path, source, "o.tif")
    assert photoshop.iptc_of(again.photoshop) == files.IPTC
    with Image.open(tmp_path / "o.tif") as image:
        assert 33723 in image.tag_v2
        assert 34377 not in image.tag_v2


@pytest.mark.parametrize("stray", [bytes(16), b"\0\1\2", b"\xff\0\x12", bytes(999)])
def test_stray_bytes_between_segments_lose_nothing(tmp_path, stray):
    data = files.saved(RGB, "JPEG", quality=90, icc_profile=files.GREY, xmp=XMP)
    source = read(tmp_path, data[:20] + stray + data[20:], "in.jpg")
    assert (source.icc_profile, source.xmp) == (files.GREY, XMP)
    note, again = written(tmp_path, source, "o.jpg")
    assert (again.icc_profile, again.xmp) == (files.GREY, XMP)
    assert "% of the JPEG unchanged" in note


GREY_ALPHA = np.dstack([GREY, np.linspace(0, 255, GREY.size).reshape(GREY.shape).astype(np.uint8)])


@pytest.mark.parametrize("bits", [8, 16])
@pytest.mark.parametrize("profile", [None, files.GREY], ids=["", "profile"])
def test_grey_with_alpha_stays_so_in_png_and_tiff_and_in_place(tmp_path, bits, profile):
    pixels = GREY_ALPHA if bits == 8 else GREY_ALPHA.astype(np.uint16) * 257 + 3
    source = photo.Photo(pixels, tmp_path / "none", "PNG", icc_profile=profile)
    for suffix in (".png", ".tif"):
        path = tmp_path / f"o{suffix}"
        assert photo.write(source, pixels, path) == ""
        again = photo.read(path)
        np.testing.assert_array_equal(again.pixels, pixels)
        assert (again.icc_profile, again.notes) == (profile, ())
        before = path.read_bytes()
        store = Originals(tmp_path / f"store{suffix}")
        photo.write_in_place(again, np.invert(pixels), store)
        np.testing.assert_array_equal(photo.read(path).pixels, np.invert(pixels))
        store.restore(path)
        assert path.read_bytes() == before
    with Image.open(tmp_path / "o.png") as image:
        assert image.mode in ("LA", "RGBA" if bits == 16 else "LA")
    if bits == 8:
        with Image.open(tmp_path / "o.tif") as image:
            np.testing.assert_array_equal(np.asarray(image), pixels)


EXIF_3 = {
    0x010E: (129, "Mädchen 顔\0".encode()),
    0x013B: (129, "Ünal 山田\0".encode()),
    0x8298: (129, "© Größe\0".encode()),
}


def utf8_tiff():
    files._SIZES[129] = 1
    inner = {0x9000: (7, b"0300"), 0xA430: (129, "Åsa 森\0".encode())}
    return tiff(RGB, 8, 2, {**EXIF_3, 0x8769: (4, inner)})


def test_exif_3_texts_are_kept_byte_by_byte(tmp_path):
    source = read(tmp_path, utf8_tiff(), "in.tif")
    store = Originals(tmp_path / "store")
    photo.write_in_place(source, np.invert(source.pixels), store)
    for name in ("in.tif", "o.tif", "o.jpg", "o.png", "o.webp"):
        if name != "in.tif":
            written(tmp_path, source, name)
        data = (tmp_path / name).read_bytes()
        for _, text in (*EXIF_3.values(), (129, "Åsa 森\0".encode())):
            assert text in data, name
    store.restore(tmp_path / "in.tif")
    assert (tmp_path / "in.tif").read_bytes() == utf8_tiff()


def test_exif_3_texts_of_a_jpeg_are_kept_in_a_tiff(tmp_path):
    block = b"Exif\0\0II*\0\x08\0\0\0" + files.directory(EXIF_3, 8)
    source = read(tmp_path, jpeg(files.segment(0xE1, block)), "in.jpg")
    written(tmp_path, source, "o.tif")
    for _, text in EXIF_3.values():
        assert text in (tmp_path / "o.tif").read_bytes()


TYPES = (
    *("-ExposureCompensation=1/3", "-ShutterSpeedValue=1/250", "-BrightnessValue=2.5"),
    *("-UserComment=hello", "-ComponentsConfiguration#=1 2 3 0", "-FileSource#=3"),
    *("-SceneType#=1", "-Make=Maker", "-ExifVersion=0232", "-GPSProcessingMethod=GPS"),
    *("-GPSLatitude=35.1", "-GPSLatitudeRef=N", "-GPSVersionID=2 3 0 0", "-LensInfo=24 70 2.8 4"),
    *("-CFAPattern=0 2 0 2 0 1 1 2", "-SubjectArea=4 5 6 7", "-FocalLengthIn35mmFormat=50"),
    "-AmbientTemperature=21.5",
)


@pytest.mark.skipif(not shutil.which("exiftool"), reason="needs ExifTool")
@pytest.mark.parametrize("suffix", [".tif", ".jpg"])
def test_exif_types_stay_in_a_tiff(tmp_path, suffix):
    path, out = tmp_path / f"in{suffix}", tmp_path / "o.tif"
    Image.fromarray(RGB).save(path)
    subprocess.run(["exiftool", "-q", "-overwrite_original", *TYPES, path], check=True)
    written(tmp_path, photo.read(path), "o.tif")
    told = ["-j", "-D", "-a", "-G1", "-validate", "-warning", "-ExifIFD:all", "-GPS:all"]
    done = subprocess.run(["exiftool", *told, path, out], capture_output=True, check=True)
    before, after = json.loads(done.stdout)
    if suffix == ".jpg":  # a TIFF has other rules
        before, after = (
            {k: v for k, v in one.items() if "ExifTool" not in k} for one in (before, after)
        )
    assert {**after, "SourceFile": ""} == {**before, "SourceFile": ""}
    wrong = subprocess.run(["exiftool", "-validate", "-a", "-warning", out], capture_output=True)
    assert b"format" not in wrong.stdout.lower()


def test_an_export_without_metadata_names_the_gain_map_and_the_blocks(tmp_path):
    source = read(tmp_path, metadata_cases.ultra_hdr(), "in.jpg")
    export = Export(metadata=False)
    told, pixels = export.applied(source, np.invert(source.pixels))
    note = photo.write(told, pixels, tmp_path / "o.jpg", quality=export.coding)
    assert "not kept: the HDR gain map" in note
    assert "every block of the JPEG was compressed again" in note
    plain = read(tmp_path, files.saved(RGB, "PNG"), "plain.png")
    assert export.applied(plain, plain.pixels)[0].notes == ()


def test_a_gain_map_larger_than_the_photo_is_left_out_as_the_page_says(tmp_path):
    told = " ".join(PAGE.read_text(encoding="utf-8").split())
    assert "A gain map that is larger than the photo is left out" in told
    source = read(tmp_path, metadata_cases.ultra_hdr(), "in.jpg")
    maps = [one for one in source.extras if one.data]
    assert maps
    small = files.saved(RGB[:2, :3], "JPEG") + maps[0].data
    tiny = read(tmp_path, small, "tiny.jpg")
    assert not photo.has_gain_map(tiny)
    assert "not kept: the HDR gain map" in written(tmp_path, tiny, "o.jpg")[0]
