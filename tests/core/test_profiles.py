"""Colours by name: read, shown, converted, tone-mapped and saved as the name says.

The reference has its own formulas: ITU-R BT.709, BT.2100, BT.2390 and CSS Color 4's matrices.
"""

import dataclasses
import io
import re
import struct
import zlib
from pathlib import Path

import cv2
import files
import numpy as np
import pytest
from PIL import Image, ImageCms
from scenes import textured_photo

from kogao_core import photo
from kogao_core.cli import ending, reading
from kogao_core.photo import profiles
from kogao_core.photo.export import Export
from kogao_core.photo.formats import avif

PAGE = Path(__file__).parents[2] / "docs" / "fidelity.md"
# Linear RGB to XYZ under D65.
TO_XYZ = {
    1: [(0.4123908, 0.3575843, 0.1804808), (0.212639, 0.7151687, 0.0721923),
        (0.0193308, 0.1191948, 0.9505322)],
    9: [(0.636958, 0.1446169, 0.168881), (0.2627002, 0.6779981, 0.0593017),
        (0.0, 0.0280727, 1.0609851)],
    12: [(0.4865709, 0.2656677, 0.1982173), (0.2289746, 0.6917385, 0.0792869),
         (0.0, 0.0451134, 1.0439444)],
}  # fmt: skip
SRGB, P3, BT2020 = 1, 12, 9
VIDEO, LINEAR, CURVE, PQ, HLG = 1, 8, 13, 16, 18


def pq(nits):
    y = (nits / 10000) ** 0.1593017578125
    return ((0.8359375 + 18.8515625 * y) / (1 + 18.6875 * y)) ** 78.84375


def from_pq(signal):
    y = signal ** (1 / 78.84375)
    y = np.maximum(y - 0.8359375, 0) / (18.8515625 - 18.6875 * y)
    return 10000 * y ** (1 / 0.1593017578125)


def from_hlg(signal):
    bright = (np.exp((signal - 0.55991073) / 0.17883277) + 0.28466892) / 12
    return 1000 * np.where(signal <= 0.5, signal**2 / 3, bright) ** 1.2


def from_srgb(signal):
    return np.where(signal <= 0.04045, signal / 12.92, ((signal + 0.055) / 1.055) ** 2.4)


LINEAR_OF = {
    VIDEO: lambda v: np.where(v < 0.081, v / 4.5, ((v + 0.099) / 1.099) ** (1 / 0.45)),
    LINEAR: lambda v: v,
    CURVE: from_srgb,
    PQ: lambda v: toned(from_pq(v)),
    HLG: lambda v: toned(from_hlg(v)),
}


def toned(nits, white=203.0):
    """BT.2390's curve from the brightest channel to white; result 0 to 1."""
    peak = pq(max(white, np.ceil(nits.max())))
    signal, most = pq(nits) / peak, pq(white) / peak
    knee = 1.5 * most - 0.5
    t = (signal - knee) / (1 - knee) if knee < 1 else signal
    bent = (2 * t**3 - 3 * t**2 + 1) * knee + (t**3 - 2 * t**2 + t) * (1 - knee)
    bent += (3 * t**2 - 2 * t**3) * most
    return np.clip(from_pq(np.where(signal < knee, signal, bent) * peak) / white, 0, 1)


def in_srgb(signal, name):
    """Return values of 0 to 1 with a name as sRGB, clipped, 0 to 255."""
    matrix = np.linalg.solve(TO_XYZ[SRGB], TO_XYZ[name[0]])
    linear = np.clip(LINEAR_OF[name[1]](signal) @ matrix.T, 0, 1)
    return 255 * np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def chart(dtype=np.uint8):
    """Smooth colours up to the corners of the cube, 80 x 96 px."""
    y, x = np.mgrid[0:80, 0:96]
    shares = np.stack([x / 95, y / 79, 0.5 + 0.5 * np.sin(x / 19 + y / 23)], -1)
    return np.rint(shares * np.iinfo(dtype).max).astype(dtype)


