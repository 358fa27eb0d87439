"""Toolbar icons: SVG files in `resources/look/icons`, drawn in the text colour of the theme."""

from __future__ import annotations

from functools import cache
from typing import Final

from PySide6.QtGui import QIcon, QImage, QPainter, QPixmap
from PySide6.QtSvg import QSvgRenderer

from kogao_core.base import assets

from ..theme import Theme

# Width and height in px; the width includes space for the text beside the icon.
SIZE: Final = (24, 20)
_RATIOS: Final = (1, 2, 3)  # device pixels per px


def icon(name: str, theme: Theme) -> QIcon:
    """Return an icon with pictures for the normal, disabled and checked state."""
    made, modes, states = QIcon(), QIcon.Mode, QIcon.State
    for mode, state, colour in (
        (modes.Normal, states.Off, theme.text),
        (modes.Disabled, states.Off, theme.muted),
        (modes.Normal, states.On, theme.accent),
    ):
        for ratio in _RATIOS:
            made.addPixmap(QPixmap.fromImage(_drawn(name, colour, ratio)), mode, state)
    return made


@cache
def _drawn(name: str, colour: str, ratio: int) -> QImage:
    svg = assets.path(f"look/icons/{name}.svg").read_text(encoding="utf-8")
    width, height = (side * ratio for side in SIZE)
    picture = QImage(width, height, QImage.Format.Format_ARGB32_Premultiplied)
    picture.fill(0)
    with QPainter(picture) as painter:
        QSvgRenderer(svg.replace("currentColor", colour).encode()).render(painter)
    picture.setDevicePixelRatio(ratio)
    return picture
