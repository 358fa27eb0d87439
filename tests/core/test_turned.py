"""Numbers in the axes of a lying picture: a JPEG keeps lying, elsewhere they are turned."""

import struct
import xml.etree.ElementTree as ET

import files
import numpy as np
import pytest
from PIL import ExifTags, Image
from test_fidelity import stored_for

from kogao_core import photo
from kogao_core.photo.metadata.upright import Turn, turned_xmp

WIDTH, HEIGHT = 64, 48  # of the upright picture
# Of the upright picture: its left eye, a box round it, what a region names.
SUBJECT, AREA = (20, 9), (0.25, 0.125, 0.1, 0.3)
ADOBE = "http://ns.adobe.com/"
SPACES = {
    "mwg-rs": "http://www.metadataworkinggroup.com/schemas/regions/",
    "stArea": f"{ADOBE}xmp/sType/Area#",
    "stDim": f"{ADOBE}xap/1.0/sType/Dimensions#",
    "MP": "http://ns.microsoft.com/photo/1.2/",
    "MPRI": "http://ns.microsoft.com/photo/1.2/t/RegionInfo#",
    "MPReg": "http://ns.microsoft.com/photo/1.2/t/Region#",
    "tiff": f"{ADOBE}tiff/1.0/",
    "exif": f"{ADOBE}exif/1.0/",
    "crs": f"{ADOBE}camera-raw-settings/1.0/",
    "rdf": "http://www.w3.org/1999/02/22-rdf-syntax-ns#",
}


def lying(orientation, at, ends):
    """Return where a place of the upright picture lies in the stored one."""
    x, y = at
    far_x, far_y = ends[0] - x, ends[1] - y
    return {
        1: (x, y), 2: (far_x, y), 3: (far_x, far_y), 4: (x, far_y),
        5: (y, x), 6: (y, far_x), 7: (far_y, far_x), 8: (far_y, x),
    }[orientation]  # fmt: skip


def sides(orientation, of):
    return of[::-1] if orientation >= 5 else of


def exif(orientation):
    """Return an EXIF block that tells all that EXIF can of sides and places."""
    width, height = sides(orientation, (WIDTH, HEIGHT))
    subject = lying(orientation, SUBJECT, (WIDTH - 1, HEIGHT - 1))
    resolutions = sides(orientation, ((300, 1), (150, 1)))
    focal = sides(orientation, ((4000, 1), (2000, 1)))
    tags = {
        0x0100: (4, width), 0x0101: (4, height), 0x0112: (3, orientation),
        0x011A: (5, resolutions[0]), 0x011B: (5, resolutions[1]), 0x0128: (3, 2),
        0x8769: (4, {
            0x9214: (3, (*subject, *sides(orientation, (12, 7)))),
            0xA002: (4, width), 0xA003: (4, height),
            0xA20E: (5, focal[0]), 0xA20F: (5, focal[1]), 0xA214: (3, subject),
            0xA005: (4, {0x1001: (3, width), 0x1002: (3, height)}),
        }),
    }  # fmt: skip
    return b"Exif\0\0II*\0" + struct.pack("<I", 8) + files.directory(tags, 8)


def packet(orientation, as_attributes):
    """Return a packet with regions, as attributes (Apple, Adobe) or as elements (digiKam)."""
    width, height = sides(orientation, (WIDTH, HEIGHT))
    x, y = (f"{one:.3f}" for one in lying(orientation, AREA[:2], (1.0, 1.0)))
    w, h = (f"{one:.3f}" for one in sides(orientation, AREA[2:]))
    left, top = (float(at) - float(size) / 2 for at, size in ((x, w), (y, h)))
    subject = lying(orientation, SUBJECT, (WIDTH - 1, HEIGHT - 1))

    def structure(name, **values):
        prefix, name = name.rsplit("/", 1)
        if as_attributes:
            told = " ".join(f'{prefix}:{key}="{value}"' for key, value in values.items())
            return f"<{name} {told}/>"
        told = "".join(f"<{prefix}:{key}>{value}</{prefix}:{key}>" for key, value in values.items())
        return f'<{name} rdf:parseType="Resource">{told}</{name}>'

    spaces = " ".join(f'xmlns:{prefix}="{space}"' for prefix, space in SPACES.items())
    numbers = "".join(f"<rdf:li>{one}</rdf:li>" for one in subject)
    return (
        f'<x:xmpmeta xmlns:x="adobe:ns:meta/"><rdf:RDF {spaces}><rdf:Description rdf:about="" '
        f'tiff:Orientation="{orientation}" tiff:ImageWidth="{width}" tiff:ImageLength="{height}" '
        f'crs:CropLeft="0.125" crs:HasCrop="True" crs:Exposure2012="+0.50">'
        f"<exif:SubjectArea><rdf:Seq>{numbers}</rdf:Seq></exif:SubjectArea>"
        '<mwg-rs:Regions rdf:parseType="Resource">'
        + structure("stDim/mwg-rs:AppliedToDimensions", w=width, h=height, unit="pixel")
        + '<mwg-rs:RegionList><rdf:Bag><rdf:li><rdf:Description mwg-rs:Name="顔">'
        + structure("stArea/mwg-rs:Area", x=x, y=y, w=w, h=h, unit="normalized")
        + "</rdf:Description></rdf:li></rdf:Bag></mwg-rs:RegionList></mwg-rs:Regions>"
        '<MP:RegionInfo rdf:parseType="Resource"><MPRI:Regions><rdf:Bag>'
        f'<rdf:li MPReg:Rectangle="{left:.3f}, {top:.3f}, {w}, {h}"/></rdf:Bag></MPRI:Regions>'
        "</MP:RegionInfo></rdf:Description></rdf:RDF></x:xmpmeta>"
    ).encode()


