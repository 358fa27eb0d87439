"""Damage photos and projects at random: ``python tests/benchmarks/hostile.py [--inputs N]``.

Every damaged file must either be read or refused with one sentence, within seconds, and a photo
that is read must be written again or refused. A crash of a reader ends this program, and the input
that did it stays in ``--keep``. ``--only NAME,...`` takes some kinds, such as ``heic,dng``.
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

from kogao_core import photo, project
from kogao_core.project import Original, Project, Sheet, to_dict
from kogao_core.strict import BadFile

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import files
from scenes import oval_face

SLOW_SECONDS = 5.0
ENOUGH = 0.4  # chance that a change was the last: most inputs stay almost sound
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
    for suffix, make in files.MAKERS.items():
        found[f"{suffix[1:]} with all metadata"] = make(picture, 6)
    found["heic"], found["dng"] = files.heic(picture), files.dng()
    about = Original("a.jpg", "0" * 64, 56, 40)
    kept = Project(about, "automatic", Sheet((oval_face(),)))
    found["project"] = json.dumps(to_dict(kept)).encode()
    return found


def _saved(pixels: np.ndarray, form: str, **options: object) -> bytes:
    with io.BytesIO() as out:
        Image.fromarray(pixels).save(out, form, **options)
        return out.getvalue()


def damaged(rng: np.random.Generator, only: list[str]) -> Iterator[tuple[str, bytes]]:
    """Yield sound files with flipped bits, nasty numbers, cuts, repeats and foreign parts."""
    sound = seeds()
    names = only or list(sound)
    while True:
        name = names[rng.integers(len(names))]
        data = bytearray(sound[name])
        for _ in range(rng.geometric(ENOUGH)):
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


def judge(path: Path, name: str) -> str:
    """Return what reading a file came to: ``read``, ``refused``, or what went wrong."""
    start = time.perf_counter()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            if name == "project":
                project.load(path)
            else:
                _read_and_write(path)
        verdict = "read"
    except (photo.UnreadablePhoto, photo.CannotWrite, BadFile) as refusal:
        verdict = "refused" if "\n" not in str(refusal) else "refused in more than one line"
    except Exception as error:
        verdict = f"raised {type(error).__name__}: {error}"
    return verdict if time.perf_counter() - start < SLOW_SECONDS else f"slow, {verdict}"


def _read_and_write(path: Path) -> None:
    source = photo.read(path, max_megapixels=50)
    suffix = ".tif" if source.bits > 8 else ".png" if source.format != "JPEG" else ".jpg"
    out = path.with_name(f"out{suffix}")
    try:
        photo.write(source, source.pixels // 2, out, force=True)
    finally:
        out.unlink(missing_ok=True)


def main() -> None:
    """Run and print the counts; end with 1 if anything went wrong."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--inputs", type=int, default=20_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", type=lambda text: text.split(","), default=[])
    parser.add_argument("--keep", type=Path, help="folder for files that went wrong")
    options = parser.parse_args()
    counts: collections.Counter[str] = collections.Counter()
    inputs = damaged(np.random.default_rng(options.seed), options.only)
    keep = options.keep or Path(tempfile.mkdtemp(prefix="hostile-"))
    keep.mkdir(parents=True, exist_ok=True)
    for number in range(options.inputs):
        name, data = next(inputs)
        path = keep / ("now.dng" if name == "dng" else "now")
        path.write_bytes(data)
        verdict = judge(path, name)
        counts[verdict] += 1
        if verdict not in ("read", "refused"):
            (keep / f"{number} {name}").write_bytes(data)
        path.unlink(missing_ok=True)
    left = sorted(file.name for file in keep.iterdir() if file.name[0] in "o.")
    counts["left behind"] += len(left)
    print(json.dumps({"seed": options.seed, **counts}, indent=1))
    if sum(counts.values()) - counts["read"] - counts["refused"]:
        sys.exit(f"see {keep}")


if __name__ == "__main__":
    main()
