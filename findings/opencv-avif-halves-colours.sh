#!/bin/bash
# One would guess: quality 99 of an AVIF by OpenCV is nearly as good as quality 100.
# What happens: below 100, OpenCV halves the resolution of colours (4:2:0), and no option prevents
# it; at 100 the file is lossless, and of a portrait eight times as long as at 95.
# Why a portrait editor cares: red lips and coloured eyelids bleed by a pixel, at every quality that
# a user would choose. Pillow's AVIF offers 4:4:4, but 8 bits only: deep portraits need OpenCV.
# Versions: opencv-contrib-python-headless 4.14.0.94 (libavif 1.4.2), 4.12.0.88 alike. 2026-11-28.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install -q opencv-contrib-python-headless==4.14.0.94 numpy
"$folder/env/bin/python" - <<'PY'
import cv2, numpy as np
y, x = np.mgrid[0:240, 0:320]
lips = (abs(y - 120) < 20 * np.sin(x / 40)) | ((x // 2 + y // 2) % 2 == 0) & (y > 180)
picture = np.where(lips[..., None], (60, 40, 200), (150, 180, 225)).astype(np.uint8)  # BGR
worst = {}
for depth in (8, 10):
    stored = picture if depth == 8 else picture.astype(np.uint16) * 1023 // 255
    for quality in (90, 95, 99, 100):
        how = [cv2.IMWRITE_AVIF_DEPTH, depth, cv2.IMWRITE_AVIF_QUALITY, quality]
        data = cv2.imencode(".avif", stored, how)[1]
        back = cv2.imdecode(data, cv2.IMREAD_UNCHANGED)
        raw = data.tobytes()
        halved = raw[raw.index(b"av1C") + 6] & 0x0C == 0x0C  # chroma_subsampling_x and _y
        worst[depth, quality] = int(np.abs(back.astype(int) - stored).max()) * 255 // (2**depth - 1)
        print(f"OpenCV {cv2.__version__}, {depth} bits, quality {quality}: {len(raw)} bytes, "
              f"colours halved: {halved}, worst difference {worst[depth, quality]} of 255")
        assert halved == (quality < 100), "the behaviour has changed"
assert all(off > 30 for (_, quality), off in worst.items() if quality < 100)
assert worst[8, 100] == worst[10, 100] == 0
PY
