"""Photo files as other programs write them, built without Kogao; `opened` reads them."""

import io
import struct
import zlib

import cv2
import numpy as np
from PIL import Image, ImageCms

from kogao_core import photo

SRGB = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
GREY = SRGB[:16] + b"GRAY" + SRGB[20:]
CAPTION = "Café 顔, mi casa"
MAKER_NOTE = b"MAKER\0\1\2" + bytes(range(256))
THUMBNAIL = b"\xff\xd8\xff a face as it was \xff\xd9"
# IIM: record 1 says that record 2 is in UTF-8, record 2 holds the caption.
IPTC = (
    b"\x1c\x01\x5a\x00\x03\x1b%G"
    + b"\x1c\x02\x78"
    + struct.pack(">H", len(CAPTION.encode()))
    + CAPTION.encode()
)
XMP = (
    '<x:xmpmeta xmlns:x="adobe:ns:meta/"><rdf:RDF xmlns:rdf="http://www.w3.org/1999/02/22-rdf-'
    'syntax-ns#"><rdf:Description rdf:about="" xmlns:dc="http://purl.org/dc/elements/1.1/" '
    'xmlns:tiff="http://ns.adobe.com/tiff/1.0/" tiff:Orientation="{}" dc:format="image/x">'
    "<dc:creator>Me &amp; 顔</dc:creator></rdf:Description></rdf:RDF></x:xmpmeta>"
)
_SIZES = {1: 1, 2: 1, 3: 2, 4: 4, 5: 8, 7: 1, 8: 2, 10: 8, 11: 4, 12: 8}


def directory(entries, at, order="<", follow=0):
    """Return a TIFF directory that starts at an offset, and what its entries point to.

    Entries are ``{tag: (kind, value)}``: numbers, pairs, bytes, or another such dict of entries.
    """
    head = struct.pack(order + "H", len(entries))
    spare_at = at + 2 + 12 * len(entries) + 4
    spare = b""
    for tag, (kind, value) in sorted(entries.items()):
        if isinstance(value, dict):
            data = struct.pack(order + "I", spare_at + len(spare))
            spare += directory(value, spare_at + len(spare), order)
        elif isinstance(value, bytes):
            data = value
        else:
            letter = {3: "H", 4: "I", 5: "I", 8: "h", 10: "i", 11: "f", 12: "d"}[kind]
            numbers = np.ravel(value).tolist()
            data = struct.pack(f"{order}{len(numbers)}{letter}", *numbers)
        count = 1 if isinstance(value, dict) else len(data) // _SIZES[kind]
        if len(data) > 4:
            field = struct.pack(order + "I", spare_at + len(spare))
            spare += data + b"\0" * (len(data) % 2)
        elif isinstance(value, dict):
            field = data
        else:
            field = data.ljust(4, b"\0")
        head += struct.pack(order + "HHI", tag, kind, count) + field
    return head + struct.pack(order + "I", follow) + spare


def camera_tags(orientation, width, height):
    """Return what a camera says: about itself, the moment, the place, and a maker's note."""
    return {
        0x010F: (2, b"Maker\0"),
        0x0110: (2, b"Model 7\0"),
        0x0112: (3, orientation),
        0x0131: (2, b"Firmware 1.2\0"),
        0x0132: (2, b"2026:01:02 03:04:05\0"),
        0x013B: (2, b"Me!\0"),
        0x8298: (2, b"(c) Me\0"),
        0x8769: (4, {
            0x829A: (5, (1, 125)),
            0x9000: (7, b"0232"),
            0x9003: (2, b"2026:01:02 03:04:05\0"),
            0x9204: (10, (-2, 3)),
            0x927C: (7, MAKER_NOTE),
            0x9286: (7, b"ASCII\0\0\0a comment"),
            0xA002: (4, width),
            0xA003: (4, height),
            0xA005: (4, {1: (2, b"R98\0")}),
        }),
        0x8825: (4, {
            1: (2, b"N\0"),
            2: (5, ((48, 1), (51, 1), (29, 10))),
            3: (2, b"E\0"),
            4: (5, ((2, 1), (17, 1), (40, 1))),
        }),
    }  # fmt: skip


