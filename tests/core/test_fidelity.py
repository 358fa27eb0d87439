"""What goes in comes out: formats, depths, channels and orientations with all their metadata."""

import io
import struct
import zlib

import files
import numpy as np
import pytest
from PIL import ExifTags, Image, ImageCms

from kogao_core import photo
from kogao_core.photo import formats
from kogao_core.photo.metadata import kinds, photoshop
from kogao_core.photo.metadata.upright import Turn, turned_xmp

HEIGHT, WIDTH = 40, 56
EXIF, GPS, INTEROPERABILITY = (ExifTags.IFD.Exif, ExifTags.IFD.GPSInfo, ExifTags.IFD.Interop)
WITH_EXIF = [form.suffixes[0] for form in formats.WRITTEN if kinds.EXIF in form.kept]
# Whatever each format can hold, but for grey with alpha, which no maker writes. A photo without
# EXIF has no orientation.
KINDS = [
    (form.suffixes[0], 8 * np.dtype(depth).itemsize, channels, orientation)
    for form in formats.WRITTEN
    for depth, layouts in form.layouts.items()
    for channels in layouts
    if channels != 2 and depth != "float32"
    for orientation in (range(1, 9) if form.suffixes[0] in WITH_EXIF else (1,))
]
LOSSY = {".jpg", ".avif"}
NARROW = {form.suffixes[0] for form in formats.WRITTEN if kinds.IPTC not in form.kept}