def with_name(pixels, suffix, name):
    """Return a file that another program could have written."""
    if suffix == ".heic":
        keys = "color_primaries", "transfer_characteristics", "matrix_coefficients"
        named = dict(zip(keys, (*name, 9 if name[0] == BT2020 else 6), strict=True))
        return files.heic(pixels, chroma=444, full_range_flag=1, save_nclx_profile=True, **named)
    if suffix == ".png":
        data = cv2.imencode(".png", pixels[..., ::-1])[1].tobytes()
        return data[:33] + files.chunk(b"cICP", bytes([*name, 0, 1])) + data[33:]
    deep = pixels.dtype == np.uint16
    how = [cv2.IMWRITE_AVIF_DEPTH, 10 if deep else 8, cv2.IMWRITE_AVIF_QUALITY, 100]
    stored = pixels >> 6 if deep else pixels
    data = cv2.imencode(".avif", stored[..., ::-1], how)[1].tobytes()
    return re.sub(b"(?<=colrnclx)....", struct.pack(">HH", *name), data, count=1, flags=re.DOTALL)


def name_in(data, suffix):
    """Return the name that a file gives to its colours, or None."""
    if suffix == ".png":
        at = data.find(b"cICP")
        return None if at < 0 else (data[at + 4], data[at + 5])
    at = data.find(b"colrnclx")
    return None if at < 0 else struct.unpack_from(">HH", data, at + 8)


def by_profile(path):
    """Return the 8-bit sRGB that littleCMS makes of a file by its profile."""
    with Image.open(path) as image:
        icc = image.info["icc_profile"]
        source = ImageCms.ImageCmsProfile(io.BytesIO(icc))
        rgb = image.convert("RGB")
    target = ImageCms.createProfile("sRGB")
    return np.asarray(ImageCms.profileToProfile(rgb, source, target, 1)).astype(float)


def saved(tmp_path, source, suffix, **options):
    path = tmp_path / f"out{suffix}"
    pixels = source.pixels.copy()
    pixels[0, 0] ^= 1  # an unchanged file would be copied
    note = photo.write(source, pixels, path, force=True, **options)
    return path, note


SDR = [(P3, CURVE), (BT2020, CURVE), (P3, VIDEO), (BT2020, 14), (SRGB, LINEAR)]
HDR = [(BT2020, PQ), (SRGB, PQ), (P3, PQ), (BT2020, HLG)]


@pytest.mark.parametrize("suffix", [".heic", ".avif", ".png"])
@pytest.mark.parametrize("name", SDR)
def test_a_name_is_converted_and_saved_as_a_profile_or_a_name(tmp_path, suffix, name):
    if suffix == ".heic":
        pytest.importorskip("pillow_heif")
    path = tmp_path / f"in{suffix}"
    source = files.opened(path, with_name(chart(), suffix, name))
    assert source.notes == ()
    wanted = in_srgb(source.pixels / 255, (name[0], VIDEO if name[1] == 14 else name[1]))
    told, pixels = Export(srgb=True).applied(source, source.pixels)
    assert np.abs(pixels - wanted).mean() < 0.6
    assert np.abs(source.pixels - wanted).mean() > 2.5
    assert told.icc_profile == profiles.srgb()
    for other in (".jpg", ".png", ".tif", ".webp", ".avif"):
        out, note = saved(tmp_path, source, other)
        assert "colour" not in note
        assert np.abs(by_profile(out) - wanted).mean() < (1.0 if other in (".png", ".tif") else 4.0)
        if other in (".png", ".avif"):
            assert name_in(out.read_bytes(), other) == name
        again = photo.read(out)
        assert profiles.name_of(again.icc_profile) == name


