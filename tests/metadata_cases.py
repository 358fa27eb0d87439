"""What files hold beside their pictures, built by the published layouts and without Kogao.

Each of `CASES` is a small file with one such thing in it, and bytes that tell whether it is there.
"""

import struct
from dataclasses import dataclass

import files
import numpy as np
from PIL import Image

from kogao_core.photo.metadata import kinds

HEIGHT, WIDTH = 48, 64
MARK = b"told by nothing else"
GOOGLE = "http://ns.google.com/photos/1.0/"
ISO_GAIN_MAP = files.segment(0xE2, b"urn:iso:std:iso:ts:21496:-1\0\0\0\0\0")
CAPTION = b"\x1c\x02\x78" + struct.pack(">H", len(MARK)) + MARK  # IIM
MP4 = (
    struct.pack(">I4s4sI4s", 20, b"ftyp", b"mp42", 0, b"isom")
    + struct.pack(">I4s", 8 + len(MARK), b"mdat") + MARK
    + struct.pack(">I4s", 8, b"moov")
)  # fmt: skip


SPACES = {
    "hdrgm": "http://ns.adobe.com/hdr-gain-map/1.0/",
    "HDRGainMap": "http://ns.apple.com/HDRGainMap/1.0/",
    "GCamera": f"{GOOGLE}camera/",
    "GDepth": f"{GOOGLE}depthmap/",
    "GImage": f"{GOOGLE}image/",
    "Container": f"{GOOGLE}container/",
    "Item": f"{GOOGLE}container/item/",
    "dcterms": "http://purl.org/dc/terms/",
    "xmpNote": "http://ns.adobe.com/xmp/note/",
    "crs": "http://ns.adobe.com/camera-raw-settings/1.0/",
    "dc": "http://purl.org/dc/elements/1.1/",
}


@dataclass(frozen=True)
class Case:
    """A file and the thing in it: its kind, what a note calls it, and bytes that only it has."""

    label: str
    suffix: str
    data: bytes
    kind: kinds.Kind
    marks: tuple[bytes, ...] = (MARK,)
    name: str = ""

    def __str__(self):
        return self.label


