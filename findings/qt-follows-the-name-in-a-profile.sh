#!/bin/bash
# One would guess: an ICC profile is shown by its curve and matrix; littleCMS, Qt and Pillow agree.
# What happens: if the profile has the tag "cicp" (ICC.1:2022), Qt shows the picture by the numbers
# of the tag and ignores the curve. littleCMS (Pillow, GIMP, libvips) ignores the tag. The same
# 8-bit value becomes white in one and middle grey in the other.
# Why a portrait editor cares: a profile whose curve is tone-mapped for SDR screens, with a PQ name
# for HDR screens, is right in littleCMS. Thumbnails painted by Qt differ from the picture.
# Versions: PySide6-Essentials 6.11.3, Pillow 13.0.0 (littleCMS 2.19). 2026-11-28.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install -q PySide6-Essentials==6.11.3 pillow==13.0.0
QT_QPA_PLATFORM=offscreen "$folder/env/bin/python" - <<'PY'
import io, struct
from PIL import Image, ImageCms, features
from PySide6.QtCore import qVersion
from PySide6.QtGui import QColor, QColorSpace, QImage

plain = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
count = int.from_bytes(plain[128:132], "big")
tags = [struct.unpack_from(">4sII", plain, 132 + 12 * k) for k in range(count)]
table = b"".join(struct.pack(">4sII", name, at + 12, size) for name, at, size in tags)
body = plain[132 + 12 * count :]
place = 132 + 12 * (count + 1) + len(body)
named = plain[4:128] + struct.pack(">I", count + 1) + table
named += struct.pack(">4sII", b"cicp", place, 12) + body + b"cicp\0\0\0\0" + bytes([9, 16, 0, 1])
named = struct.pack(">I", len(named) + 4) + named

value = 148  # PQ: 203 cd/m2, the white of SDR; sRGB: middle grey
seen = {}
for name, icc in (("sRGB", plain), ("sRGB with a PQ name", named)):
    profile = ImageCms.ImageCmsProfile(io.BytesIO(icc))
    picture = Image.new("RGB", (1, 1), (value,) * 3)
    target = ImageCms.createProfile("sRGB")
    by_lcms = ImageCms.profileToProfile(picture, profile, target, 1).getpixel((0, 0))[0]
    image = QImage(1, 1, QImage.Format.Format_RGB32)
    image.fill(QColor(value, value, value))
    space = QColorSpace.fromIccProfile(icc)
    image.setColorSpace(space)
    image.convertToColorSpace(QColorSpace(QColorSpace.NamedColorSpace.SRgb))
    seen[name] = by_lcms, image.pixelColor(0, 0).red(), space.transferFunction().name
    print(f"{name}: littleCMS {features.version('littlecms2')} {by_lcms}, Qt {qVersion()} "
          f"{seen[name][1]} ({seen[name][2]})")
assert abs(seen["sRGB"][0] - value) <= 1 and abs(seen["sRGB"][1] - value) <= 1
lcms, qt, curve = seen["sRGB with a PQ name"]
assert abs(lcms - value) <= 1 and curve == "St2084" and abs(qt - value) > 20, "it has changed"
PY
