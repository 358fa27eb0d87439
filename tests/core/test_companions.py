"""What follows a JPEG's picture goes along with it: a gain map warped alike, a film as it was."""

import io
import re
import struct
from dataclasses import dataclass

import cv2
import files
import imagecodecs
import jpeglib
import metadata_cases
import numpy as np
import pytest
from PIL import Image
from scenes import oval_face, textured_photo
from test_fidelity import stored_for

import kogao_core as kogao
from kogao_core import photo
from kogao_core.field.field import shown_at
from kogao_core.photo import accompanied
from kogao_core.photo.metadata import kinds

SIZE, SCALE = (352, 256), 2  # of the upright picture; of its gain map
OPLUS, XIAOMI = (f"http://ns.{name}.com/photos/1.0/camera/" for name in ("oplus", "xiaomi"))
FILM = metadata_cases.MP4


def jpeg(pixels, *segments, **options):
    data = files.saved(pixels, "JPEG", **{"quality": 92, "subsampling": 0} | options)
    at = 4 + int.from_bytes(data[4:6], "big")  # behind JFIF
    return data[:at] + b"".join(segments) + data[at:]


def light(channels):
    """Return what a gain map holds, upright: smooth, so that a JPEG does well with it."""
    fine = textured_photo(SIZE[0] // SCALE, SIZE[1] // SCALE, channels, seed=9)
    return cv2.blur(fine, (7, 7))


def gain_map(orientation, channels, **options):
    xmp = metadata_cases.packet('hdrgm:Version="1.0" hdrgm:GainMapMax="2.5"', name="map")
    return jpeg(
        stored_for(light(channels), orientation),
        metadata_cases.ISO_GAIN_MAP,
        xmp=xmp,
        quality=98,
        **options,
    )


def phone(orientation=6, channels=1, film=b"", told="", **options):
    """Return what an Android phone writes: Ultra HDR, and a film."""
    more = gain_map(orientation, channels, **options)
    items = [("Primary", 0), ("GainMap", len(more)), ("Original", 0)]
    items += [("MotionPhoto", len(film))] if film else []
    xmp = metadata_cases.packet(f'hdrgm:Version="1.0" {told}', metadata_cases.container(*items))
    return jpeg(
        stored_for(textured_photo(*SIZE, 3), orientation),
        metadata_cases.ISO_GAIN_MAP,
        metadata_cases.multi_picture(len(more)),
        xmp=xmp, exif=metadata_cases.turned(orientation),
    ) + more + film  # fmt: skip


@dataclass
class Done:
    """A photo, what was done to it, what was said, and the file."""

    source: photo.Photo
    rendering: kogao.Rendering
    said: str
    data: bytes

    @property
    def index(self):
        """Where the pictures start, and how long they are, by the index of CIPA DC-007."""
        at = self.data.index(b"MPF\0") + 4
        entries = [struct.unpack_from(">II", self.data, at + 54 + 16 * one) for one in (0, 1)]
        return [(0, entries[0][0]), (at + entries[1][1], entries[1][0])]

    @property
    def gain_map(self):
        """The file of the gain map."""
        start, length = self.index[1]
        return self.data[start : start + length]

    @property
    def items(self):
        """Semantic and length of each item of Google's directory."""
        pattern = rb'Item:Semantic="(\w+)" Item:Mime="[^"]*" Item:Length="(\d+)"'
        return [(name.decode(), int(length)) for name, length in re.findall(pattern, self.data)]


def warped(tmp_path, data, *, film=False, out="out.jpg"):
    (tmp_path / out).unlink(missing_ok=True)
    source = files.opened(tmp_path / "in.jpg", data)
    face = oval_face(source.width, source.height)
    rendering = kogao.render(source.pixels, [face], kogao.Recipe(percent=6))
    along = accompanied(source, rendering.warped, film=film)
    said = photo.write(along, rendering.pixels, tmp_path / out)
    return Done(source, rendering, said, (tmp_path / out).read_bytes())


def decoded(data):
    with Image.open(io.BytesIO(data)) as image:
        return np.array(image)


def coefficients(data, tmp_path):
    (tmp_path / "read.jpg").write_bytes(data)
    found = jpeglib.read_dct(str(tmp_path / "read.jpg"))
    return [plane for plane in (found.Y, found.Cb, found.Cr) if plane is not None]


@pytest.mark.parametrize("channels", [1, 3])
@pytest.mark.parametrize("orientation", [1, 3, 6])
def test_a_gain_map_is_warped_by_the_same_field(tmp_path, orientation, channels):
    done = warped(tmp_path, phone(orientation, channels))
    assert "not kept" not in done.said
    found = decoded(done.gain_map)
    before = light(channels)
    large = cv2.resize(before, SIZE, interpolation=cv2.INTER_CUBIC)
    truth = kogao.render(large, [oval_face(*SIZE)], kogao.Recipe(percent=6)).pixels
    truth = cv2.resize(truth, before.shape[1::-1], interpolation=cv2.INTER_AREA)
    upright = {1: found, 3: np.rot90(found, 2), 6: np.rot90(found, -1)}[orientation]
    left, was = (np.abs(one.astype(int) - truth).mean() for one in (upright, before))
    assert left < 1.0 < was / 2.0


@pytest.mark.parametrize("channels", [1, 3])
def test_a_map_of_the_photos_size_is_warped_to_the_bit_as_the_photo_is(channels):
    picture = textured_photo(*SIZE, channels)
    rendering = kogao.render(picture, [oval_face(*SIZE)], kogao.Recipe(percent=6))
    assert (rendering.pixels != picture).any()
    np.testing.assert_array_equal(rendering.warped(picture), rendering.pixels)


def test_blocks_of_a_gain_map_that_nothing_changed_stay_and_so_do_its_headers(tmp_path):
    data = phone()
    done = warped(tmp_path, data)
    first = data[data.rindex(b"\xff\xd8\xff") :]
    tables = first.index(b"\xff\xdb")
    assert first[:tables] == done.gain_map[:tables]
    (old,), (new,) = (coefficients(one, tmp_path) for one in (first, done.gain_map))
    lying = decoded(first)
    moved = np.rot90(done.rendering.warped(np.rot90(lying, -1)), 1) != lying
    blocks = moved.reshape(moved.shape[0] // 8, 8, -1, 8).any(axis=(1, 3))
    assert 0.1 < blocks.mean() < 0.9
    assert (old == new).all(axis=(2, 3))[~blocks].all()
    assert (old != new).any(axis=(2, 3))[blocks].any()


def test_index_and_directory_tell_where_things_are(tmp_path):
    done = warped(tmp_path, phone(film=FILM), film=True)
    (_, first), (start, length) = done.index
    assert start == first
    assert done.data[first - 2 : first] == b"\xff\xd9"
    assert done.data[first : first + 3] == b"\xff\xd8\xff"
    assert first + length + len(FILM) == len(done.data)
    assert done.items == [("Primary", 0), ("GainMap", length), ("MotionPhoto", len(FILM))]
    assert done.data.endswith(FILM)
    again = photo.read(tmp_path / "out.jpg")
    assert {extra.kind for extra in again.extras if extra.data} == {kinds.GAIN_MAP, kinds.VIDEO}


@pytest.mark.parametrize("form", ["google", "micro"])
@pytest.mark.parametrize("film", [True, False])
def test_a_film_stays_by_choice_and_the_claims_of_all_makers_go_with_it(tmp_path, form, film):
    told = f'xmlns:OpCamera="{OPLUS}" OpCamera:VideoLength="52" OpCamera:OLivePhotoVersion="2" '
    told += f'OpCamera:MotionPhotoOwner="oplus" xmlns:MiCamera="{XIAOMI}" '
    told += 'MiCamera:XMPMeta="&lt;depthmap length=&quot;9&quot; offset=&quot;99&quot;/>" '
    if form == "google":
        told += 'GCamera:MotionPhoto="1"'
        data = phone(film=FILM, told=told)
    else:
        told += 'GCamera:MicroVideo="1" GCamera:MicroVideoOffset="9999"'
        data = jpeg(textured_photo(*SIZE, 3), xmp=metadata_cases.packet(told)) + FILM
    done = warped(tmp_path, data, film=film)
    assert ("still shows the original face" in done.said) == film
    assert ("not kept: the motion photo's video" in done.said) == (not film)
    assert b"MiCamera:XMPMeta" not in done.data
    claims = (b"GCamera:M", b"OpCamera:V", b"OpCamera:O", b"OpCamera:M")
    assert [claim in done.data for claim in claims] == [film] * len(claims)
    assert (FILM in done.data) == film
    assert b'MicroVideoOffset="%d"' % len(FILM) in done.data or form == "google" or not film


def test_apples_gain_map_goes_along_without_a_word_in_the_photos_own_xmp(tmp_path):
    xmp = metadata_cases.packet('HDRGainMap:HDRGainMapVersion="131072"', name="map")
    more = jpeg(light(1), xmp=xmp)
    index = metadata_cases.multi_picture(len(more))
    done = warped(tmp_path, jpeg(textured_photo(*SIZE, 3), index) + more)
    assert "not kept" not in done.said
    assert done.gain_map.count(xmp) == 1
    assert done.source.xmp is photo.read(tmp_path / "out.jpg").xmp is None


def test_a_film_that_nothing_would_find_is_named(tmp_path):
    """As Samsung's of old: its own directory of the file's end isn't written."""
    end = metadata_cases.samsung(0x0A30, b"MotionPhoto_Data", FILM)
    done = warped(tmp_path, jpeg(textured_photo(*SIZE, 3)) + end, film=True)
    assert "not kept: the motion photo's video, Samsung's data at the end" in done.said
    assert FILM not in done.data


@pytest.mark.parametrize("suffix", [".png", ".tif", ".webp"])
def test_other_formats_name_what_they_cannot_hold(tmp_path, suffix):
    done = warped(tmp_path, phone(film=FILM), film=True, out=f"out{suffix}")
    assert "not kept: the HDR gain map, the motion photo's video" in done.said
    assert not [
        word for word in (b"hdrgm:Ver", b"Container:D", b"21496", FILM) if word in done.data
    ]


def test_a_gain_map_that_cannot_be_read_or_has_another_shape_is_named(tmp_path):
    """The shape doesn't tell how to turn or crop the gain map."""
    whole = phone()
    damaged = whole[: whole.rindex(b"\xff\xda") - 40] + b"\xff\xd9"
    lying = jpeg(stored_for(light(1), 6), metadata_cases.ISO_GAIN_MAP)
    other = jpeg(textured_photo(*SIZE, 3)) + lying
    for data, gone in ((damaged, b"hdrgm:Version"), (other, lying[-40:])):
        done = warped(tmp_path, data)
        assert "not kept: the HDR gain map" in done.said
        assert gone in data
        assert gone not in done.data


def test_a_gain_map_whose_blocks_cannot_stay_is_compressed_again_by_its_own_tables(tmp_path):
    pixels = light(3)
    with jpeglib.version("9e"):
        coded = jpeglib.from_spatial(pixels)
        coded.write_spatial(str(tmp_path / "rare.jpg"), qt=95, flags=["+ARITH_CODE"])
    rare = (tmp_path / "rare.jpg").read_bytes()
    told = files.segment(0xE1, b"http://ns.adobe.com/xap/1.0/\0" + metadata_cases.packet("", "x"))
    rare = rare[:2] + metadata_cases.ISO_GAIN_MAP + told + rare[2:]
    picture = jpeg(textured_photo(*SIZE, 3), metadata_cases.ISO_GAIN_MAP)
    done = warped(tmp_path, picture + rare)
    assert "not kept" not in done.said
    assert done.gain_map.count(told) == 1
    assert np.abs(decoded(done.gain_map).astype(int) - done.rendering.warped(pixels)).mean() < 4.0


def luminance(data):
    linear = imagecodecs.ultrahdr_decode(data).astype(np.float32)
    return linear[..., :3] @ np.array([0.2126, 0.7152, 0.0722], np.float32)


@pytest.mark.parametrize(("scale", "most"), [(1, 0.03), (4, 0.05)])
def test_googles_own_reader_sees_the_hdr_picture_warped(tmp_path, scale, most):
    """The reference implementation wrote the file, too; it would lose more by writing it anew."""
    scene = cv2.GaussianBlur(textured_photo(*SIZE, 3), (0, 0), 3.0).astype(np.float32) / 255.0
    rgba = np.ones((*scene.shape[:2], 4), np.float16)
    rgba[..., :3] = scene * (1.0 + 3.0 * scene.max(axis=2, keepdims=True) ** 2)
    data = imagecodecs.ultrahdr_encode(rgba, level=97, scale=scale)
    done = warped(tmp_path, data)
    before, after = luminance(data), luminance(done.data)
    truth = kogao.render(before, [oval_face(*SIZE)], done.rendering.recipe).pixels
    moved = (done.rendering.pixels != done.source.pixels).any(axis=2)

    def off(seen):
        return np.percentile((np.abs(seen - truth) / np.maximum(truth, 0.05))[moved], 95)

    assert off(after) <= most < 0.1 < off(before)
    # Out of reach of those units, of either picture, that hold a pixel which moved.
    far = cv2.dilate(moved.astype(np.uint8), np.ones((24 * scale, 24 * scale), np.uint8)) == 0
    assert far.any()
    assert not np.abs(after - before)[far].any()


@pytest.mark.parametrize("percent", [4, 10])
def test_a_region_that_held_a_face_still_does(percent):
    """So regions of faces stay as they are: their own finders differ by more."""
    face, picture = oval_face(*SIZE), textured_photo(*SIZE, 1)
    rendering = kogao.render(picture, [face], kogao.Recipe(percent=percent))
    before = np.vstack([face.outline, face.eyes, face.mouth])
    after = shown_at(rendering.field, before)
    (left, top), (right, bottom) = before.min(axis=0), before.max(axis=0)
    (least_x, least_y), (most_x, most_y) = after.min(axis=0), after.max(axis=0)
    rises = percent / 100.0 * (bottom - top)  # a head without space above it comes up
    assert left <= least_x < most_x <= right
    assert top - rises <= least_y < most_y <= bottom
    kept = (most_x - least_x) * (most_y - least_y) / ((right - left) * (bottom - top))
    assert kept > (1.0 - percent / 50.0) ** 2


@pytest.mark.parametrize("film", [False, True])
def test_records_at_the_end_give_way_to_a_film(tmp_path, film):
    done = warped(tmp_path, phone(film=FILM) + metadata_cases.photo_mechanic(), film=film)
    assert ("not kept: Photo Mechanic's data at the end" in done.said) == film
    assert done.data.endswith(FILM if film else metadata_cases.photo_mechanic())