def pixels(channels=3, dtype=np.uint8):
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH]
    planes = [y * 4 + x, 200 - x * 2 + y // 2, 60 + y * 2, 255 - y, x * 2][:channels]
    values = np.stack(planes, -1).clip(0, 255).astype(dtype)
    return values[..., 0] if channels == 1 else values


def packet(attributes="", content="", name="photo"):
    told = f"{attributes} {content} dc:"
    spaces = " ".join(
        f'xmlns:{prefix}="{space}"' for prefix, space in SPACES.items() if f"{prefix}:" in told
    )
    return (
        '<x:xmpmeta xmlns:x="adobe:ns:meta/"><rdf:RDF xmlns:rdf="http://www.w3.org/1999/02/22-rdf-'
        f'syntax-ns#"><rdf:Description rdf:about="" {spaces} {attributes} dc:format="{name}">'
        f"<dc:source>Me &amp; 顔</dc:source>{content}</rdf:Description></rdf:RDF></x:xmpmeta>"
    ).encode()


def container(*items):
    listed = "".join(
        f'<rdf:li rdf:parseType="Resource"><Container:Item Item:Semantic="{semantic}" '
        f'Item:Mime="image/jpeg" Item:Length="{length}"/></rdf:li>'
        for semantic, length in items
    )
    return f"<Container:Directory><rdf:Seq>{listed}</rdf:Seq></Container:Directory>"


def jpeg(*segments, xmp=None, profile=files.SRGB, end=b"", **options):
    more = {name: one for name, one in (("xmp", xmp), ("icc_profile", profile)) if one}
    data = files.saved(pixels(), "JPEG", quality=90, **more, **options)
    at = 4 + int.from_bytes(data[4:6], "big")  # behind JFIF
    return data[:at] + b"".join(segments) + data[at:] + end


def multi_picture(length):
    """Return an MPF index of two pictures (CIPA DC-007)."""
    entries = struct.pack("<5I", 0x030000, 1000, 0, 0, 0)[:16]
    entries += struct.pack("<4I", 0, length, 1000, 0)
    index = {0xB000: (7, b"0100"), 0xB001: (4, 2), 0xB002: (7, entries)}
    return files.segment(0xE2, b"MPF\0II*\0" + struct.pack("<I", 8) + files.directory(index, 8))


def gain_map(xmp):
    return files.saved(pixels(1), "JPEG", xmp=xmp, comment=MARK)


def ultra_hdr():
    more = gain_map(packet('hdrgm:Version="1.0" hdrgm:GainMapMax="2.5"', name="map"))
    xmp = packet('hdrgm:Version="1.0"', container(("Primary", 0), ("GainMap", len(more))))
    return jpeg(ISO_GAIN_MAP, multi_picture(len(more)), xmp=xmp, end=more)


def apple_hdr():
    more = gain_map(packet('HDRGainMap:HDRGainMapVersion="65536"', name="map"))
    return jpeg(multi_picture(len(more)), end=more)


def motion_photo():
    told = 'GCamera:MotionPhoto="1" GCamera:MotionPhotoVersion="1" '
    told += "GCamera:MotionPhotoPresentationTimestampUs='500000'"
    listed = container(("Primary", 0), ("MotionPhoto", len(MP4)))
    return jpeg(xmp=packet(told, listed), end=MP4)


def micro_video():
    content = f"<GCamera:MicroVideoOffset>{len(MP4)}</GCamera:MicroVideoOffset>"
    return jpeg(xmp=packet('GCamera:MicroVideo="1"', content), end=MP4)


def samsung(kind, name, content):
    """Return a block with the directory that Samsung puts behind its blocks."""
    block = struct.pack("<HHI", 0, kind, len(name)) + name + content
    entry = struct.pack("<HHII", 0, kind, len(block), len(block))
    head = b"SEFH" + struct.pack("<II", 106, 1) + entry
    return block + head + struct.pack("<I", len(head)) + b"SEFT"


def photo_mechanic():
    """Return its record of soft edits: the picture is to be shown turned."""
    record = struct.pack(">BBBHI", 0x1C, 2, 216, 4, 90) + CAPTION
    return record + struct.pack(">I", len(record)) + b"cbipcbbl"


def fotostation(tag=1, record=CAPTION):
    return record + struct.pack(">HI", tag, len(record) + 10) + b"\xa1\xb2\xc3\xd4"


def box(name, body):
    return struct.pack(">I4s", 8 + len(body), name) + body


def jumbf(label):
    """Return a segment with a JUMBF superbox of that label, of 4 bytes (ISO 19566-5)."""
    told = box(b"jumd", label + bytes.fromhex("00110010800000aa00389b71") + b"\3" + label + b"\0")
    return files.segment(0xEB, b"JP\0\1\0\0\0\1" + box(b"jumb", told + box(b"bidb", MARK)))


def profile_part(number, total, body):
    return files.segment(0xE2, b"ICC_PROFILE\0" + bytes([number, total]) + body)


def with_note():
    return jpeg(exif=files.exif_block(1, WIDTH, HEIGHT))


def turned(orientation):
    tags = {0x0112: (3, orientation)}
    return b"Exif\0\0II*\0" + struct.pack("<I", 8) + files.directory(tags, 8)


def rare_exif():
    tags = {0xC765: (7, MARK)}
    return jpeg(exif=b"Exif\0\0II*\0" + struct.pack("<I", 8) + files.directory(tags, 8))


def between_scans(segment, *more, **options):
    data = jpeg(*more, progressive=True, **options)
    at = data.rindex(b"\xff\xda")
    return data[:at] + segment + data[at:]


def png(*chunks, end=b""):
    data = files.saved(pixels(), "PNG")
    return data[:33] + b"".join(files.chunk(*one) for one in chunks) + data[33:] + end


def tiff(more=None, channels=3, end=b"", follow=b""):
    stored = pixels(channels).tobytes()
    tags = {
        256: (4, WIDTH), 257: (4, HEIGHT), 258: (3, [8] * channels), 259: (3, 1),
        262: (3, 2), 273: (4, 8), 277: (3, channels), 278: (4, HEIGHT), 279: (4, len(stored)),
        284: (3, 1), **(more or {}),
    }  # fmt: skip
    if channels > 3:
        tags[338] = (3, [0] * (channels - 3))
    start = 8 + len(stored)
    first = files.directory(tags, start)
    if follow:
        first = files.directory(tags, start, follow=start + len(first))
    return b"II*\0" + struct.pack("<I", start) + stored + first + follow + end


def webp(*chunks, end=b""):
    exif = b"Exif\0\0II*\0\x08" + bytes(9)  # without entries
    data = files.saved(pixels(), "WEBP", lossless=True, exif=exif)
    data += b"".join(
        name + struct.pack("<I", len(body)) + body + b"\0" * (len(body) % 2)
        for name, body in chunks
    )
    return data[:4] + struct.pack("<I", len(data) - 8) + data[8:] + end


def animated(form):
    first, second = Image.fromarray(pixels()), Image.fromarray(255 - pixels())
    return files.saved(first, form, save_all=True, append_images=[second], lossless=True)


def _depth():
    xmp = packet('GDepth:Format="RangeInverse" GDepth:Data="told by nothing else"')
    return jpeg(xmp=xmp)


def _original():
    return jpeg(xmp=packet("", "<GImage:Data>told by nothing else</GImage:Data>"))


def _extended(content):
    head = b"http://ns.adobe.com/xmp/extension/\0" + b"5" * 32 + struct.pack(">II", 99, 0)
    more = files.segment(0xE1, head + content)
    return jpeg(more, xmp=packet(f'xmpNote:HasExtendedXMP="{"5" * 32}"'))


def kept():
    """Return a JPEG with one of each of what a changed one keeps, and with a true thumbnail."""
    small = jpeg(profile=None)
    more = (
        files.segment(0xE1, files.exif_block(6, WIDTH, HEIGHT, thumbnail=small)),
        files.segment(0xE1, XMP_HEAD + packet('hdrgm:Version="1.0"')),
        *(jumbf(b"json"), files.segment(0xFE, MARK), files.segment(0xE7, b"Maker\0" + MARK)),
        *(profile_part(1, 1, files.SRGB), profile_part(1, 2, MARK)),
    )
    ends = samsung(0x0A01, b"Image_UTC_Data", b"1700000000000") + photo_mechanic() + fotostation()
    between = files.segment(0xFE, MARK) + files.segment(0xE1, XMP_HEAD + packet())
    return between_scans(between, *more, xmp=packet(name="two"), profile=None) + ends


XMP_HEAD = b"http://ns.adobe.com/xap/1.0/\0"
CASES = [
    Case("Ultra HDR", ".jpg", ultra_hdr(), kinds.GAIN_MAP,
         (MARK, b"hdrgm:Version", b"21496", b"MPF\0", b"Container:Directory")),
    Case("Apple's HDR", ".jpg", apple_hdr(), kinds.GAIN_MAP, (MARK, b"MPF\0")),
    Case("ISO 21496-1", ".jpg", jpeg(ISO_GAIN_MAP), kinds.GAIN_MAP, (b"21496",)),
    Case("JPEG-HDR", ".jpg", jpeg(files.segment(0xEB, b"HDR_RI ver=11" + MARK)), kinds.JPEG_HDR),
    Case("motion photo", ".jpg", motion_photo(), kinds.VIDEO,
         (MARK, b"GCamera:MotionPhoto", b"Container:Directory")),
    Case("micro video", ".jpg", micro_video(), kinds.VIDEO, (MARK, b"GCamera:MicroVideo")),
    Case("Samsung's video", ".jpg", jpeg(end=samsung(0x0A30, b"MotionPhoto_Data", MP4)),
         kinds.VIDEO, (MARK, b"SEFT")),
    Case("Samsung", ".jpg", jpeg(end=samsung(0x0A01, b"Image_UTC_Data", b"1700000000000")),
         kinds.SAMSUNG, (b"1700000000000", b"SEFT")),
    Case("Samsung's pictures", ".jpg",
         jpeg(end=samsung(0x0AB1, b"DualShot_DepthMap_1", b"\1" + MARK)), kinds.UNKNOWN,
         (MARK, b"SEFT"), "Samsung's data at the end"),
    Case("Photo Mechanic", ".jpg", jpeg(end=photo_mechanic()), kinds.PHOTO_MECHANIC),
    Case("FotoStation", ".jpg", jpeg(end=fotostation()), kinds.FOTOSTATION),
    Case("FotoStation's preview", ".jpg", jpeg(end=fotostation(4, MARK + files.THUMBNAIL)),
         kinds.UNKNOWN, name="FotoStation's data at the end"),
    *(Case(f"unknown end, {suffix}", suffix, make(end=MARK), kinds.UNKNOWN,
           name="20 bytes of unknown data at the end")
      for suffix, make in ((".jpg", jpeg), (".png", png), (".tif", tiff), (".webp", webp))),
    Case("several ends", ".jpg",
         jpeg(end=MP4 + MARK + fotostation(4, files.THUMBNAIL)),
         kinds.VIDEO, name="the motion photo's video, 20 bytes of unknown data at the end, "
         "FotoStation's data at the end"),
    Case("second picture", ".jpg", jpeg(multi_picture(9), end=gain_map(packet())), kinds.FURTHER),
    Case("pages", ".tif", tiff(follow=files.directory({256: (4, 1), 257: (4, 1)}, 0)),
         kinds.FURTHER, ()),
    Case("sub-directory", ".tif", tiff({330: (4, {256: (4, 1)})}), kinds.FURTHER, ()),
    Case("animated PNG", ".png", animated("PNG"), kinds.FURTHER, (b"fdAT",)),
    Case("animated WebP", ".webp", animated("WEBP"), kinds.FURTHER, (b"ANMF",)),
    Case("depth map", ".jpg", _depth(), kinds.DEPTH, (MARK, b"GDepth:Format")),
    Case("depth map outside", ".jpg", _extended(f"{GOOGLE}depthmap/".encode() + MARK),
         kinds.DEPTH, (MARK, b"HasExtendedXMP")),
    Case("picture in XMP", ".jpg", _original(), kinds.ORIGINAL),
    Case("credentials", ".jpg", jpeg(jumbf(b"c2pa")),
         kinds.CREDENTIALS),
    Case("remote credentials", ".jpg", jpeg(xmp=packet('dcterms:provenance="https://e.org/x"')),
         kinds.CREDENTIALS_LINK, (b"dcterms:provenance",)),
    Case("credentials of a PNG", ".png", png((b"caBX", b"c2pa" + MARK)), kinds.CREDENTIALS),
    Case("credentials of a TIFF", ".tif", tiff({52545: (7, MARK)}), kinds.CREDENTIALS),
    Case("credentials of a WebP", ".webp", webp((b"C2PA", MARK)), kinds.CREDENTIALS),
    Case("JUMBF", ".jpg", jpeg(jumbf(b"json")), kinds.JUMBF),
    Case("JUMBF of another kind", ".jpg", jpeg(jumbf(b"bidb")), kinds.UNKNOWN,
         name="JUMBF data (APP11)"),
    Case("two profiles", ".jpg",
         jpeg(profile_part(1, 1, files.SRGB), profile_part(1, 1, MARK), profile=None),
         kinds.SECOND_PROFILE),
    Case("half a profile", ".jpg",
         jpeg(profile_part(1, 1, files.SRGB), profile_part(1, 2, MARK), profile=None),
         kinds.SECOND_PROFILE, name="an incomplete colour profile"),
    Case("two packets", ".jpg", jpeg(files.segment(0xE1, XMP_HEAD + packet()), xmp=MARK),
         kinds.SECOND_XMP),
    Case("XMP in Photoshop's resources", ".jpg", jpeg(files.segment(
        0xED, b"Photoshop 3.0\x008BIM\x04\x24\0\0\0\0\0\x14" + MARK)), kinds.PHOTOSHOP_XMP),
    Case("XMP in a TIFF's resources", ".tif",
         tiff({34377: (1, b"8BIM\x04\x24\0\0\0\0\0\x14" + MARK)}), kinds.PHOTOSHOP_XMP),
    Case("two EXIF blocks", ".jpg", jpeg(files.segment(0xE1, b"Exif\0\0II*\0\x08" + bytes(9)),
         files.segment(0xE1, b"Exif\0\0II*\0" + MARK)), kinds.SECOND_EXIF),
    Case("extended XMP", ".jpg", _extended(MARK), kinds.XMP_EXTENSION, (MARK, b"HasExtendedXMP")),
    Case("comment", ".jpg", jpeg(files.segment(0xFE, MARK)), kinds.COMMENTS),
    *(Case(f"{label} between scans", ".jpg", between_scans(files.segment(code, head + MARK)),
           kinds.UNKNOWN, name="metadata between the scans")
      for label, code, head in (
          ("comment", 0xFE, b""), ("preview", 0xE4, files.THUMBNAIL), ("XMP", 0xE1, XMP_HEAD),
          ("EXIF", 0xE1, b"Exif\0"))),
    *(Case(label, ".jpg", jpeg(files.segment(code, head + MARK)), kinds.SEGMENTS)
      for label, code, head in (
          ("CIFF", 0xE0, b"II\x1a\0\0\0HEAPJPGM"), ("AVI1", 0xE0, b"AVI1\0"),
          ("Adobe_CM", 0xED, b"Adobe_CM\0"), ("maker's", 0xE7, b"Maker\0"))),
    Case("FlashPix", ".jpg",
         jpeg(*(files.segment(0xE2, b"FPXR\0\0" + one)
                for one in (MARK, MARK + files.THUMBNAIL, b"rest"))),
         kinds.PREVIEW, (MARK, b"FPXR"), "a maker's segment with a preview (APP2)"),
    Case("preview", ".jpg", jpeg(files.segment(0xE4, b"view" + MARK + files.THUMBNAIL)),
         kinds.PREVIEW, name="a maker's segment with a preview (APP4)"),
    Case("maker's note", ".jpg", with_note(), kinds.MAKER_NOTE, (files.MAKER_NOTE,)),
    Case("maker's note of a TIFF", ".tif", tiff({0x8769: (4, {0x927C: (7, files.MAKER_NOTE)})}),
         kinds.MOVED_NOTE, (files.MAKER_NOTE,)),
    Case("rare EXIF tag", ".jpg", rare_exif(), kinds.EXIF_TAGS, name="EXIF tags 51045"),
    Case("Lightroom's crop, turned", ".jpg",
         jpeg(exif=turned(6), xmp=packet(f'crs:CropTop="{MARK.decode()}"')),
         kinds.PLACES),
    Case("path, turned", ".jpg",
         jpeg(files.segment(0xED, b"Photoshop 3.0\x008BIM\x07\xd0\0\0\0\0\0\x14" + MARK),
              exif=turned(8)), kinds.PLACES),
    Case("text", ".png", png((b"tEXt", b"Title\0" + MARK)), kinds.TEXTS),
    Case("ImageMagick's text", ".png", png((b"tEXt", b"Raw profile type xmp\0" + MARK)),
         kinds.TEXTS),
    Case("gamma", ".png", png((b"gAMA", struct.pack(">I", 100000))), kinds.COLOURS, (b"gAMA",)),
    Case("rare colours", ".png", png((b"cICP", bytes([10, 9, 0, 1]))), kinds.COLOURS, (b"cICP",)),
    *(Case(name.decode(), ".png", png((name, body)), kinds.CHUNKS, (name + body,),
           f"PNG chunks {name.decode()}")
      for name, body in (
          (b"sBIT", bytes([5, 6, 5])), (b"bKGD", bytes(5) + b"\7"), (b"oFFs", bytes(8) + b"\1"),
          (b"sTER", b"\1"), (b"sCAL", b"\x011\0001"))),
    Case("safe to copy", ".png", png((b"prIv", MARK)), kinds.CHUNKS, name="PNG chunks prIv"),
    *(Case(label, ".png", png((name, MARK)), kinds.UNSAFE_CHUNKS, (name + MARK,),
           f"PNG chunks {name.decode()}")
      for label, name in (("tIME", b"tIME"), ("unsafe to copy", b"prIV"))),
    Case("background of a palette", ".png", png((b"bKGD", b"\7")), kinds.UNSAFE_CHUNKS,
         (b"bKGD",), "PNG chunks bKGD"),
    Case("WebP chunk", ".webp", webp((b"wxyz", MARK)), kinds.RIFF_CHUNKS, name="WebP chunks wxyz"),
    Case("WebP chunk with a preview", ".webp", webp((b"wxyz", MARK + files.THUMBNAIL)),
         kinds.UNKNOWN, name="WebP chunks wxyz"),
    Case("layers", ".tif", tiff({37724: (7, b"Adobe Photoshop Document Data Block\0" + MARK)}),
         kinds.LAYERS),
    Case("texts in private tags", ".tif", tiff({42112: (2, MARK + b"\0"), 42113: (3, 7)}),
         kinds.TIFF_TAGS, name="TIFF tags 42112 42113"),
    Case("bytes in private tags", ".tif", tiff({65000: (7, MARK), 65001: (4, 8)}),
         kinds.UNKNOWN, name="TIFF tags 65000 65001"),
    Case("texts in private tags, turned", ".tif", tiff({42112: (2, MARK + b"\0"), 274: (3, 3)}),
         kinds.UNKNOWN, name="TIFF tags 42112"),
    Case("five channels", ".tif", tiff(channels=5), kinds.CHANNELS, (), "2 extra channels"),
    Case("fourth channel", ".tif", tiff(channels=4), kinds.CHANNELS, (), "1 extra channel"),
]  # fmt: skip