def exif_block(orientation, width, height, order="<", thumbnail=THUMBNAIL):
    """Return an EXIF block with a thumbnail, as JPEG, PNG and WebP hold it."""
    head = {"<": b"II*\0", ">": b"MM\0*"}[order] + struct.pack(order + "I", 8)
    tags = camera_tags(orientation, width, height)
    length = len(directory(tags, 8, order))
    second = 8 + length + length % 2
    main = directory(tags, 8, order, second).ljust(length + length % 2, b"\0")
    place = second + 2 + 3 * 12 + 4
    small = {0x0103: (3, 6), 0x0201: (4, place), 0x0202: (4, len(thumbnail))}
    return b"Exif\0\0" + head + main + directory(small, second, order) + thumbnail


def resources():
    """Return Photoshop resources: a caption, a thumbnail, and something else."""

    def one(number, content, name=b"\0\0"):
        sized = struct.pack(">I", len(content)) + content + b"\0" * (len(content) % 2)
        return b"8BIM" + struct.pack(">H", number) + name + sized

    return one(0x040C, b"\0" * 28 + THUMBNAIL) + one(0x0404, IPTC) + one(1000, b"odd", b"\3abc")


def profile_for(pixels):
    return GREY if pixels.ndim == 2 else SRGB


def segment(code, body):
    return bytes([0xFF, code]) + struct.pack(">H", len(body) + 2) + body


def chunk(name, body):
    return struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body))


def empty_png(width, height):
    """Return a PNG file that claims a size and holds no pixels."""
    header = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
    return b"\x89PNG\r\n\x1a\n" + header + chunk(b"IDAT", zlib.compress(b"\0"))


def opened(path, data):
    """Write a file and read the photo in it."""
    path.write_bytes(data)
    return photo.read(path)


def saved(picture, form, **options):
    """Return the file that Pillow makes of a picture or of pixels."""
    picture = Image.fromarray(picture) if isinstance(picture, np.ndarray) else picture
    with io.BytesIO() as out:
        picture.save(out, form, **options)
        return out.getvalue()


def jpeg(pixels, orientation=1, order="<", **options):
    """Return a JPEG file with everything that a JPEG file may hold."""
    options = {"quality": 97, "subsampling": 0, "dpi": (240, 240)} | options
    told = blocks(pixels, orientation, order)
    data = saved(pixels, "JPEG", comment=b"a remark", **told, **options)
    more = segment(0xED, b"Photoshop 3.0\0" + resources())
    more += segment(0xE1, b"http://ns.adobe.com/xmp/extension/\0" + b"5" * 32 + b"the rest")
    more += segment(0xE7, b"something of the maker's")
    more += segment(0xE4, b"preview" + THUMBNAIL)
    return data[:2] + more + data[2:]


def png(pixels, orientation=1):
    """Return a PNG file of any depth with everything that a PNG file may hold."""
    height, width = pixels.shape[:2]
    colours = pixels if pixels.ndim == 2 else pixels[..., [2, 1, 0, 3][: pixels.shape[2]]]
    data = cv2.imencode(".png", colours)[1].tobytes()
    hexes = resources().hex()
    more = chunk(b"gAMA", struct.pack(">I", 45455))
    more += chunk(b"iCCP", b"srgb\0\0" + zlib.compress(profile_for(pixels)))
    more += chunk(b"pHYs", struct.pack(">IIB", 9449, 9449, 1))
    more += chunk(b"tEXt", b"Title\0A portrait")
    more += chunk(b"iTXt", b"XML:com.adobe.xmp\0\0\0\0\0" + XMP.format(orientation).encode())
    raw = f"\niptc\n{len(resources()):8}\n{hexes}\n".encode()
    more += chunk(b"zTXt", b"Raw profile type iptc\0\0" + zlib.compress(raw))
    more += chunk(b"eXIf", exif_block(orientation, width, height)[6:])
    return data[:33] + more + data[33:]


def tiff(pixels, orientation=1, order="<"):
    """Return a TIFF file, uncompressed, of any depth with everything that a TIFF file may hold."""
    height, width = pixels.shape[:2]
    samples = 1 if pixels.ndim == 2 else pixels.shape[2]
    stored = pixels.astype(pixels.dtype.newbyteorder(order)).tobytes()
    head = {"<": b"II*\0", ">": b"MM\0*"}[order]
    tags = camera_tags(orientation, width, height) | {
        256: (4, width), 257: (4, height), 258: (3, [8 * pixels.dtype.itemsize] * samples),
        259: (3, 1), 262: (3, 1 if samples == 1 else 2), 273: (4, 8), 277: (3, samples),
        278: (4, height), 279: (4, len(stored)), 282: (5, (240, 1)), 283: (5, (240, 1)),
        296: (3, 2), 284: (3, 1), 700: (1, XMP.format(orientation).encode()),
        33723: (7, IPTC), 34377: (1, resources()), 34675: (7, profile_for(pixels)),
    }  # fmt: skip
    if samples == 4:
        tags[338] = (3, 2)
    body = stored + b"\0" * (len(stored) % 2)
    start = 8 + len(body)
    return head + struct.pack(order + "I", start) + body + directory(tags, start, order)


