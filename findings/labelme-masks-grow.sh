#!/usr/bin/env bash
# Guess: a polygon drawn in labelme around 3 x 2 pixels becomes a mask of these 6 pixels.
# What happens: labelme's own mask has 12 pixels: a column and a row more, at the right and below. A
#   click in the middle of the first pixel is 0.5, 0.5, but the mask takes whole numbers as middles of
#   pixels and fills the edge, too. pycocotools fills 6 from the same numbers.
# Why it matters: a mask that shall protect hair or a neighbour is wider at one side and moved by half
#   a pixel; masks of one polygon by two programs differ. Landmarks have the half pixel alone.
# labelme 6.3.1, pycocotools 2.0.11; 28 November 2026.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/v"
"$work/v/bin/python" -m pip install -q labelme==6.3.1 pycocotools==2.0.11
QT_QPA_PLATFORM=offscreen "$work/v/bin/python" - <<'PYTHON'
import labelme
import labelme.utils
import numpy as np
from pycocotools import mask as coco

around = [[2, 1], [5, 1], [5, 3], [2, 3]]  # the edges of columns 2 to 4 and of rows 1 and 2
flat = [float(value) for corner in around for value in corner]
masks = {
    f"labelme {labelme.__version__}": labelme.utils.shape_to_mask((9, 9), around, "polygon"),
    "pycocotools": coco.decode(coco.frPyObjects([flat], 9, 9))[..., 0] > 0,
}
filled = {}
for name, mask in masks.items():
    columns, rows = (np.flatnonzero(mask.any(axis)).tolist() for axis in (0, 1))
    filled[name.split()[0]] = columns, rows
    print(f"{name}: {mask.sum()} pixels, columns {columns}, rows {rows}")
assert filled["pycocotools"] == ([2, 3, 4], [1, 2]), "the behaviour has changed"
assert filled["labelme"] == ([2, 3, 4, 5], [1, 2, 3]), "the behaviour has changed"
PYTHON