def upright(bits, channels):
    """A smooth picture, with which JPEG does well, without symmetry."""
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH]
    planes = [y * 4 + x, 200 - x * 3 + y // 2, 60 + y * 2 + x // 3, 255 - y * 3]
    values = np.stack(planes[:channels], axis=-1).clip(0, 255)
    deep = values.astype(np.uint16) * 257 + 3 * (values < 250) if bits == 16 else values
    pixels = deep.astype(np.uint16 if bits == 16 else np.uint8)
    return pixels[..., 0] if channels == 1 else pixels


def stored_for(pixels, orientation):
    """Rows and columns as a camera stores them, by the words of the EXIF standard."""
    first_row, first_column = {
        1: ("top", "left"), 2: ("top", "right"), 3: ("bottom", "right"), 4: ("bottom", "left"),
        5: ("left", "top"), 6: ("right", "top"), 7: ("right", "bottom"), 8: ("left", "bottom"),
    }[orientation]  # fmt: skip
    stored = pixels if first_row in ("top", "bottom") else pixels.swapaxes(0, 1)
    stored = stored[::-1] if first_row in ("bottom", "right") else stored
    stored = stored[:, ::-1] if first_column in ("bottom", "right") else stored
    return np.ascontiguousarray(stored)


def holds(suffix, bits, channels):
    layouts = formats.BY_NAME[formats.FORMATS[suffix]].layouts.get(f"uint{bits}", ())
    return bool(layouts) and (channels < 4 or 4 in layouts)


def exif_of(path):
    with Image.open(path) as image:
        if path.suffix == ".tif":
            tags = image.getexif()
        else:
            tags = Image.Exif()
            tags.load(image.info["exif"])
        inner = {name: dict(tags.get_ifd(name)) for name in (EXIF, GPS, INTEROPERABILITY)}
        return dict(tags), inner, bool(tags.get_ifd(ExifTags.IFD.IFD1))


def assert_metadata(path, source_suffix, profile=files.SRGB, orientation=1):
    """Every block that both formats hold is there and true, and no old thumbnail is left."""
    written = photo.read(path)
    if not {path.suffix, source_suffix} <= set(WITH_EXIF):
        return written
    main, inner, has_thumbnail = exif_of(path)
    assert not has_thumbnail
    assert files.THUMBNAIL not in path.read_bytes()
    assert main.get(0x0112, 1) == written.orientation == orientation
    said = {0x010F: "Maker", 0x0110: "Model 7", 0x0131: "Firmware 1.2", 0x013B: "Me!",
            0x8298: "(c) Me", 0x0132: "2026:01:02 03:04:05"}  # fmt: skip
    assert said.items() <= main.items()
    assert inner[EXIF][0x927C] == files.MAKER_NOTE
    assert inner[EXIF][0x9286] == b"ASCII\0\0\0a comment"
    assert inner[EXIF][0x9003] == "2026:01:02 03:04:05"
    sides = (HEIGHT, WIDTH) if orientation >= 5 else (WIDTH, HEIGHT)
    assert (inner[EXIF][0xA002], inner[EXIF][0xA003]) == sides
    assert float(inner[EXIF][0x829A]) == pytest.approx(1 / 125)
    assert float(inner[EXIF][0x9204]) == pytest.approx(-2 / 3)
    assert inner[INTEROPERABILITY][1] == "R98"
    assert inner[GPS][1] == "N"
    assert [float(part) for part in inner[GPS][2]] == pytest.approx([48, 51, 2.9])
    assert [float(part) for part in inner[GPS][4]] == pytest.approx([2, 17, 40])
    assert written.xmp == files.XMP.format(orientation).encode()
    if path.suffix not in NARROW or source_suffix in NARROW or profile == files.SRGB:
        assert written.icc_profile == profile
    if not {path.suffix, source_suffix} & NARROW:
        assert written.dpi == pytest.approx((240, 240), abs=0.01)
        assert photoshop.iptc_of(written.photoshop) == files.IPTC
        assert b"odd" in written.photoshop
    return written


@pytest.mark.parametrize(("suffix", "bits", "channels", "orientation"), KINDS)
def test_round_trip(tmp_path, suffix, bits, channels, orientation):
    pixels = upright(bits, channels)
    path = tmp_path / f"in{suffix}"
    order = {"order": "<>"[orientation % 2]} if suffix in (".jpg", ".tif") else {}
    path.write_bytes(files.MAKERS[suffix](stored_for(pixels, orientation), orientation, **order))
    before = path.read_bytes()
    source = photo.read(path)
    assert (source.bits, source.orientation) == (bits, orientation)
    assert source.pixels.shape == pixels.shape
    level = 257 if bits == 16 else 1
    np.testing.assert_allclose(source.pixels, pixels, atol=4 * level if suffix in LOSSY else 0)
    changed = source.pixels.copy()
    changed[8:16, 16:24] = changed[8:16, 16:24] // 2 + 20
    outputs = [form.suffixes[0] for form in formats.WRITTEN] if orientation in (1, 6) else [suffix]
    for other in outputs:
        out = tmp_path / f"out{other}"
        if not holds(other, bits, channels):
            with pytest.raises(photo.RefusedOutput, match="write it as"):
                photo.write(source, changed, out)
            continue
        said = photo.write(source, changed, out)
        lies = orientation if other == suffix == ".jpg" else 1
        written = assert_metadata(out, suffix, files.profile_for(pixels), lies)
        assert written.bits == bits
        expected = changed
        if other in NARROW:
            assert ("the IPTC record, the print resolution" in said) == (suffix not in NARROW)
        if formats.of(out).becomes_colour(changed):
            expected = np.dstack([changed] * 3)
        lossy = other in LOSSY or (other == ".webp" and suffix in LOSSY)
        np.testing.assert_allclose(
            written.pixels.astype(int), expected.astype(int), atol=24 * level if lossy else 0
        )
        if lossy:
            assert np.abs(written.pixels.astype(int) - expected).mean() < 2.0 * level
    assert path.read_bytes() == before


def test_photoshop_resources_longer_than_a_segment_are_kept(tmp_path):
    long = b"8BIM\x04\x05\0\0" + (150_000).to_bytes(4, "big") + bytes(150_000)
    whole = long + files.resources()
    parts = [whole[at : at + 60_000] for at in range(0, len(whole), 60_000)]
    more = b"".join(files.segment(0xED, b"Photoshop 3.0\0" + part) for part in parts)
    data = files.jpeg(upright(8, 3))
    source = files.opened(tmp_path / "in.jpg", data[:2] + more + data[2:])
    photo.write(source, source.pixels // 2, tmp_path / "out.jpg")
    assert photo.read(tmp_path / "out.jpg").photoshop.startswith(long)


@pytest.mark.parametrize("form", ["bytes", "numbers", "swapped numbers"])
def test_an_iptc_record_that_stands_alone_in_a_tiff_is_kept_everywhere(tmp_path, monkeypatch, form):
    """ExifTool and libtiff write numbers of 32 bits, the latter in the byte order of the file."""
    record = files.IPTC + bytes(-len(files.IPTC) % 4)
    monkeypatch.setattr(files, "IPTC", record)
    data = files.tiff(upright(8, 3)).replace(b"\x49\x86\x01\0", b"\x50\x86\x01\0")  # no 34377
    entry = struct.pack("<HHI", 33723, 7, len(record))
    assert data.count(entry) == 1
    if form != "bytes":
        data = data.replace(entry, struct.pack("<HHI", 33723, 4, len(record) // 4))
    if form == "swapped numbers":
        data = data.replace(record, np.frombuffer(record, ">u4").astype("<u4").tobytes())
    source = files.opened(tmp_path / "in.tif", data)
    for suffix in (".jpg", ".png", ".tif"):
        photo.write(source, 255 - source.pixels, tmp_path / f"out{suffix}")
        again = photo.read(tmp_path / f"out{suffix}")
        assert photoshop.iptc_of(again.photoshop) == record


@pytest.mark.parametrize(("form", "texts"), [("JPEG", 3), ("TIFF", 2)])
def test_letters_beyond_ascii_come_into_a_tiff_byte_for_byte(tmp_path, form, texts):
    name = "Sølvi Åsen 小顔".encode()
    tags = Image.Exif()
    tags[0x013B] = tags[0x8298] = "?" * len(name)
    tags.get_ifd(EXIF)[0xA433] = "?" * len(name)  # the lens's maker; into a TIFF Pillow has none
    with io.BytesIO() as out:
        Image.fromarray(upright(8, 3)).save(out, form, exif=tags)
        stored = out.getvalue().replace(b"?" * len(name), name)
    assert stored.count(name) == texts
    source = files.opened(tmp_path / "in.any", stored)
    photo.write(source, source.pixels // 2, tmp_path / "out.tif")
    assert (tmp_path / "out.tif").read_bytes().count(name) == texts


@pytest.mark.parametrize(("suffix", "sides"), [(".jpg", (40, 56)), (".png", (56, 40))])
def test_thumbnails_in_xmp_are_left_out_and_sizes_are_those_of_the_file(tmp_path, suffix, sides):
    xmp = b'<a tiff:ImageWidth="40" exif:PixelYDimension="56">'
    xmp += b"<xmp:Thumbnails>old</xmp:Thumbnails></a>"
    with io.BytesIO() as out:
        stored = Image.fromarray(stored_for(upright(8, 3), 6))
        stored.save(out, "JPEG", xmp=xmp, exif=files.exif_block(6, 40, 56))
        (tmp_path / "in.jpg").write_bytes(out.getvalue())
    source = photo.read(tmp_path / "in.jpg")
    photo.write(source, source.pixels // 2, tmp_path / f"out{suffix}")
    told = b'<a tiff:ImageWidth="%d" exif:PixelYDimension="%d"></a>' % sides
    assert told in (tmp_path / f"out{suffix}").read_bytes()


def test_thumbnails_that_start_without_end_are_no_trouble():
    xmp = b"<xmp:Thumbnails>" * 500_000
    assert turned_xmp(xmp, Turn(1, 1, 1)) == xmp


@pytest.mark.parametrize("mode", ["CMYK", "LAB", "YCbCr"])
def test_other_colour_models_are_converted_with_a_word(tmp_path, mode):
    picture = Image.fromarray(upright(8, 3))
    if mode == "LAB":
        profiles = [ImageCms.createProfile(name) for name in ("sRGB", "LAB")]
        ImageCms.profileToProfile(picture, *profiles, outputMode="LAB").save(tmp_path / "in.tif")
    else:
        picture.convert(mode).save(tmp_path / "in.tif")
    source = photo.read(tmp_path / "in.tif")
    assert source.pixels.shape == (HEIGHT, WIDTH, 3)
    assert f"converted from {mode} to RGB" in source.notes[0]
    assert np.abs(source.pixels.astype(int) - np.asarray(picture)).mean() < 2.0


def test_deep_grey_with_alpha_keeps_its_depth(tmp_path):
    deep = upright(16, 4)
    source = files.opened(tmp_path / "in.png", grey_png(deep[..., 0], 16, alpha=deep[..., 3]))
    assert source.bits == 16
    photo.write(source, source.pixels // 2, tmp_path / "out.png")
    again = photo.read(tmp_path / "out.png").pixels
    np.testing.assert_array_equal(again[..., 0], deep[..., 0] // 2)
    np.testing.assert_array_equal(again[..., -1], deep[..., 3] // 2)


def grey_png(grey, bits, *more, alpha=None):
    """Return a PNG file of grey samples of some bits."""
    planes = grey if alpha is None else np.stack([grey, alpha], axis=-1)
    rows = planes.reshape(len(grey), -1).astype(">u2" if bits == 16 else np.uint8)
    if bits < 8:
        rows = np.unpackbits(rows[..., None], axis=-1)[..., -bits:].reshape(len(grey), -1)
        rows = np.packbits(rows, axis=-1)
    colour_type = 0 if alpha is None else 4
    header = struct.pack(">IIBBBBB", *grey.shape[::-1], bits, colour_type, 0, 0, 0)
    body = zlib.compress(b"".join(b"\0" + row.tobytes() for row in rows))
    chunks = [(b"IHDR", header), *more, (b"IDAT", body), (b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(files.chunk(*one) for one in chunks)


@pytest.mark.parametrize("bits", [1, 2, 4, 8, 16])
def test_a_grey_that_is_transparent_is_so_at_any_depth(tmp_path, bits):
    most = 2**bits - 1
    grey = (np.arange(5 * 16).reshape(5, 16) * 37) % (most + 1)
    transparent = int(grey[2, 3])
    chunk = (b"tRNS", struct.pack(">H", transparent))
    source = files.opened(tmp_path / "in.png", grey_png(grey, bits, chunk))
    white = np.iinfo(source.pixels.dtype).max
    expected = [grey * (white // most), np.where(grey == transparent, 0, white)]
    np.testing.assert_array_equal(source.pixels[..., [0, -1]], np.stack(expected, axis=-1))
    words = {1: "1 bit", 2: "2 bits", 4: "4 bits"}
    converted = [f"converted from {words[bits]} to 8-bit grey"] if bits < 8 else []
    assert source.notes == (*converted, "the transparent colour became an alpha channel")


def test_deep_grey_with_alpha_keeps_its_grey_profile(tmp_path):
    deep = upright(16, 4)
    profile = (b"iCCP", b"grey\0\0" + zlib.compress(files.GREY))
    (tmp_path / "in.png").write_bytes(grey_png(deep[..., 0], 16, profile, alpha=deep[..., 3]))
    source = photo.read(tmp_path / "in.png")
    np.testing.assert_array_equal(source.pixels, deep[..., [0, 3]])
    assert (source.icc_profile, source.notes) == (files.GREY, ())


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_a_fourth_channel_that_is_not_said_to_be_alpha_is_an_extra_one(tmp_path, dtype):
    """Such as a selection that was kept with the photo."""
    pixels = upright(8, 4).astype(dtype)
    alpha, selection = (struct.pack("<HHIHH", 338, 3, 1, kind, 0) for kind in (2, 0))
    stored = files.tiff(pixels)
    assert stored.count(alpha) == 1
    source = files.opened(tmp_path / "in.tif", stored.replace(alpha, selection))
    np.testing.assert_array_equal(source.pixels, pixels[..., :3])
    assert "1 extra channel" in photo.write(source, source.pixels // 2, tmp_path / "out.tif")


def test_premultiplied_alpha_becomes_straight_with_a_word(tmp_path):
    pixels = upright(8, 4)
    pixels[..., 3] = 128
    stored = pixels.copy()
    stored[..., :3] = pixels[..., :3] // 2
    alpha, premultiplied = (struct.pack("<HHIHH", 338, 3, 1, kind, 0) for kind in (2, 1))
    source = files.opened(tmp_path / "in.tif", files.tiff(stored).replace(alpha, premultiplied))
    np.testing.assert_allclose(source.pixels, pixels, atol=2)
    assert source.notes == ("converted from premultiplied to straight alpha",)
    with pytest.raises(photo.RefusedOutput, match="wouldn't come back as it is"):
        photo.check_in_place(source)


@pytest.mark.parametrize("kind", [0, 1])
def test_a_tiff_that_begins_with_a_small_copy_is_refused(tmp_path, kind):
    """A raw photo renamed is one: its preview isn't the photo."""
    small, whole = Image.fromarray(upright(8, 3)[::4, ::4]), Image.fromarray(upright(8, 3))
    small.save(tmp_path / "in.tif", save_all=True, append_images=[whole], tiffinfo={254: kind})
    if kind == 0:
        assert photo.read(tmp_path / "in.tif").width == WIDTH // 4
        return
    with pytest.raises(photo.UnreadablePhoto, match="begins with a small copy of its picture"):
        photo.read(tmp_path / "in.tif")


@pytest.mark.parametrize("suffix", [".png", ".jpg"])
def test_a_file_with_damaged_headers_is_damaged(tmp_path, suffix):
    data = bytearray(files.MAKERS[suffix](upright(8, 3)))
    if suffix == ".png":
        data[data.index(b"tEXt") + 5] ^= 1  # its checksum is another one now
    else:
        frame = data.index(b"\xff\xc0")
        data[frame + 5 : frame + 7] = b"\0\0"  # the height
    (tmp_path / f"in{suffix}").write_bytes(data)
    with pytest.raises(photo.UnreadablePhoto, match="damaged or incomplete"):
        photo.read(tmp_path / f"in{suffix}")