@pytest.mark.parametrize("suffix", [".heic", ".avif", ".png"])
@pytest.mark.parametrize("name", HDR)
def test_hdr_keeps_its_name_or_is_tone_mapped_with_a_note(tmp_path, suffix, name):
    if suffix == ".heic":
        pytest.importorskip("pillow_heif")
    path = tmp_path / f"in{suffix}"
    source = files.opened(path, with_name(chart(np.uint16), suffix, name))
    assert (source.bits, source.notes) == (16, ())
    wanted = in_srgb(source.pixels / 65535, name)
    shown = profiles.to_srgb(source.pixels, source.icc_profile)  # as the screen shows the photo
    assert np.abs(shown - wanted).mean() < 2.0
    for other, off in ((".png", 0), (".avif", 40)):
        out, note = saved(tmp_path, source, other)
        assert "tone-mapped" not in note
        assert name_in(out.read_bytes(), other) == name
        again = photo.read(out).pixels[1:].astype(int)
        assert np.abs(again - source.pixels[1:]).max() <= off  # 10 of 16 bits
    told, pixels = Export(srgb=True).applied(source, source.pixels)
    assert told.notes == (profiles.TONE_MAPPED,)
    assert np.abs(pixels - wanted).mean() < 0.7
    out, note = saved(tmp_path, source, ".tif")
    assert "tone-mapped" in note
    mapped = photo.read(out)
    assert mapped.bits == 16
    linear = profiles.to_srgb(mapped.pixels, mapped.icc_profile or profiles.srgb())
    assert np.abs(linear - wanted).mean() < 0.7
    if suffix != ".png":
        out, note = saved(tmp_path, photo.read(path, bits=8), ".jpg")
        assert "tone-mapped" in note
        with Image.open(out) as image:
            plain = "icc_profile" not in image.info
        seen = np.asarray(Image.open(out).convert("RGB")) if plain else by_profile(out)
        assert np.abs(seen - wanted).mean() < 4.0


def test_the_page_states_the_tone_mapping():
    told = " ".join(PAGE.read_text(encoding="utf-8").split())
    assert "BT.2390" in told
    assert f"{profiles.WHITE_NITS:.0f} cd/m²" in told


def test_a_picture_of_at_most_white_is_not_tone_mapped_at_all():
    nits = np.linspace(0, profiles.WHITE_NITS, 64)
    signal = np.rint(65535 * pq(nits)).astype(np.uint16)
    pixels = np.repeat(signal[None, :, None], 3, axis=2)
    icc = profiles.of_name((SRGB, PQ), pixels)
    source = photo.Photo(pixels, Path("x.png"), "PNG", icc_profile=icc)
    told, mapped = profiles.tone_mapped(source, pixels)
    assert told.icc_profile is None  # sRGB
    assert np.abs(from_srgb(mapped[0, :, 0] / 65535) - nits / profiles.WHITE_NITS).max() < 2e-3


@pytest.mark.parametrize("name", [(1, 13), (1, 1), (2, 2), (5, 1), (6, 6), (1, 6), (2, 13)])
def test_names_that_cameras_give_to_srgb_need_no_profile(name):
    assert profiles.of_name(name, chart()) is None


def test_a_name_without_numbers_in_icc_is_named_and_not_called_srgb(tmp_path):
    path = tmp_path / "in.avif"
    source = files.opened(path, with_name(chart(), ".avif", (10, 17)))
    with pytest.raises(photo.RefusedOutput, match="can't be converted to sRGB"):
        Export(srgb=True).applied(source, source.pixels)
    for suffix in (".jpg", ".png", ".avif"):
        assert "not kept: the name of rare colours" in saved(tmp_path, source, suffix)[1]


def test_a_profile_has_a_name_only_if_it_says_so():
    built = profiles.of_name((P3, CURVE), chart())
    assert profiles.name_of(built) == (P3, CURVE)
    for other in (None, b"", b"nonsense", built[:200], profiles.srgb(), files.GREY):
        assert profiles.name_of(other) is None


def test_a_tiff_with_a_profile_of_pq_stays_as_it_is(tmp_path):
    icc = profiles.of_name((BT2020, PQ), chart())
    data = files.saved(chart(), "TIFF", icc_profile=icc)
    source = files.opened(tmp_path / "in.tif", data)
    out, note = saved(tmp_path, source, ".tif")
    assert note == ""
    np.testing.assert_array_equal(photo.read(out).pixels[1:], chart()[1:])
    assert photo.read(out).icc_profile == icc
    out, note = saved(tmp_path, source, ".png")
    assert name_in(out.read_bytes(), ".png") == (BT2020, PQ)


def test_a_profile_overrules_the_name_beside_it(tmp_path):
    data = files.saved(chart(), "AVIF", icc_profile=files.SRGB)
    named = data.replace(b"colrnclx\0\2\0\2", b"colrnclx\0\x0c\0\x0d")
    assert named != data
    assert files.opened(tmp_path / "in.avif", named).icc_profile == files.SRGB


