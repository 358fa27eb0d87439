"""Photos as other programs write them: each loss is named, and limits are in bytes."""

from __future__ import annotations

import json
import shutil
import struct
import subprocess
import zlib

import files
import numpy as np
import pytest
import tifffile
from files import saved
from PIL import Image, ImageCms
from scenes import textured_photo

from kogao_core import photo
from kogao_core.batch.measures import table_text
from kogao_core.photo import reading
from kogao_core.photo.export import Export
from kogao_core.photo.formats.png import made
from kogao_core.photo.jpeg import segments
from kogao_core.photo.metadata.kinds import COLOURS

PICTURE = textured_photo(64, 48)
P3 = (31270, 32900, 68000, 32000, 26500, 69000, 15000, 6000)
COLOUR_CHUNKS = [
    made(b"cICP", bytes([10, 17, 0, 1])),
    made(b"cICP", bytes([9, 16, 9, 0])),
    made(b"gAMA", struct.pack(">I", 100000)),
    made(b"cHRM", struct.pack(">8I", *P3)),
]


def png(*chunks, **options):
    data = saved(Image.fromarray(PICTURE), "PNG", **options)
    return data[:33] + b"".join(chunks) + data[33:]


def read(tmp_path, data, name="in.png"):
    return files.opened(tmp_path / name, data)


@pytest.mark.parametrize("chunk", COLOUR_CHUNKS, ids=["XYZ", "narrow", "gamma", "cHRM"])
@pytest.mark.parametrize("profile", [None, ImageCms.createProfile("sRGB")], ids=["", "profile"])
def test_colours_of_unknown_meaning_are_not_called_srgb(tmp_path, chunk, profile):
    icc = profile and ImageCms.ImageCmsProfile(profile).tobytes()
    source = read(tmp_path, png(chunk, icc_profile=icc))
    if icc is None:  # else the chunk is one that readers ignore
        with pytest.raises(photo.RefusedOutput, match="can't be converted to sRGB"):
            Export(srgb=True).applied(source, source.pixels)
        return
    told, _ = Export(srgb=True).applied(source, source.pixels)
    assert told.carried == ()


def test_chunks_that_tell_srgb_are_converted(tmp_path):
    source = read(tmp_path, png(made(b"cICP", bytes([1, 13, 0, 1]))))
    assert COLOURS not in {one.kind for one in source.extras}
    _, pixels = Export(srgb=True).applied(source, source.pixels)
    assert (pixels == PICTURE).all()


def test_the_name_of_a_profile_in_a_png_stays(tmp_path):
    icc = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    source = read(tmp_path, png(made(b"iCCP", b"low 8b\0\0" + zlib.compress(icc))))
    photo.write(source, 255 - source.pixels, tmp_path / "out.png")
    assert b"iCCPlow 8b\0" in (tmp_path / "out.png").read_bytes()
    assert photo.read(tmp_path / "out.png").icc_profile == icc


def jpeg(*more, **options):
    data = saved(Image.fromarray(PICTURE), "JPEG", **options)
    at = segments.end_of_headers(data)
    return data[:at] + b"".join(more) + data[at:]


def exif(maker):
    block = Image.Exif()
    block[0x10F] = maker
    return block.tobytes()


def test_a_long_exif_block_goes_on_in_the_next_segment(tmp_path):
    whole = exif("x" * 70000)
    parts = whole[:60000], b"Exif\0\0" + whole[60000:]
    source = read(tmp_path, jpeg(*(segments.segment(0xE1, one) for one in parts)), "in.jpg")
    assert source.exif == whole


def test_a_tiff_with_nan_is_copied_where_nothing_changes(tmp_path):
    pixels = PICTURE[..., 0].astype(np.float32) / 255
    pixels[3, 4] = np.nan
    data = saved(pixels, "TIFF")
    source = read(tmp_path, data, "in.tif")
    photo.write(source, photo.read(tmp_path / "in.tif").pixels, tmp_path / "o.tif")
    assert (tmp_path / "o.tif").read_bytes() == data


