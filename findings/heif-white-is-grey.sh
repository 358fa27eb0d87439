#!/usr/bin/env bash
# Guess: pillow-heif gives a 10-bit HEIC in 16 bits, so its white is 65535.
# What happens: the ten bits are moved up by six and the rest stays empty: white is 65472. With the
#   default, 8 bits, white is 255. Saving cuts the six bits off instead of rounding.
# Why it matters: a phone's 10-bit portrait that passes through two programs is no longer white where
#   it was: masks, blends and "clipped" marks that ask for 65535 miss every burnt highlight, and an
#   8-bit picture that goes through 16 bits comes back a level darker. Kogao fills the bits.
# pillow-heif 1.8.1 (libheif 1.23.6); 28 November 2026.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/v"
"$work/v/bin/python" -m pip install -q pillow-heif==1.8.1 numpy==2.4.6
"$work/v/bin/python" - <<'PYTHON'
import io
import numpy as np
import pillow_heif

def through(picture):
    """Return a 16-bit picture saved as lossless 10-bit HEIC, as it is read in 16 and 8 bits."""
    height, width, _ = picture.shape
    new = pillow_heif.from_bytes(mode="RGB;16", size=(width, height), data=picture.tobytes())
    file = io.BytesIO()
    new.save(file, quality=-1, chroma=444, matrix_coefficients=0)
    deep = pillow_heif.open_heif(file, convert_hdr_to_8bit=False)
    return np.asarray(deep), np.asarray(pillow_heif.open_heif(file)), deep.info["bit_depth"]

levels = np.arange(1024)
ramp = np.round(levels * 65535 / 1023).astype(np.uint16)
deep, shallow, bits = through(np.tile(ramp[None, :, None], (64, 1, 3)))
print(f"pillow-heif {pillow_heif.__version__}, {bits} bits: white is {deep.max()} of 65535 in 16 bits,"
      f" {shallow.max()} of 255 in 8")
assert bits == 10 and deep.max() == 65472 and shallow.max() == 255, "the behaviour has changed"
assert (deep[0, :, 0] == levels << 6).all()
cut = through(np.full((64, 64, 3), 63, np.uint16))[0].max()
print(f"63, which is nearest to level 1, is saved as level {cut >> 6}")
assert cut == 0, "the behaviour has changed"
eight = np.tile((np.arange(256) * 257).astype(np.uint16)[None, :, None], (64, 1, 3))
back = through(eight)[0][0, :, 0] / 65535 * 255
lower = int((np.floor(back) < np.arange(256)).sum())
print(f"256 levels of 8 bits through it: white comes back as {back[-1]:.2f}, {lower} levels lie lower")
assert back[-1] < 255 and lower > 100, "the behaviour has changed"
PYTHON