def test_a_name_in_png_overrules_the_profile_which_stays_for_other_readers(tmp_path):
    data = with_name(chart(), ".png", (P3, CURVE))
    chunk = files.chunk(b"iCCP", b"mine\0\0" + zlib.compress(files.SRGB))
    source = files.opened(tmp_path / "in.png", data[:33] + chunk + data[33:])
    assert profiles.name_of(source.icc_profile) == (P3, CURVE)
    out, _ = saved(tmp_path, source, ".png")
    assert chunk in out.read_bytes()
    assert name_in(out.read_bytes(), ".png") == (P3, CURVE)


def edited(data, box, associate):
    """Add a property to an AVIF file with one item, and associate it with the item if asked."""
    data = bytearray(data)

    def find(name, start, end):
        at = start
        while at < end:
            size = int.from_bytes(data[at : at + 4], "big")
            if data[at + 4 : at + 8] == name:
                return at, at + size
            at += size
        raise KeyError(name)

    meta = find(b"meta", 0, len(data))
    iprp = find(b"iprp", meta[0] + 12, meta[1])
    ipco = find(b"ipco", iprp[0] + 8, iprp[1])
    ipma = find(b"ipma", iprp[0] + 8, iprp[1])
    count, at = 0, ipco[0] + 8
    while at < ipco[1]:
        count, at = count + 1, at + int.from_bytes(data[at : at + 4], "big")
    sizes = {meta[0]: len(box) + associate, iprp[0]: len(box) + associate, ipco[0]: len(box)}
    if associate:
        data[ipma[0] + 18] += 1
        data[ipma[1] : ipma[1]] = bytes([0x80 | (count + 1)])
        sizes[ipma[0]] = 1
    for at, more in sizes.items():
        data[at : at + 4] = (int.from_bytes(data[at : at + 4], "big") + more).to_bytes(4, "big")
    data[ipco[1] : ipco[1]] = box
    return bytes(data), len(box) + associate


def moved(data, by):
    """Add to the offset of the only extent of the only item."""
    at = data.index(b"iloc") + 8
    sizes = data[at]
    assert sizes >> 4 == 4
    place = at + 2 + 2 + 2 + 2 + 2
    offset = int.from_bytes(data[place : place + 4], "big") + by
    return data[:place] + offset.to_bytes(4, "big") + data[place + 4 :]


def boxed(pixels, box, *, associate):
    data = files.saved(pixels, "AVIF", quality=95, subsampling="4:4:4")
    return moved(*edited(data, box, associate))


def test_the_name_of_another_item_is_not_that_of_the_picture(tmp_path):
    named = struct.pack(">I4s4s3HB", 19, b"colr", b"nclx", 9, 16, 9, 128)
    source = files.opened(tmp_path / "in.avif", boxed(chart(), named, associate=False))
    assert (source.icc_profile, source.notes, source.extras) == (None, (), ())


@pytest.mark.parametrize("right", [0, 5])
def test_a_clean_aperture_crops(tmp_path, right):
    plain = files.saved(chart(), "AVIF", quality=95, subsampling="4:4:4")
    (tmp_path / "plain.avif").write_bytes(plain)
    aperture = struct.pack(">I4sIIIIiIiI", 40, b"clap", 64, 1, 40, 1, right, 1, -3, 1)
    (tmp_path / "in.avif").write_bytes(boxed(chart(), aperture, associate=True))
    whole = photo.read(tmp_path / "plain.avif").pixels
    source = photo.read(tmp_path / "in.avif")
    np.testing.assert_array_equal(source.pixels, whole[17:57, 16 + right : 80 + right])


def test_an_aperture_outside_the_picture_crops_nothing():
    for numbers in ((200, 1, 40, 1, 0, 1, 0, 1), (20, 0, 40, 1, 0, 1, 0, 1)):
        box = struct.pack(">IIIIiIiI", *numbers)
        assert avif._cropped(chart(), box).shape == chart().shape


def test_orientation_in_xmp_alone_turns_no_avif(tmp_path):
    xmp = files.XMP.format(6).encode()
    source = files.opened(tmp_path / "in.avif", files.saved(chart(), "AVIF", xmp=xmp))
    assert source.pixels.shape == chart().shape
    for suffix in (".avif", ".png", ".jpg"):
        out, _ = saved(tmp_path, source, suffix)
        assert photo.read(out).pixels.shape == chart().shape  # nor does the result


