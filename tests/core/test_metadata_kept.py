"""Nothing beside the picture is dropped in silence: kept, or named, and no word of it left."""

import dataclasses
import io
import struct
import zlib
from importlib.util import find_spec
from pathlib import Path

import files
import metadata_cases
import numpy as np
import pytest
from PIL import ExifTags, Image, ImageCms, TiffImagePlugin

from kogao_core import photo
from kogao_core.photo import formats
from kogao_core.photo.errors import RefusedOutput
from kogao_core.photo.export import Export
from kogao_core.photo.formats import common
from kogao_core.photo.in_place import check_in_place, write_in_place
from kogao_core.photo.metadata import kinds, references, tiff, tiff_extras
from kogao_core.photo.metadata.upright import turn_upright
from kogao_core.photo.reading import extras_of

OUTPUTS = {form.suffixes[0]: form for form in formats.WRITTEN}
DOCUMENT = Path(__file__).parents[2] / "docs" / "fidelity.md"
KINDS = [one for one in vars(kinds).values() if isinstance(one, kinds.Kind)]
# The blocks of every round trip in test_fidelity, what goes without a word, and names of colours,
# which test_profiles tries.
ELSEWHERE = {
    kinds.RARE_COLOURS,
    *(kinds.EXIF, kinds.XMP, kinds.IPTC, kinds.ICC, kinds.GREY_PROFILE, kinds.RESOLUTION),
    *(kinds.ASPECT, kinds.THUMBNAIL, kinds.INDEX, kinds.ADOBE),
}

needs_heic = pytest.mark.skipif(
    not all(map(find_spec, ("pi_heif", "pillow_heif"))), reason="needs the extra [heic]"
)