@pytest.mark.parametrize("bits", [8, 16])
def test_a_tiff_with_0_as_white_is_named(tmp_path, bits):
    grey = PICTURE[..., 0].astype(np.uint16 if bits == 16 else np.uint8)
    tifffile.imwrite(tmp_path / "in.tif", grey.max() - grey, photometric="miniswhite")
    source = photo.read(tmp_path / "in.tif")
    assert (source.pixels == np.iinfo(grey.dtype).max - (grey.max() - grey)).all()
    note = photo.write(source, source.pixels // 2, tmp_path / "o.tif")
    assert note == "grey values are stored with 0 as black instead of white"
    with Image.open(tmp_path / "o.tif") as seen:
        assert seen.tag_v2[262] == 1
        np.testing.assert_array_equal(np.asarray(seen), source.pixels // 2)


def test_a_transparent_colour_of_a_png_is_named(tmp_path):
    key = struct.pack(">3H", *map(int, PICTURE[3, 4]))
    source = read(tmp_path, png(made(b"tRNS", key)))
    assert (source.pixels[..., 3] == 0).sum() == (PICTURE[3, 4] == PICTURE).all(axis=2).sum()
    note = photo.write(source, 255 - source.pixels, tmp_path / "o.png")
    assert note == "the transparent colour became an alpha channel"


def test_the_limit_counts_bytes_not_pixels(tmp_path, monkeypatch):
    deep = np.zeros((40, 50, 4), np.uint16)
    import cv2

    cv2.imwrite(str(tmp_path / "deep.png"), deep)
    Image.fromarray(deep[..., 0].astype(np.uint8)).save(tmp_path / "grey.png")
    limit = 40 * 50 * 3 / 1e6
    assert photo.read(tmp_path / "deep.png", max_megapixels=limit).bits == 16
    assert photo.read(tmp_path / "grey.png", max_megapixels=limit / 3).bits == 8
    with pytest.raises(photo.UnreadablePhoto, match="of memory"):
        photo.read(tmp_path / "deep.png", max_megapixels=limit / 2)
    monkeypatch.setattr(reading, "_free_bytes", lambda: 40 * 50 * 8.0)
    with pytest.raises(photo.UnreadablePhoto, match="close other programs"):
        photo.read(tmp_path / "deep.png")


def test_a_jpeg_of_very_many_segments_is_refused(tmp_path):
    data = jpeg(*[segments.segment(0xFE, b"")] * 6000)
    with pytest.raises(photo.UnreadablePhoto, match="5,000 segments"):
        read(tmp_path, data, "in.jpg")


def test_names_of_photos_are_no_formulas_in_a_table():
    names = ["=HYPERLINK(0).jpg", "+1.jpg", "-2.5", "@x", "a\x1b[2J.jpg", "plain.jpg"]
    cells = table_text([names, [-1.5, "1"]]).splitlines()
    assert cells == ["'=HYPERLINK(0).jpg,'+1.jpg,-2.5,'@x,a?[2J.jpg,plain.jpg", "-1.5,1"]


WRITTEN = (
    *(
        "-XMP-dc:Title=Title",
        "-XMP-dc:Subject=one",
        "-XMP-xmp:Rating=4",
        "-XMP-photoshop:City=Kobe",
    ),
    *("-EXIF:Artist=Me", "-EXIF:Copyright=(c) Me", "-EXIF:LensModel=50mm", "-EXIF:XResolution=300"),
    *("-EXIF:ExposureTime=1/60", "-EXIF:DateTimeOriginal=2026:01:02 03:04:05"),
    *("-GPS:GPSLatitude=35.1", "-GPS:GPSLatitudeRef=N", "-IPTC:Keywords=key"),
    "-XMP-mwg-rs:RegionInfo={AppliedToDimensions={W=64,H=48,Unit=pixel},RegionList=[{Area={X=0.5,"
    "Y=0.5,W=0.2,H=0.3,Unit=normalized},Name=Ann,Type=Face}]}",
)


@pytest.mark.skipif(not shutil.which("exiftool"), reason="needs ExifTool")
def test_metadata_written_by_exiftool_are_in_the_result(tmp_path):
    """The files are Pillow's, and ImageMagick's if the system has ImageMagick."""
    paths = [tmp_path / f"in{suffix}" for suffix in (".jpg", ".png", ".tif", ".webp", ".avif")]
    for path in paths:
        Image.fromarray(PICTURE).save(path)
    for path in paths[:4] if shutil.which("convert") else ():
        paths.append(path.with_stem("magick"))
        subprocess.run(["convert", path, paths[-1]], check=True)
    subprocess.run(["exiftool", "-q", "-overwrite_original", *WRITTEN, *paths], check=True)
    results = [path.with_stem(f"{path.stem}-out") for path in paths]
    for path, out in zip(paths, results, strict=True):
        source = photo.read(path)
        photo.write(source, 255 - source.pixels, out)
    groups = [f"-{name}:all" for name in ("XMP", "ExifIFD", "GPS", "IPTC")]
    command = ["exiftool", "-j", "-G1", *groups, "-EXIF:Artist", "-EXIF:Copyright"]
    done = subprocess.run([*command, *paths, *results], capture_output=True, check=True)
    # A TIFF gets a copy of the IPTC record among Photoshop's resources (IPTC2).
    told = [
        {name: value for name, value in one.items() if not name.startswith(("Source", "IPTC2"))}
        for one in json.loads(done.stdout)
    ]
    for path, before, after in zip(paths, told, told[len(paths) :], strict=False):
        assert len(before) >= 15, path
        assert after == before, path