def test_a_strict_rule_of_avif_keeps_no_photo_out(tmp_path):
    """The size of the alpha item is missing: libavif refuses, libheif and OpenCV read it."""
    rgba = np.dstack([chart(), chart()[..., 0]])
    data = files.saved(rgba, "AVIF", quality=95, subsampling="4:4:4")
    at = data.index(b"ipma") + 8
    sizes = data[at : at + 32]
    second = sizes.index(b"\0\2", 4)
    assert data[at + second + 3] & 0x7F == 1  # the size
    bad = bytearray(data)
    bad[at + second + 3] = bad[at + second + 4]
    source = files.opened(tmp_path / "in.avif", bytes(bad))
    assert source.pixels.shape == rgba.shape
    assert np.abs(source.pixels.astype(int) - rgba)[..., :3].mean() < 3
    assert source.notes


def test_an_avif_above_the_limit_of_libavif_is_not_called_damaged(tmp_path):
    data = files.saved(chart(), "AVIF")
    at = data.index(b"ispe") + 8
    (tmp_path / "in.avif").write_bytes(
        data[:at] + struct.pack(">II", 17000, 17000) + data[at + 8 :]
    )
    with pytest.raises(photo.UnreadablePhoto, match="more than 16384 px a side"):
        photo.read(tmp_path / "in.avif")


# -- channels that mean anything else ---------------------------------------------------------


def table_profile(order=(2, 0, 1)):
    """Return a profile with a table: channels in another order."""
    d50 = [(0.4360, 0.3851, 0.1431), (0.2225, 0.7169, 0.0606), (0.0139, 0.0971, 0.7141)]
    corners = [(r, g, b) for r in (0, 1) for g in (0, 1) for b in (0, 1)]
    xyz = [np.rint(32768 * np.array(d50) @ [one[k] for k in order]) for one in corners]
    lut = struct.pack(">4s4xBBBx", b"mft2", 3, 3, 2)
    lut += struct.pack(">9i", *(65536 * (k % 4 == 0) for k in range(9))) + struct.pack(">HH", 2, 2)
    lut += struct.pack(">6H", *[0, 65535] * 3)
    lut += np.array(xyz).astype(">u2").tobytes() + struct.pack(">6H", *[0, 65535] * 3)
    tags = profiles._tags(profiles.srgb())
    plain = {name: tags[name] for name in (b"desc", b"cprt", b"wtpt")}
    return profiles._assembled(profiles.srgb(), {**plain, b"A2B0": lut})


def test_faces_are_searched_in_colours_and_not_in_channels():
    linear = np.rint(255 * from_srgb(textured_photo(40, 30) / 255)).astype(np.uint8)
    scrambled = linear[..., [1, 2, 0]]
    icc = table_profile()
    source = photo.Photo(scrambled, Path("x.jpg"), "JPEG", icc_profile=icc)
    seen = profiles.for_search(source)
    assert np.abs(seen.astype(int) - textured_photo(40, 30)).mean() < 6
    plain = dataclasses.replace(source, icc_profile=files.SRGB)
    assert profiles.for_search(plain) is scrambled
    damaged = dataclasses.replace(source, icc_profile=icc[:300])
    assert profiles.for_search(damaged) is scrambled


def test_the_command_line_searches_faces_in_these_colours():
    class Source:
        name = "none"

        def find(self, image):
            self.image = image
            return []

    scrambled = textured_photo(40, 30)
    source = photo.Photo(scrambled, Path("x.jpg"), "JPEG", icc_profile=table_profile())
    known = Source()
    with pytest.raises(ending.Stop, match="no face"):
        reading.find_faces(source, None, known=known)
    np.testing.assert_array_equal(known.image, profiles.for_search(source))
    assert known.image is not scrambled


def test_an_8_bit_picture_beside_a_deep_gain_map_has_8_bits(tmp_path):
    data = boxed(chart(), b"\0\0\0\x0cav1C\x81\x00\x4c\x00", associate=False)
    source = files.opened(tmp_path / "in.avif", data)
    assert (source.bits, source.notes) == (8, ())
