"""Photos changed in place and brought back: ``python tests/benchmarks/originals.py PHOTOS``.

Each photo of a folder and of those below it (JPEG, at most ``--longest`` px, saved at a quality and
a subsampling by chance) is changed by a recipe by chance, whole files are taken out of the store,
and every original must come back byte for byte from what was kept of it. Prints the share of the
bytes that this took, and the processor time beside that of writing.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

import numpy as np
from PIL import Image

import kogao_core as kogao
from kogao_core.base.originals import Originals
from kogao_core.photo import in_place

SUBSAMPLINGS = ("4:2:0", "4:2:0", "4:2:2", "4:4:4")


def recipe(rng: np.random.Generator) -> kogao.Recipe:
    """Return one of many ways to make a face smaller."""
    return kogao.Recipe(
        percent=float(rng.choice([1.0, 2.0, 3.0, 4.0, 4.0, 4.0, 5.0, 6.0])),
        head_follows=float(rng.choice([0.0, 50.0, 100.0])),
    )


def smaller(photo: Path, path: Path, longest_px: int, rng: np.random.Generator) -> None:
    """Write a photo as another program would."""
    with Image.open(photo) as image:
        image.thumbnail((longest_px, longest_px))
        image.convert("RGB").save(
            path, quality=int(rng.integers(75, 97)), subsampling=str(rng.choice(SUBSAMPLINGS))
        )


def main() -> None:
    """Measure, and end with 1 where an original didn't come back."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("photos", type=Path)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--longest", type=int, default=700)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    rng = np.random.default_rng(options.seed)
    photos = sorted(options.photos.rglob("*.jpg"))
    shares, lengths, times = [], [], []
    wrong = without = 0
    with tempfile.TemporaryDirectory() as folder:
        path, store = Path(folder, "photo.jpg"), Originals(Path(folder, "store"))
        while len(shares) < options.count:
            smaller(photos[rng.integers(len(photos))], path, options.longest, rng)
            whole, photo = path.read_bytes(), kogao.read(path)
            rendering = kogao.render(photo.pixels, kogao.find(photo.pixels), recipe(rng))
            if (rendering.pixels == photo.pixels).all():
                without += 1
                continue
            start = time.process_time()
            in_place.write_in_place(photo, rendering.pixels, None)
            between = time.process_time()
            path.write_bytes(whole)
            in_place.write_in_place(kogao.read(path), rendering.pixels, store)
            times.append((time.process_time() - between) / (between - start))
            for delta in store.folder.glob("*.delta"):  # none, where it would save too little
                delta.with_suffix("").unlink()
            (kept,) = store.kept(path)
            lengths.append((kept.stat().st_size, len(whole)))
            shares.append(lengths[-1][0] / lengths[-1][1])
            wrong += not store.restore(path) or path.read_bytes() != whole
            for one in store.folder.iterdir():
                one.unlink()
    low, middle, high = np.quantile(shares, [0.1, 0.5, 0.9])
    kept_bytes, whole_bytes = np.sum(lengths, axis=0)
    print(f"{len(shares)} changed and brought back, {wrong} wrong; {without} without a change")
    print(f"of a photo {np.mean(shares):.1%}, of all bytes {kept_bytes / whole_bytes:.1%}")
    print(f"10, 50 and 90 % of the photos: {low:.0%}, {middle:.0%}, {high:.0%}")
    print(f"reading, writing and keeping {np.median(times):.2f} times writing (processor)")
    raise SystemExit(wrong > 0)


if __name__ == "__main__":
    main()
