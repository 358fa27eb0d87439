"""The fields of the recipe: their scales, their choices, and what they do."""

from __future__ import annotations

import math
from typing import Final

from ..document import DEFAULT
from ..i18n import tr
from .controls import Scale

_PER_OCTAVE: Final = 50
_THRESHOLD_STEPS_PER_PX: Final = 64


def percent() -> Scale:
    """Return the slider of the warp distance."""
    return Scale(
        0, 150, 10, lambda n: n / 10, lambda v: round(v * 10), lambda v: tr("{v:.1f} % of D", v=v)
    )


def lattice() -> Scale:
    """Return the slider of the lattice."""
    # Twice as coarse is as far to the right as twice as fine is to the left.
    return Scale(
        -2 * _PER_OCTAVE,
        2 * _PER_OCTAVE,
        10,
        lambda n: 2.0 ** (n / _PER_OCTAVE),
        lambda v: round(math.log2(v) * _PER_OCTAVE),
        lambda v: tr("R {v:.2f}", v=v),
    )


def threshold() -> Scale:
    """Return the slider of the threshold."""
    per_px = _THRESHOLD_STEPS_PER_PX
    return Scale(
        0, 2 * per_px, 8, lambda n: n / per_px, lambda v: round(v * per_px), _threshold_text
    )


def _threshold_text(value: float) -> str:
    lossless = value <= DEFAULT.threshold_px
    return tr("{v:.2f} px, lossless", v=value) if lossless else tr("{v:.2f} px", v=value)


def tip(field: str) -> str:
    """Return what a field of the recipe does, and where the paper has it."""
    return {
        "percent": tr(
            "How far landmarks move, in % of D, their distance to the centre (section 3.2)"
        ),
        "lattice": tr(
            "Spacing of the control lattice: small is local, large is smooth (section 3.3)"
        ),
        "threshold_px": tr("Pixels that would move less stay as they are (section 4.2)"),
        "fit": tr(
            "How the lattice takes up the landmarks' moves: on every target, or near them as in "
            "equations 3 and 4 (sections 2.1, 2.2)"
        ),
        "domain": tr(
            "Which pixels are worked on; all three give the same picture, the smaller is quicker "
            "(sections 4.1, 4.2)"
        ),
        "interpolation": tr(
            "How a pixel is read between pixels: Lanczos keeps most detail, bilinear is quickest"
        ),
    }[field]


def options(field: str) -> list[tuple[str, str]]:
    """Return the choices of a field: what they are called, and their values."""
    return {"fit": _fits, "domain": _domains, "interpolation": _kernels}[field]()


def _fits() -> list[tuple[str, str]]:
    return [
        (tr("Exact: on every target"), "exact"),
        (tr("Approximation: the paper's"), "approximation"),
        (tr("Multilevel: refined steps"), "multilevel"),
    ]


def _domains() -> list[tuple[str, str]]:
    return [
        (tr("Whole image"), "image"),
        (tr("Control points"), "control-points"),
        (tr("Threshold"), "threshold"),
    ]


def _kernels() -> list[tuple[str, str]]:
    return [
        (tr("Bilinear"), "bilinear"),
        (tr("Cubic"), "cubic"),
        (tr("Lanczos 4"), "lanczos4"),
    ]