def blocks(pixels, orientation, order="<"):
    """Return the metadata blocks that Pillow writes in JPEG, WebP and AVIF."""
    height, width = pixels.shape[:2]
    return {
        "icc_profile": profile_for(pixels),
        "exif": exif_block(orientation, width, height, order),
        "xmp": XMP.format(orientation).encode(),
    }


def webp(pixels, orientation=1, **options):
    """Return a WebP file with everything that a WebP file may hold."""
    options = {"lossless": True, "exact": True} | options
    return saved(pixels, "WEBP", **blocks(pixels, orientation), **options)


def avif(pixels, orientation=1):
    """Return an AVIF file with everything that an AVIF file may hold, nearly lossless.

    16-bit pixels are stored with 10 bits.
    """
    if pixels.dtype == np.uint16:
        told = blocks(pixels, orientation)
        told = [told["exif"][6:], told["xmp"], told["icc_profile"]]
        kinds = [cv2.IMAGE_METADATA_EXIF, cv2.IMAGE_METADATA_XMP, cv2.IMAGE_METADATA_ICCP]
        how = [cv2.IMWRITE_AVIF_DEPTH, 10, cv2.IMWRITE_AVIF_QUALITY, 100]
        stored = pixels[..., [2, 1, 0, 3][: pixels.shape[2]]] >> 6
        arrays = [np.frombuffer(one, np.uint8) for one in told]
        return cv2.imencodeWithMetadata(".avif", stored, kinds, arrays, how)[1].tobytes()
    options = {"quality": 100, "subsampling": "4:4:4", "speed": 8}
    return saved(pixels, "AVIF", **blocks(pixels, orientation), **options)


def heic(pixels, **options):
    """Return a HEIC file; 16-bit pixels are stored with 10 bits."""
    import pillow_heif

    channels = 1 if pixels.ndim == 2 else pixels.shape[2]
    mode = {1: "L", 3: "RGB", 4: "RGBA"}[channels] + ";16" * (pixels.dtype == np.uint16)
    image = pillow_heif.from_bytes(mode, (pixels.shape[1], pixels.shape[0]), pixels.tobytes())
    with io.BytesIO() as out:
        image.save(out, quality=95, **options)
        return out.getvalue()


def dng(orientation=1, width=64, height=48, *, colours=3):
    """Return a raw photo whose red, green and blue, or grey, grow to the right, uncompressed."""
    mosaic = np.broadcast_to(2000 + 400 * np.arange(width), (height, width)).astype("<u2")
    one, none = (1, 1), (0, 1)
    tags = camera_tags(orientation, width, height) | {
        254: (4, 0), 256: (4, width), 257: (4, height), 258: (3, 16), 259: (3, 1),
        262: (3, 32803), 273: (4, 8), 277: (3, 1), 278: (4, height), 279: (4, 2 * mosaic.size),
        284: (3, 1), 700: (1, XMP.format(orientation).encode()), 33421: (3, (2, 2)),
        33422: (1, bytes([0, 1, 1, 2])), 50706: (1, bytes([1, 4, 0, 0])),
        50707: (1, bytes([1, 1, 0, 0])), 50708: (2, b"Maker Model 7\0"), 50717: (3, 65535),
        50721: (10, [one if k % 4 == 0 else none for k in range(9)]), 50728: (5, [one] * 3),
        50778: (3, 21),
    }  # fmt: skip
    if colours == 1:  # linear, without a mosaic
        tags = {k: one for k, one in tags.items() if k not in (33421, 33422)}
        tags |= {262: (3, 34892), 50721: (10, [one]), 50728: (5, [one])}
    start = 8 + 2 * mosaic.size
    return b"II*\0" + struct.pack("<I", start) + mosaic.tobytes() + directory(tags, start)


MAKERS = {".jpg": jpeg, ".png": png, ".tif": tiff, ".webp": webp, ".avif": avif}
