"""The fields of the recipe: their scales, their choices, and what they do."""

from __future__ import annotations

import math
from typing import Final

from kogao_core.settings import SETTINGS, Alternative, cited

from ..document import DEFAULT
from ..i18n import tr
from .controls import Scale

_STEPS: Final = 100
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


def scale(field: str) -> Scale:
    """Return the slider of a number of the recipe: over all its range, unless it has its own."""
    if field in _SCALES:
        return _SCALES[field]()
    setting = SETTINGS[field]
    low, high = setting.within or (0.0, 1.0)
    step = 1.0 if setting.is_whole else (high - low) / _STEPS
    return Scale(
        0,
        round((high - low) / step),
        10,
        lambda n: low + n * step,
        lambda v: round((v - low) / step),
        lambda v: tr("{v:.4g} {unit}", v=v, unit=setting.unit).rstrip(),
    )


def label(field: str) -> str:
    """Return what a field is called, with its mnemonic."""
    title = tr(SETTINGS[field].title)
    return title.replace(letter, f"&{letter}", 1) if (letter := _LETTERS.get(field)) else title


def tip(field: str) -> str:
    """Return what a field of the recipe does, and where the paper has it."""
    setting = SETTINGS[field]
    return cited(tr(setting.help), tr(setting.where))


def options(field: str) -> list[tuple[str, str, str]]:
    """Return the choices of a field: what they are called, where they are from, their values."""
    return [
        (tr("{title}: {help}", title=tr(one.title), help=tr(one.help)), help_of(one), one.name)
        for one in SETTINGS[field].alternatives
    ]


def help_of(one: Alternative[str]) -> str:
    """Return what one of the choices is, and where the paper has it."""
    return cited(tr(one.help), tr(one.where))


_SCALES: Final = {"percent": percent, "lattice": lattice, "threshold_px": threshold}
# The keys that lead to a field's control, together with Alt.
_LETTERS: Final = {
    "percent": "W",
    "center": "C",
    "lattice": "L",
    "lattice_unit": "u",
    "fit": "i",
    "domain": "m",
    "threshold_px": "r",
    "interpolation": "n",
    "guard": "G",
}
