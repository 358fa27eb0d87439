"""Constants of the paper that a recipe needs; without numpy, so that a command starts quickly."""

from __future__ import annotations

from typing import Final, Literal

DomainName = Literal["image", "control-points", "threshold"]
# cv2.remap rounds coordinates to 1/32 px, so a move of less than half of that changes no byte.
LOSSLESS_PX: Final = 1.0 / 64.0
# Positions of the candidates from the eyes (0) to the mouth (1), figure 7a: "10:0" is the mouth.
FRACTIONS: Final = (1.0, 0.8, 0.6, 0.47)