def told(xmp):
    """Return the numbers of a packet by the names of their properties, as an XML parser sees it."""
    found = {}
    for element in ET.fromstring(xmp).iter():
        named = [(element.tag, element.text or ""), *element.attrib.items()]
        for name, value in named:
            if name.endswith("}li") and value.strip():
                name = f"{name}{len([one for one in found if one.startswith(name)])}"
            found |= {name: [float(part) for part in value.split(",")]} if is_numbers(value) else {}
    return found


def is_numbers(value):
    return value.strip() and all(
        part.strip().lstrip("-").replace(".", "", 1).isdigit() for part in value.split(",")
    )


def tags_of(block):
    """Return the tags of three directories; where one lies is none of them."""
    tags = Image.Exif()
    tags.load(block)
    inner = {name: tags.get_ifd(name) for name in (ExifTags.IFD.Exif, ExifTags.IFD.Interop)}
    pointers = {0x8769, 0xA005}
    return {
        name: {tag: value for tag, value in one.items() if tag not in pointers}
        for name, one in {0: dict(tags), **inner}.items()
    }


def turned_photo(tmp_path, orientation, as_attributes):
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH]
    pixels = np.stack([x * 4, y * 5, 200 - x * 2], axis=-1).astype(np.uint8)
    stored = Image.fromarray(stored_for(pixels, orientation))
    xmp = packet(orientation, as_attributes)
    told = {"exif": exif(orientation), "xmp": xmp, "dpi": sides(orientation, (300, 150))}
    stored.save(tmp_path / "in.jpg", quality=95, **told)
    return photo.read(tmp_path / "in.jpg")


@pytest.mark.parametrize("as_attributes", [True, False])
@pytest.mark.parametrize("orientation", range(2, 9))
def test_a_jpeg_lies_as_it_lay_and_every_number_stays_true(tmp_path, orientation, as_attributes):
    source = turned_photo(tmp_path, orientation, as_attributes)
    said = photo.write(source, source.pixels // 2, tmp_path / "out.jpg")
    again = photo.read(tmp_path / "out.jpg")
    assert "not kept" not in said
    assert (again.exif, again.xmp) == (source.exif, source.xmp)
    assert again.orientation == orientation
    assert np.abs(again.pixels.astype(int) - source.pixels // 2).mean() < 3.0


@pytest.mark.parametrize("suffix", [".png", ".tif", ".webp"])
@pytest.mark.parametrize("as_attributes", [True, False])
@pytest.mark.parametrize("orientation", range(2, 9))
def test_elsewhere_numbers_are_turned_or_named(tmp_path, orientation, as_attributes, suffix):
    source = turned_photo(tmp_path, orientation, as_attributes)
    said = photo.write(source, source.pixels // 2, tmp_path / f"out{suffix}")
    assert "not kept: positions in the unrotated picture" in said
    again = photo.read(tmp_path / f"out{suffix}")
    assert b"Crop" not in again.xmp
    assert b'crs:Exposure2012="+0.50"' in again.xmp
    expected = told(packet(1, as_attributes))
    del expected[f"{{{SPACES['crs']}}}CropLeft"]
    found = told(again.xmp)
    assert found.keys() == expected.keys()
    for name, numbers in expected.items():
        assert found[name] == pytest.approx(numbers, abs=1e-3), name
    for name, numbers in tags_of(exif(1)).items():
        if suffix != ".tif" or name:  # the first directory of a TIFF is its own
            assert tags_of(again.exif)[name] == numbers
    if suffix != ".webp":
        assert again.dpi == pytest.approx((300.0, 150.0), abs=0.02)


def test_regions_that_apply_to_the_upright_picture_are_not_turned_twice():
    upright = packet(1, True).replace(b'Orientation="1"', b'Orientation="6"')
    turned = told(turned_xmp(upright, Turn(6, WIDTH, HEIGHT)))
    area = [turned[f"{{{SPACES['stArea']}}}{name}"][0] for name in "xywh"]
    assert area == list(AREA)


@pytest.mark.parametrize("value", ["1e999999999", "nan", "", "0.5, 0.5", "x" * 100])
def test_what_is_no_number_stays(value):
    xmp = packet(6, True).replace(b'stArea:x="0.125"', f'stArea:x="{value}"'.encode())
    assert f'stArea:x="{value}"'.encode() in xmp
    assert f'stArea:x="{value}"'.encode() in turned_xmp(xmp, Turn(6, WIDTH, HEIGHT))


def test_places_in_a_makers_note_are_said_to_be_of_the_lying_picture(tmp_path):
    block = files.exif_block(6, HEIGHT, WIDTH)
    Image.new("RGB", (HEIGHT, WIDTH)).save(tmp_path / "in.jpg", exif=block)
    source = photo.read(tmp_path / "in.jpg")
    note = "positions in the maker's note are those of the unrotated picture"
    assert note in photo.write(source, source.pixels + 9, tmp_path / "out.png")
    assert note not in photo.write(source, source.pixels + 9, tmp_path / "out.jpg")
