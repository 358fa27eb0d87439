#!/usr/bin/env bash
# Guess: OpenCV reads a TIFF with straight alpha as it is stored, whatever its depth.
# What happens: with 8 bits a channel, OpenCV multiplies the colours by alpha, without a word and also
#   where alpha is dropped (IMREAD_COLOR). With 16 bits it doesn't. Pillow and tifffile never do.
# Why it matters: GIMP exports a cut-out head with straight alpha. Read by OpenCV, hair at soft edges
#   is dark, and put on a background it is darkened a second time; a 16-bit export of one picture is
#   right. Kogao reads TIFFs by Pillow.
# opencv-python-headless 4.14.0.94 and 5.0.0.93, Pillow 13.0.0, tifffile 2026.3.3; 28 November 2026.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
cat >probe.py <<'PYTHON'
import cv2, numpy as np, tifffile
from PIL import Image
hair = np.array([200, 120, 80, 64])  # a quarter of a hair over nothing
read = {}
for depth, unit in ((np.uint8, 1), (np.uint16, 257)):
    stored = np.tile(hair * unit, (8, 8, 1)).astype(depth)
    tifffile.imwrite("hair.tif", stored, photometric="rgb", extrasamples=["unassalpha"])
    whole = cv2.imread("hair.tif", cv2.IMREAD_UNCHANGED)[3, 3, [2, 1, 0, 3]] // unit
    colour = cv2.imread("hair.tif", cv2.IMREAD_COLOR)[3, 3, ::-1]
    pillow = Image.open("hair.tif").convert("RGBA").getpixel((3, 3))
    bits = 8 * stored.itemsize
    read[bits] = whole.tolist()
    print(f"OpenCV {cv2.__version__}, {bits} bits: {whole.tolist()}, without alpha {colour.tolist()};"
          f" Pillow {list(pillow)}; tifffile {(tifffile.imread('hair.tif')[3, 3] // unit).tolist()}")
    assert colour.tolist() == [50, 30, 20] and list(pillow) == hair.tolist()
assert read == {8: [50, 30, 20, 64], 16: hair.tolist()}, "the behaviour has changed"
PYTHON
for version in 4.14.0.94 5.0.0.93; do
  python3 -m venv "v$version"
  "v$version/bin/python" -m pip install -q "opencv-python-headless==$version" Pillow==13.0.0 tifffile==2026.3.3
  "v$version/bin/python" probe.py
done
