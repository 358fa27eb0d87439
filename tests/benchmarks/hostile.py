"""Damage photos at random and read them: ``python tests/benchmarks/hostile.py [--inputs N]``.

Every damaged file must either be read or refused with one sentence (`UnreadablePhoto`), within
seconds. A crash of the reader ends this program, and the input that did it stays in ``--keep``.
"""

from __future__ import annotations

import argparse
import collections
import io
import json
import sys
import tempfile
import time
import warnings
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
from PIL import Image

from kogao_core import photo

SLOW_SECONDS = 5.0
MOST_CHANGES = 12
# Values that sizes, counts and offsets are commonly mistaken with.
NASTY = (0, 1, 0x7F, 0x80, 0xFF, 0x7FFF, 0xFFFF, 0x7FFFFFFF, 0xFFFFFFFF)


def seeds() -> dict[str, bytes]:
    """Return small sound files of every format, depth and kind that is read."""
    rng = np.random.default_rng(3)
    picture = cv2.GaussianBlur(rng.integers(0, 256, (40, 56, 3), np.uint8), (0, 0), 1.5)
    exif = Image.Exif()
    exif[0x112], exif[0x13B] = 6, "someone"
    found = {
        "jpeg": _saved(picture, "JPEG", exif=exif, icc_profile=b"p" * 500, dpi=(72, 72)),
        "progressive": _saved(picture, "JPEG", progressive=True, subsampling="4:2:2"),
        "grey": _saved(picture[..., 0], "JPEG"),
        "png": _saved(picture, "PNG", exif=exif, icc_profile=b"p" * 500),
        "palette": _saved(np.array(Image.fromarray(picture).quantize(16)), "PNG"),
        "webp": _saved(picture, "WEBP", exif=exif),
        "lossless webp": _saved(picture, "WEBP", lossless=True),
        "tiff": _saved(picture, "TIFF", compression="tiff_lzw", exif=exif),
        "plain tiff": _saved(picture, "TIFF"),
    }
    deep = picture.astype(np.uint16) * 257
    for name, pixels in (("16-bit", deep), ("float", picture.astype(np.float32) / 255.0)):
        found[f"{name} tiff"] = cv2.imencode(".tiff", pixels)[1].tobytes()
    found["16-bit png"] = cv2.imencode(".png", deep)[1].tobytes()
    return found


def _saved(pixels: np.ndarray, form: str, **options: object) -> bytes:
    with io.BytesIO() as out:
        Image.fromarray(pixels).save(out, form, **options)
        return out.getvalue()


def damaged(rng: np.random.Generator) -> Iterator[tuple[str, bytes]]:
    """Yield sound files with flipped bits, nasty numbers, cuts, repeats and foreign parts."""
    sound = seeds()
    names = list(sound)
    while True:
        name = names[rng.integers(len(names))]
        data = bytearray(sound[name])
        for _ in range(rng.integers(1, MOST_CHANGES)):
            _damage(data, rng, sound[names[rng.integers(len(names))]])
        yield name, bytes(data)


def _damage(data: bytearray, rng: np.random.Generator, other: bytes) -> None:
    # Headers decide most: half of all changes go to the first 200 bytes.
    reach = len(data) if rng.random() < 0.5 else min(len(data), 200)
    at = int(rng.integers(max(1, reach)))
    kind = rng.integers(6)
    if kind == 0 and data:
        data[at : at + 1] = bytes([data[at] ^ (1 << int(rng.integers(8)))])
    elif kind == 1:
        width = int(rng.choice([1, 2, 4]))
        value = NASTY[rng.integers(len(NASTY))] % (1 << 8 * width)
        data[at : at + width] = value.to_bytes(width, "big" if rng.random() < 0.5 else "little")
    elif kind == 2:
        del data[at:]
    elif kind == 3:
        data[at:at] = data[at : at + int(rng.integers(1, 64))]
    elif kind == 4:
        del data[at : at + int(rng.integers(1, 64))]
    else:
        start = int(rng.integers(max(1, len(other))))
        data[at : at + 32] = other[start : start + 32]


def judge(path: Path) -> str:
    """Return what reading a file came to: ``read``, ``refused``, or what went wrong."""
    start = time.perf_counter()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            photo.read(path, max_megapixels=50)
        verdict = "read"
    except photo.UnreadablePhoto as refusal:
        verdict = "refused" if "\n" not in str(refusal) else "refused in more than one line"
    except Exception as error:
        verdict = f"raised {type(error).__name__}: {error}"
    return verdict if time.perf_counter() - start < SLOW_SECONDS else f"slow, {verdict}"


def main() -> None:
    """Run and print the counts; end with 1 if anything went wrong."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--inputs", type=int, default=20_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--keep", type=Path, help="folder for files that went wrong")
    options = parser.parse_args()
    counts: collections.Counter[str] = collections.Counter()
    inputs = damaged(np.random.default_rng(options.seed))
    keep = options.keep or Path(tempfile.mkdtemp(prefix="hostile-"))
    keep.mkdir(parents=True, exist_ok=True)
    path = keep / "now"
    for number in range(options.inputs):
        name, data = next(inputs)
        path.write_bytes(data)
        verdict = judge(path)
        counts[verdict] += 1
        if verdict not in ("read", "refused"):
            (keep / f"{number} {name}").write_bytes(data)
    path.unlink(missing_ok=True)
    print(json.dumps({"seed": options.seed, **counts}, indent=1))
    bad = set(counts) - {"read", "refused"}
    if bad:
        sys.exit(f"see {keep}")


if __name__ == "__main__":
    main()