def changed(tmp_path, name, data, out):
    """Return what is said of a changed copy, its bytes, and the photo."""
    source = files.opened(tmp_path / name, data)
    said = photo.write(source, source.pixels // 2, tmp_path / out)
    return said, (tmp_path / out).read_bytes(), source


@pytest.mark.parametrize("suffix", OUTPUTS)
@pytest.mark.parametrize("case", metadata_cases.CASES, ids=str)
def test_what_is_not_kept_is_named_and_leaves_no_word(tmp_path, case, suffix):
    said, written, _ = changed(tmp_path, f"in{case.suffix}", case.data, f"out{suffix}")
    form, name = OUTPUTS[suffix], case.name or case.kind.name
    # What goes along is warped: pixels alone don't tell how.
    asked = case.kind in form.companions
    fate = "left out" if asked else form.fate(case.kind)
    left = [mark for mark in case.marks if mark in written]
    assert (f"not kept: {name}" in said) == (fate == "left out")
    assert ("has moved" in said) == (fate == "moved")
    assert left == ([] if fate == "left out" else list(case.marks))
    photo.read(tmp_path / f"out{suffix}")


@pytest.mark.parametrize("case", metadata_cases.CASES, ids=str)
def test_a_copy_has_lost_nothing_and_says_so(tmp_path, case):
    source = files.opened(tmp_path / f"in{case.suffix}", case.data)
    assert photo.write(source, source.pixels, tmp_path / f"out{case.suffix}") == ""
    assert (tmp_path / f"out{case.suffix}").read_bytes() == case.data


def test_conversions_are_not_said_of_a_copy(tmp_path):
    picture = Image.fromarray(metadata_cases.pixels()).convert("CMYK")
    picture.save(tmp_path / "in.jpg")
    source = photo.read(tmp_path / "in.jpg")
    assert photo.write(source, source.pixels, tmp_path / "same.jpg") == ""
    said = photo.write(source, source.pixels // 2, tmp_path / "other.jpg")
    assert "CMYK" in said
    assert "compressed again: its colours were converted to RGB" in said


def test_every_kind_is_tried():
    assert {case.kind for case in metadata_cases.CASES} | ELSEWHERE == set(KINDS)


def test_the_document_holds_the_table():
    def fate(kind, form):
        word = form.fate(kind)
        said = "no" if kind.is_reported else "no, unreported"
        if kind is kinds.THUMBNAIL and word == "kept":
            return "new"
        asked = {kinds.VIDEO: "with `--motion keep`, reported"}
        words = {"kept": "yes", "moved": "moved, reported", "on request": asked.get(kind)}
        return words.get(word, said)

    lines = DOCUMENT.read_text(encoding="utf-8").splitlines()
    start = next(k for k, line in enumerate(lines) if line.startswith("| | recognised by")) + 2
    rows = [line.strip("| ").split(" | ") for line in lines[start : lines.index("", start)]]
    assert {name: fates for name, _, *fates in ([*row[:7]] for row in rows)} == {
        kind.name: [fate(kind, form) for form in OUTPUTS.values()] for kind in KINDS
    }


def test_stale_properties_go_and_every_other_byte_of_the_packet_stays():
    told = "GCamera:MotionPhoto='1' dc:title=\"hdrgm:Version='1'\"\n hdrgm:Version = \"1.0\""
    packet = metadata_cases.packet(told, metadata_cases.container(("Primary", 0)))
    without = references.without(packet, is_extended=True)
    gone = (
        b" GCamera:MotionPhoto='1'",
        b'\n hdrgm:Version = "1.0"',
        metadata_cases.container(("Primary", 0)).encode(),
    )
    expected = packet
    for part in gone:
        assert expected.count(part) == 1
        expected = expected.replace(part, b"")
    assert without == expected
    assert references.without(without, is_extended=True) == without


def test_a_property_of_another_prefix_or_another_space_is_told_apart():
    packet = metadata_cases.packet('hdrgm:Version="1.0" dc:rights="me"')
    other = packet.replace(b"hdrgm", b"g").replace(b"dc:rights", b"dc:Version")
    assert references.without(other, is_extended=True) == other.replace(b' g:Version="1.0"', b"")
    foreign = packet.replace(b"hdr-gain-map", b"something-else")
    assert references.without(foreign, is_extended=True) == foreign


def test_a_camera_that_made_no_video_lost_none(tmp_path):
    data = metadata_cases.jpeg(xmp=metadata_cases.packet('GCamera:MotionPhoto="0"'))
    said, written, _ = changed(tmp_path, "in.jpg", data, "out.jpg")
    assert "not kept" not in said
    assert b"GCamera:MotionPhoto" not in written


def test_a_packet_that_cannot_be_read_stays_as_it_is():
    packet = b"<x:xmpmeta><a hdrgm:Version='1.0'>"
    assert references.without(packet, is_extended=False) == packet
    assert references.found(packet) == ()


# ---- resolution and the pixel aspect ratio ------------------------------------------------------


def with_jfif(version, unit, x, y):
    data = metadata_cases.jpeg()
    return data[:11] + struct.pack(">HBHH", version, unit, x, y) + data[18:]


@pytest.mark.parametrize("told", [(0x101, 0, 2, 1), (0x102, 1, 240, 240), (0x102, 2, 118, 118),
                                  (0x101, 0, 1, 1)])  # fmt: skip
def test_jfif_says_what_it_said(tmp_path, told):
    _, written, _ = changed(tmp_path, "in.jpg", with_jfif(*told), "out.jpg")
    assert struct.unpack(">HBHH", written[11:18]) == told


def test_a_jpeg_that_tells_no_resolution_gets_none(tmp_path):
    for exif in (b"", b"Exif\0\0II*\0\x08\0\0\0\0\0\0\0\0\0"):
        data = metadata_cases.jpeg(exif=exif)
        assert files.opened(tmp_path / "in.jpg", data).dpi is None


def chunk_of_png(data, name):
    at = data.find(name)
    return None if at < 0 else data[at + 4 : at + 4 + int.from_bytes(data[at - 4 : at], "big")]


SHAPED = {
    ".jpg": with_jfif(0x101, 0, 2, 1),
    ".png": metadata_cases.png((b"pHYs", struct.pack(">IIB", 2, 1, 0))),
    ".tif": metadata_cases.tiff({282: (5, (2, 1)), 283: (5, (1, 1)), 296: (3, 1)}),
}


@pytest.mark.parametrize("suffix", SHAPED)
def test_pixels_keep_their_shape(tmp_path, suffix):
    name = f"in{suffix}"
    said, jpeg, source = changed(tmp_path, name, SHAPED[suffix], "out.jpg")
    assert (source.aspect, source.dpi) == ((2, 1), None)
    assert struct.unpack(">BHH", jpeg[13:18]) == (0, 2, 1)
    assert "shape" not in said
    said, png, _ = changed(tmp_path, name, SHAPED[suffix], "out.png")
    assert chunk_of_png(png, b"pHYs") == struct.pack(">IIB", 2, 1, 0)
    changed(tmp_path, name, SHAPED[suffix], "out.tif")
    with Image.open(tmp_path / "out.tif") as seen:
        assert (seen.tag_v2[282], seen.tag_v2[283], seen.tag_v2[296]) == (2, 1, 1)
    said, _, _ = changed(tmp_path, name, SHAPED[suffix], "out.webp")
    assert "not kept: the pixel aspect ratio" in said


@pytest.mark.parametrize(
    ("told", "kept"),
    [((300000, 150000), (2, 1)), ((3, 2), (3, 2)), ((1.5, 1.0), (3, 2)), ((7, 7), None),
     ((1, 10**6), None), ((10**6, 1), None), ((1, 0), None), (None, None)],
)  # fmt: skip
def test_a_shape_is_small_whole_numbers(told, kept):
    assert common.aspect(told) == kept


@needs_heic
def test_pixels_of_a_heic_keep_their_shape(tmp_path):
    """HEIC tells how wide a pixel is to its height, the others how many there are."""
    data = files.heic(metadata_cases.pixels(), pixel_aspect_ratio=(1, 2))
    _, jpeg, _ = changed(tmp_path, "in.heic", data, "out.jpg")
    assert struct.unpack(">BHH", jpeg[13:18]) == (0, 2, 1)


# ---- colours ------------------------------------------------------------------------------------


def test_the_first_of_two_profiles_counts(tmp_path):
    other = ImageCms.ImageCmsProfile(ImageCms.createProfile("LAB")).tobytes()
    first = [
        metadata_cases.profile_part(k + 1, 2, part) for k, part in enumerate((files.SRGB, b""))
    ]
    data = metadata_cases.jpeg(*first, metadata_cases.profile_part(1, 1, other), profile=None)
    said, written, source = changed(tmp_path, "in.jpg", data, "out.jpg")
    assert source.icc_profile == files.SRGB
    assert "not kept" not in said
    assert 0 < written.index(files.SRGB) < written.index(other)
    assert photo.read(tmp_path / "out.jpg").icc_profile == files.SRGB
    in_srgb, pixels = Export(srgb=True).applied(source, source.pixels)
    photo.write(in_srgb, pixels, tmp_path / "srgb.jpg", quality=90)
    assert other not in (tmp_path / "srgb.jpg").read_bytes()


def test_a_second_profile_does_not_outlive_its_colours(tmp_path):
    other = metadata_cases.profile_part(1, 1, metadata_cases.MARK)
    data = files.saved(Image.fromarray(metadata_cases.pixels()).convert("CMYK"), "JPEG")
    both = data[:2] + metadata_cases.profile_part(1, 1, files.SRGB) + other + data[2:]
    for suffix in (".jpg", ".png"):
        said, written, _ = changed(tmp_path, "in.jpg", both, f"out{suffix}")
        assert "not kept: Adobe's colour coding, a second colour profile" in said
        assert metadata_cases.MARK not in written
        assert b"Adobe\0" not in written


def test_the_first_of_two_packets_counts_and_neither_tells_of_what_is_gone(tmp_path):
    packets = [
        metadata_cases.packet(f'hdrgm:Version="1.0" dc:title="{name}"') for name in ("one", "two")
    ]
    first = files.segment(0xE1, metadata_cases.XMP_HEAD + packets[0])
    _, written, source = changed(
        tmp_path, "in.jpg", metadata_cases.jpeg(first, xmp=packets[1]), "out.jpg"
    )
    assert source.xmp == packets[0]
    assert 0 < written.index(b'dc:title="one"') < written.index(b'dc:title="two"')
    assert b"hdrgm:Version" not in written


@pytest.mark.parametrize("suffix", [end for end, one in OUTPUTS.items() if kinds.EXIF in one.kept])
@pytest.mark.parametrize("orientation", [1, 6])
def test_a_thumbnail_shows_the_result_as_it_lies_and_nothing_else_in_its_block_moves(
    tmp_path, suffix, orientation
):
    small = files.saved(metadata_cases.pixels(), "JPEG", quality=95)
    exif = files.exif_block(
        orientation, metadata_cases.WIDTH, metadata_cases.HEIGHT, thumbnail=small
    )
    _, _, source = changed(tmp_path, "in.jpg", metadata_cases.jpeg(exif=exif), f"out{suffix}")
    result = photo.read(tmp_path / f"out{suffix}")
    assert small not in (tmp_path / f"out{suffix}").read_bytes()
    if suffix == ".tif":
        return  # its further directories are pictures of their own
    tags = Image.Exif()
    tags.load(result.exif)
    place, length = (tags.get_ifd(ExifTags.IFD.IFD1)[tag] for tag in (0x201, 0x202))
    made = result.exif[6:][place : place + length]
    with Image.open(io.BytesIO(made)) as seen:
        upright = turn_upright(np.asarray(seen), result.orientation)
    shown = source.pixels // 2
    assert upright.shape == shown.shape
    assert np.abs(upright - shown.astype(int)).mean() < 3
    assert result.exif.index(files.MAKER_NOTE) == exif.index(files.MAKER_NOTE)


def test_records_stay_at_the_end_of_a_jpeg_and_are_named_where_they_cannot(tmp_path):
    records = metadata_cases.photo_mechanic() + metadata_cases.fotostation()
    data = metadata_cases.jpeg(end=metadata_cases.MARK + records)
    said, written, source = changed(tmp_path, "in.jpg", data, "out.jpg")
    assert written.endswith(b"\xff\xd9" + records)
    assert "not kept: 20 bytes of unknown data at the end; " in said
    both = "Photo Mechanic's data at the end, FotoStation's data at the end"
    said = photo.write(source, source.pixels // 2, tmp_path / "small.jpg", quality=80)
    assert both in said
    tiff = files.opened(tmp_path / "in.tif", metadata_cases.tiff(end=records))
    assert both in photo.write(tiff, tiff.pixels // 2, tmp_path / "tif.jpg")


def test_a_copy_of_the_packet_among_photoshops_resources_is_no_loss(tmp_path):
    packet = metadata_cases.packet()
    resource = b"8BIM\x04\x24\0\0" + struct.pack(">I", len(packet)) + packet
    segment = files.segment(0xED, b"Photoshop 3.0\0" + resource)
    data = metadata_cases.jpeg(segment, xmp=packet)
    assert "not kept" not in changed(tmp_path, "in.jpg", data, "out.jpg")[0]


def test_tags_keep_their_types_and_numbers(tmp_path):
    told = {40000: (2, b"caf\xe9\0"), 40001: (3, (1, 2, 65535)), 40002: (5, (1, 3, 7, 2)),
            40003: (12, (0.1, -2.5)), 40004: (8, (-5, 5)), 40005: (11, (0.5,))}  # fmt: skip
    _, written, _ = changed(tmp_path, "in.tif", metadata_cases.tiff(told), "out.tif")
    before, after = (tiff.directory_of(data) for data in (metadata_cases.tiff(told), written))
    assert {tag: (after.tagtype[tag], after[tag]) for tag in told} == {
        tag: (before.tagtype[tag], before[tag]) for tag in told
    }


# A page, halftones, bit order, orientation, resolution (of squares, in cm), number of the page.
OF_FILE = {254: (4, 2), 263: (3, 1), 266: (3, 1), 274: (3, 1), 282: (5, (118, 3)),
           283: (5, (118, 3)), 296: (3, 3), 297: (3, (0, 2))}  # fmt: skip


@pytest.mark.parametrize("unit", [1, 3])
@pytest.mark.parametrize("photometric", ["RGB", "palette"])
def test_tags_of_the_file_stay_in_a_tiff(tmp_path, photometric, unit):
    told = OF_FILE | {296: (3, unit)}
    data = metadata_cases.tiff(told)
    if photometric == "palette":
        palette = Image.fromarray(metadata_cases.pixels()).quantize(16)
        info = {tag: value for tag, (_, value) in told.items()} | {282: 118 / 3, 283: 118 / 3}
        data = files.saved(palette, "TIFF", tiffinfo=info)
    said, _, _ = changed(tmp_path, "in.tif", data, "out.tif")
    with Image.open(tmp_path / "in.tif") as before, Image.open(tmp_path / "out.tif") as after:
        assert [after.tag_v2[tag] for tag in told] == [before.tag_v2[tag] for tag in told]
    assert "not kept" not in said
    said, _, _ = changed(tmp_path, "in.tif", data, "out.jpg")
    assert "not kept: TIFF tags 297" in said


@pytest.mark.parametrize(("told", "said"), [
    ({266: (3, 2)}, "the bits of each byte are stored in the usual order (FillOrder 1)"),
    ({280: (3, 0), 281: (3, 255)}, "not kept: TIFF tags 280 281"),
])  # fmt: skip
def test_tags_of_the_old_pixels_are_named(tmp_path, told, said):
    assert changed(tmp_path, "in.tif", metadata_cases.tiff(told), "out.tif")[0] == said
    with Image.open(tmp_path / "out.tif") as seen:
        assert not told.keys() & seen.tag_v2.keys()


@pytest.mark.parametrize("told", [(1, 1, 0), (3, 3, 0), (0, 0, 1)])
def test_square_pixels_without_a_unit_stay_in_a_png(tmp_path, told):
    body = struct.pack(">IIB", *told)
    _, png, _ = changed(tmp_path, "in.png", metadata_cases.png((b"pHYs", body)), "out.png")
    assert (png.count(b"pHYs"), chunk_of_png(png, b"pHYs")) == (1, body)


@pytest.mark.parametrize(("mode", "transform"), [("RGB", 1), ("RGB", 2), ("L", 0), ("L", 1)])
def test_adobes_colour_coding_stays(tmp_path, mode, transform):
    adobe = files.segment(0xEE, b"Adobe\0\x64\x40\0\0\0" + bytes([transform]))
    data = files.saved(Image.fromarray(metadata_cases.pixels()).convert(mode), "JPEG")
    data = data[:20] + adobe + data[20:]
    said, written, source = changed(tmp_path, "in.jpg", data, "out.jpg")
    assert (written.count(adobe), "not kept" in said) == (1, False)
    said, written, _ = changed(tmp_path, "in.jpg", data, "out.png")
    assert said == ""
    if mode == "RGB":
        source = dataclasses.replace(source, icc_profile=files.SRGB)
        in_srgb, pixels = Export(srgb=True).applied(source, source.pixels)
        photo.write(in_srgb, pixels, tmp_path / "srgb.jpg", quality=90)
        assert adobe not in (tmp_path / "srgb.jpg").read_bytes(), "the colours are coded anew"


@pytest.mark.parametrize(("name", "body"), [
    (b"sRGB", b"\0"), (b"gAMA", struct.pack(">I", 45455)),
    (b"cHRM", struct.pack(">8I", 31270, 32900, 64000, 33000, 30000, 60000, 15000, 6000)),
])  # fmt: skip
def test_ordinary_colours_are_not_called_lost(tmp_path, name, body):
    said, _, _ = changed(tmp_path, "in.png", metadata_cases.png((name, body)), "out.jpg")
    assert said == ""


def test_pixels_without_a_number_are_said_where_they_spread(tmp_path):
    pixels = np.full((20, 30, 3), 0.5, np.float32)
    pixels[3:5, 4:7] = np.nan
    source = photo.Photo(pixels, tmp_path / "none", "TIFF")
    same = np.where(np.isnan(pixels), pixels, 0.25).astype(np.float32)
    assert photo.write(source, same, tmp_path / "a.tif") == ""
    spread = same.copy()
    spread[2:6, 3:8, 1] = np.inf
    said = photo.write(source, spread, tmp_path / "b.tif")
    assert said == "pixels without a number (NaN or infinity) have spread from 6 to 20"


# ---- files ------------------------------------------------------------------------------------


def test_padding_is_no_data_and_a_picture_after_it_is_found(tmp_path):
    more = metadata_cases.MP4 + bytes(2) + metadata_cases.gain_map(metadata_cases.packet())
    for end, expected in (
        (b"", ""),
        (more, "not kept: the motion photo's video, further pictures"),
    ):
        data = metadata_cases.jpeg(end=bytes(4097) + end)
        assert changed(tmp_path, "in.jpg", data, "out.png")[0] == expected
        (tmp_path / "out.png").unlink()


@needs_heic
def test_what_a_heic_holds_beside_its_picture_is_named(tmp_path):
    import pillow_heif

    both = pillow_heif.HeifFile()
    for pixels in (metadata_cases.pixels(), 255 - metadata_cases.pixels()):
        both.add_from_pillow(Image.fromarray(pixels))
    both.save(tmp_path / "both.heic", quality=90)
    boxes = [
        (b"mpvd", metadata_cases.MP4), (b"sefd", b"SEFH"), (b"wxyz", b"?"), (b"jumb", b""),
        (b"uuid", bytes.fromhex("d8fec3d61b0e483c92975828877ec481")), (b"free", b"")]  # fmt: skip
    more = b"".join(struct.pack(">I4s", 8 + len(body), name) + body for name, body in boxes)
    said, _, _ = changed(
        tmp_path, "in.heic", (tmp_path / "both.heic").read_bytes() + more, "out.png"
    )
    assert said == (
        "not kept: further pictures, the motion photo's video, Samsung's data at the end, "
        "content credentials (C2PA), unknown data (wxyz jumb)"
    )


@pytest.mark.parametrize("case", metadata_cases.CASES, ids=str)
def test_damaged_files_never_stop_the_reader(tmp_path, case):
    """Whatever a decoder takes for good must have been looked through."""
    path = tmp_path / f"in{case.suffix}"
    source = files.opened(path, case.data)
    rng = np.random.default_rng(zlib.crc32(case.label.encode()))
    for _ in range(4):
        data = bytearray(case.data)
        for at in rng.integers(20, len(data), 6):
            data[at] = rng.integers(256)
        data = bytes(data[: rng.integers(20, len(data) + 1)])
        if source.format == "TIFF":
            assert 0 < tiff_extras.end(io.BytesIO(data)) <= len(data)
        else:
            assert all(isinstance(one, kinds.Extra) for one in extras_of(source, io.BytesIO(data)))


def tiff_of(path, *kinds):
    """A TIFF with a page of each kind (NewSubfileType; None for no such tag)."""
    pages = []
    for number, kind in enumerate(kinds):
        directory = TiffImagePlugin.ImageFileDirectory_v2()
        if kind is not None:
            directory[254] = kind
        page = Image.new("RGB", (24, 18), (40 * number, 90, 30))
        page.encoderinfo = {"tiffinfo": directory}
        pages.append(page)
    pages[0].save(path, save_all=True, append_images=pages[1:], tiffinfo={})
    return path


@pytest.mark.parametrize(
    ("kinds", "is_refused"),
    [((None, 1), False), ((None, 1, 1), False), ((None, None), True), ((None, 1, 0), True)],
)
def test_a_thumbnail_in_a_tiff_is_no_further_picture(tmp_path, kinds, is_refused):
    path = tiff_of(tmp_path / "a.tif", *kinds)
    taken = photo.read(path)
    if is_refused:
        with pytest.raises(RefusedOutput, match="further pictures"):
            check_in_place(taken)
    else:
        write_in_place(taken, 255 - taken.pixels, None)
        with Image.open(path) as written:
            assert written.n_frames == 1
