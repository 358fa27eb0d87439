"""Themes: colours, palette and style sheet. Greys are neutral, to keep the eye on the photo."""

from __future__ import annotations

import sys
from dataclasses import asdict, dataclass
from string import Template
from typing import Final, Literal

from PySide6.QtCore import Qt
from PySide6.QtGui import QColor, QFont, QPalette
from PySide6.QtWidgets import QApplication

from kogao_core.base import assets
from kogao_core.base.language import language

Choice = Literal["system", "light", "dark"]
GRID_PX: Final = 4
# Sizes of the type scale, relative to the font of the system.
LEAD: Final = 1.15
TITLE: Final = 1.6
# Okabe and Ito's palette is safe for colour-blind users; shapes carry the same information.
OKABE_ITO: Final = {
    "orange": "#E69F00",
    "sky": "#56B4E9",
    "green": "#009E73",
    "yellow": "#F0E442",
    "blue": "#0072B2",
    "vermilion": "#D55E00",
    "purple": "#CC79A7",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Theme:
    """Colours of a theme, also the names in `resources/look/kogao.qss`."""

    canvas: str
    window: str
    raised: str
    line: str
    text: str
    muted: str
    accent: str
    on_accent: str
    warning: str
    track: str  # of sliders, and other marks of controls: 3 : 1 on the window
    hover: str


def current(app: QApplication, choice: Choice = "system") -> Theme:
    """Return the chosen theme, or the system's; dark if the system has none."""
    system = app.styleHints().colorScheme() == Qt.ColorScheme.Light
    return LIGHT if choice == "light" or (choice == "system" and system) else DARK


def apply(app: QApplication, choice: Choice = "system") -> Theme:
    """Apply a theme to the application and return the theme."""
    theme = current(app, choice)
    text = assets.path("look/kogao.qss").read_text(encoding="utf-8")
    sheet = Template(text).substitute(asdict(theme))
    # Each call below updates every widget, so skip them if nothing changes.
    if app.styleSheet() != sheet:
        app.setStyle("Fusion")
        # Icons would replace the check marks and fade on the accent colour.
        app.setAttribute(Qt.ApplicationAttribute.AA_DontShowIconsInMenus)
        # Digits of equal width keep numbers still while a slider moves.
        font = app.font()
        font.setFeature(QFont.Tag("tnum"), 1)
        if sys.platform == "win32" and language() == "ja":
            # Other fonts may lend Chinese forms of the characters.
            font.setFamilies([*font.families(), "Yu Gothic UI", "Meiryo"])
        app.setFont(font)
        app.setPalette(_palette(theme))
        app.setStyleSheet(sheet)
    return theme


def _palette(theme: Theme) -> QPalette:
    palette, role = QPalette(), QPalette.ColorRole
    colours = {
        role.Window: theme.window,
        role.WindowText: theme.text,
        role.Base: theme.raised,
        role.AlternateBase: theme.window,
        role.Text: theme.text,
        role.Button: theme.raised,
        role.ButtonText: theme.text,
        role.ToolTipBase: theme.raised,
        role.ToolTipText: theme.text,
        role.PlaceholderText: theme.muted,
        role.BrightText: theme.warning,
        role.Highlight: theme.accent,
        role.HighlightedText: theme.on_accent,
        role.Accent: theme.accent,
        role.Link: theme.accent,
        role.Mid: theme.line,
        role.Dark: theme.track,
        role.Light: theme.hover,
    }
    for which, colour in colours.items():
        palette.setColor(which, QColor(colour))
    for which in (role.WindowText, role.Text, role.ButtonText):
        palette.setColor(QPalette.ColorGroup.Disabled, which, QColor(theme.muted))
    return palette


DARK: Final = Theme(
    canvas="#2b2b2b",
    window="#333333",
    raised="#404040",
    line="#4a4a4a",
    text="#e8e8e8",
    muted="#bababa",
    accent="#6cb4ea",
    on_accent="#101010",
    warning="#f0aa1e",
    track="#909090",
    hover="#4a4a4a",
)
LIGHT: Final = Theme(
    canvas="#b8b8b8",
    window="#efefef",
    raised="#ffffff",
    line="#cfcfcf",
    text="#1f1f1f",
    muted="#595959",
    accent="#0067a8",
    on_accent="#ffffff",
    warning="#9c4400",
    track="#858585",
    hover="#e2e2e2",
)
