"""Damage photos at random: ``python tests/benchmarks/hostile.py [--inputs N] [--seed S]``.

Every damaged photo goes through ``kogao-cli warp`` or ``detect`` and must come out whole or be
refused with one sentence and a documented exit code, within seconds and bounded memory; nothing may
be left behind, and no library may add to what is said. Not on Windows. ``--only heic,dng`` takes
some kinds; inputs that went wrong stay in ``--keep``.
"""

from __future__ import annotations

import functools
import io
import sys
from pathlib import Path

import cv2
import numpy as np
import tifffile
from PIL import Image

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import files
import metadata_cases
from damaging import bytewise, parts, trials
from scenes import oval_face

from kogao_core.projects.interchange import faces_text

STRUCTURED = 0.6  # share of changes that keep the file's parts in order
SEARCHED = 0.05  # share of photos in which faces are looked for, which is slow
POINTS = faces_text([oval_face(40, 40, size=0.5)]).encode()
SUFFIXES = (".jpg", ".png", ".tif", ".webp", ".avif")
MORE = (
    ["--motion", "keep"],
    ["--disclose"],
    ["--label", "Retouched"],
    ["--amount", "0"],
    ["--save-project"],
)


@functools.cache
def seeds() -> dict[str, bytes]:
    """Return small sound files of every format, depth and kind that is read."""
    rng = np.random.default_rng(3)
    picture = cv2.GaussianBlur(rng.integers(0, 256, (40, 56, 3), np.uint8), (0, 0), 1.5)
    exif = Image.Exif()
    exif[0x112], exif[0x13B] = 6, "someone"
    found = {
        "jpeg": files.saved(picture, "JPEG", exif=exif, icc_profile=b"p" * 500, dpi=(72, 72)),
        "progressive": files.saved(picture, "JPEG", progressive=True, subsampling="4:2:2"),
        "grey": files.saved(picture[..., 0], "JPEG"),
        "rgb": files.saved(picture, "JPEG", keep_rgb=True),
        "png": files.saved(picture, "PNG", exif=exif, icc_profile=b"p" * 500),
        "palette": files.saved(np.array(Image.fromarray(picture).quantize(16)), "PNG"),
        "webp": files.saved(picture, "WEBP", exif=exif),
        "lossless webp": files.saved(picture, "WEBP", lossless=True),
        "tiff": files.saved(picture, "TIFF", compression="tiff_lzw", exif=exif),
        "plain tiff": files.saved(picture, "TIFF"),
    }
    deep = picture.astype(np.uint16) * 257
    for name, pixels in (("16-bit", deep), ("float", picture.astype(np.float32) / 255.0)):
        found[f"{name} tiff"] = cv2.imencode(".tiff", pixels)[1].tobytes()
    found["16-bit png"] = cv2.imencode(".png", deep)[1].tobytes()
    for suffix, make in files.MAKERS.items():
        found[f"{suffix[1:]} with all metadata"] = make(picture, 6)
    rare = {"photometric": "rgb", "tile": (16, 16), "compression": "zlib"}
    with io.BytesIO() as out:
        tifffile.imwrite(out, deep, **rare)
        found["tiled tiff"] = out.getvalue()
    narrow = [cv2.IMWRITE_JPEG_SAMPLING_FACTOR, cv2.IMWRITE_JPEG_SAMPLING_FACTOR_411]
    found["4:1:1"] = cv2.imencode(".jpg", picture, narrow)[1].tobytes()
    found["hdr"], found["motion"] = metadata_cases.ultra_hdr(), metadata_cases.motion_photo()
    found["kept"] = metadata_cases.kept()
    found["kept webp"] = metadata_cases.webp((b"wxyz", b"?"), (b"abcd", b"odd"))
    found["kept tiff"] = metadata_cases.tiff({42112: (2, b"text\0"), 40000: (12, (0.5, -1.5))})
    found["heic"], found["dng"] = files.heic(picture), files.dng()
    found["grey dng"] = files.dng(colours=1)
    return found


def damaged(rng: np.random.Generator, only: list[str]) -> tuple[str, bytes]:
    """Return the kind of a sound file and what became of it."""
    sound = seeds()
    names = only or list(sound)
    name = names[rng.integers(len(names))]
    data = sound[name]
    for _ in range(rng.geometric(bytewise.ENOUGH)):
        way = parts if rng.random() < STRUCTURED else bytewise
        data = way.change(data, rng, sound[names[rng.integers(len(names))]])
    return name, data


def case(rng: np.random.Generator, only: list[str]) -> trials.Trial:
    """Return a damaged photo and what to do with it."""
    kind, data = damaged(rng, only)
    photo = "photo.dng" if kind.endswith("dng") else "photo"
    limits = ["--max-megapixels", "50", "--json"]
    if rng.random() < SEARCHED:
        return trials.Trial(kind, ["detect", photo, *limits], {photo: data}, codes=(0, 2, 3, 4))
    out = f"out{SUFFIXES[rng.integers(len(SUFFIXES))]}"
    more = MORE[rng.integers(len(MORE))] if rng.random() < 0.3 else []
    return trials.Trial(
        kind,
        ["warp", photo, "-o", out, "--points", "points.json", *limits, *more],
        {photo: data, "points.json": POINTS},
        (out, *([f"{photo}.kogao.json"] if "--save-project" in more else [])),
    )


if __name__ == "__main__":
    options = trials.options(__doc__, 20_000).parse_args()
    trials.finish(trials.run(lambda rng: case(rng, options.only), options), options)
