"""Colours, spacing and the look of widgets; neutral greys, so that the photo's colours count."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

from PySide6.QtCore import Qt
from PySide6.QtGui import QColor, QFont, QPalette
from PySide6.QtWidgets import QApplication

Choice = Literal["system", "light", "dark"]
GRID_PX: Final = 4
# The palette of Okabe and Ito: told apart by everyone; shapes tell the same again.
OKABE_ITO: Final = {
    "orange": "#E69F00",
    "sky": "#56B4E9",
    "green": "#009E73",
    "yellow": "#F0E442",
    "blue": "#0072B2",
    "vermilion": "#D55E00",
    "purple": "#CC79A7",
}


@dataclass(frozen=True, slots=True)
class Theme:
    """Named greys and the one accent."""

    canvas: str
    window: str
    raised: str
    line: str
    text: str
    muted: str
    accent: str
    on_accent: str
    warning: str


def current(app: QApplication, choice: Choice = "system") -> Theme:
    """Return the chosen theme, or the one of the system's mode; dark where it has none."""
    system = app.styleHints().colorScheme() == Qt.ColorScheme.Light
    return LIGHT if choice == "light" or (choice == "system" and system) else DARK


def apply(app: QApplication, choice: Choice = "system") -> Theme:
    """Dress the application; called again when the system changes its mode."""
    theme = current(app, choice)
    sheet = _sheet(theme)
    # Each of these goes through every widget there is, four times for what is worn already.
    if app.styleSheet() != sheet:
        app.setStyle("Fusion")
        # There an icon takes the check mark's place and fades on the accent of the row.
        app.setAttribute(Qt.ApplicationAttribute.AA_DontShowIconsInMenus)
        # Figures of equal width: numbers don't dance while a slider moves.
        font = app.font()
        font.setFeature(QFont.Tag("tnum"), 1)
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
        role.Highlight: theme.accent,
        role.HighlightedText: theme.on_accent,
        role.Accent: theme.accent,
        role.Link: theme.accent,
        role.Mid: theme.line,
    }
    for which, colour in colours.items():
        palette.setColor(which, QColor(colour))
    for which in (role.WindowText, role.Text, role.ButtonText):
        palette.setColor(QPalette.ColorGroup.Disabled, which, QColor(theme.muted))
    return palette


def _sheet(theme: Theme) -> str:
    return f"""
    QMainWindow::separator {{ background: {theme.window}; width: 3px; height: 3px; }}
    QMainWindow::separator:vertical {{ border-left: 1px solid {theme.line}; }}
    QMainWindow::separator:horizontal {{ border-top: 1px solid {theme.line}; }}
    QMainWindow::separator:hover {{ background: {theme.accent}; }}
    QToolBar {{ border: none; border-bottom: 1px solid {theme.line}; padding: 4px; spacing: 4px; }}
    QToolBar::separator {{ background: {theme.line}; width: 1px; margin: 4px; }}
    QToolButton, QPushButton {{
        border: 1px solid transparent; border-radius: 4px; padding: 4px 12px;
    }}
    QPushButton, QToolButton[segment="true"] {{
        background: {theme.raised}; border-color: {theme.line};
    }}
    QToolBar > QToolButton {{ padding: 4px 8px; }}
    QToolButton#qt_toolbar_ext_button {{ padding: 0; border: none; }}
    QToolButton[part] {{
        background: {theme.raised}; border-color: {theme.line}; border-radius: 0;
    }}
    QToolButton[part="first"] {{
        border-top-left-radius: 4px; border-bottom-left-radius: 4px; border-right: none;
    }}
    QToolButton[part="last"] {{
        border-top-right-radius: 4px; border-bottom-right-radius: 4px; border-left: none;
    }}
    QToolButton[part]:checked {{ background: {theme.accent}; border-color: {theme.accent}; }}
    QToolButton[part]:checked:focus {{ border-color: {theme.on_accent}; }}
    QToolButton[snug="true"] {{ padding: 4px 2px; }}
    QFileDialog QToolButton {{ padding: 0; }}
    QDialogButtonBox {{ dialogbuttonbox-buttons-have-icons: 0; }}
    QToolButton:hover, QPushButton:hover {{ border-color: {theme.muted}; }}
    QToolButton:pressed, QPushButton:pressed {{ background: {theme.line}; }}
    QToolButton:checked {{
        background: {theme.accent}; color: {theme.on_accent}; border-color: {theme.accent};
    }}
    QToolButton:focus, QPushButton:focus {{ border-color: {theme.accent}; }}
    QToolButton:checked:focus {{ border-color: {theme.on_accent}; }}
    QToolButton:disabled {{ color: {theme.muted}; }}
    QToolButton:checked:disabled {{
        background: {theme.muted}; color: {theme.on_accent}; border-color: {theme.muted};
    }}
    QToolButton[fold="true"], QToolButton[fold="true"]:checked {{
        background: transparent; color: {theme.text}; border: none; padding: 4px 0;
        margin-left: -8px; font-weight: 600;
    }}
    QToolButton[fold="true"]:focus {{ color: {theme.accent}; text-decoration: underline; }}
    QLabel[heading="true"] {{ color: {theme.text}; font-weight: 600; }}
    QLabel[heading="true"]:disabled {{ color: {theme.muted}; }}
    QLabel[muted="true"] {{ color: {theme.muted}; }}
    QLabel[warn="true"] {{ color: {theme.warning}; }}
    QLabel[plate="true"] {{
        background: rgba(0, 0, 0, 170); color: white; border-radius: 3px; padding: 1px 4px;
    }}
    QLineEdit[value="true"] {{
        background: transparent; border: 1px solid transparent;
        border-bottom-color: {theme.muted};
    }}
    QLineEdit[value="true"]:hover {{ border-color: {theme.muted}; }}
    QLineEdit[value="true"]:focus {{
        background: {theme.raised}; border-color: {theme.accent};
    }}
    QCheckBox::indicator:unchecked, QRadioButton::indicator:unchecked {{
        width: 12px; height: 12px; background: {theme.raised}; border: 1px solid {theme.muted};
    }}
    QCheckBox::indicator:unchecked {{ border-radius: 2px; }}
    QRadioButton::indicator:unchecked {{ border-radius: 7px; }}
    QCheckBox, QRadioButton {{ border: 1px solid transparent; border-radius: 4px; padding: 1px; }}
    QCheckBox:focus, QRadioButton:focus {{ border-color: {theme.accent}; }}
    QSlider {{ min-height: 20px; border: 1px solid transparent; border-radius: 4px; }}
    QSlider:focus {{ border-color: {theme.accent}; }}
    QSlider::groove:horizontal {{
        height: 4px; border: 1px solid {theme.muted}; border-radius: 3px;
    }}
    QSlider::sub-page:horizontal {{ background: {theme.accent}; border-radius: 3px; }}
    QSlider[signed="true"]::sub-page:horizontal {{ background: transparent; }}
    QSlider::handle:horizontal {{
        background: {theme.text}; width: 12px; height: 12px; margin: -4px 0; border-radius: 6px;
    }}
    QSlider::handle:horizontal:focus {{ background: {theme.accent}; }}
    QSlider::sub-page:horizontal:disabled, QSlider::handle:horizontal:disabled {{
        background: {theme.muted};
    }}
    QFrame[bar] {{
        background: {theme.raised}; border: 1px solid {theme.line};
        border-top-right-radius: 4px; border-bottom-right-radius: 4px;
    }}
    QFrame[bar="wrong"] {{ border-left: 4px solid {theme.warning}; }}
    QFrame[bar="hint"] {{ border-left: 4px solid {theme.accent}; }}
    QScrollArea {{ border: none; background: {theme.window}; }}
    QListWidget, QUndoView {{
        background: {theme.window}; border: 1px solid transparent; border-radius: 4px;
    }}
    QListWidget[framed="true"] {{
        background: {theme.raised}; border: 1px solid {theme.line}; border-radius: 4px;
    }}
    QListWidget:focus, QListWidget[framed="true"]:focus, QUndoView:focus {{
        border-color: {theme.accent};
    }}
    QListWidget::item {{
        padding: 4px; border-left: 4px solid transparent;
        border-top-right-radius: 4px; border-bottom-right-radius: 4px;
    }}
    QListWidget::item:selected {{
        background: {theme.raised}; color: {theme.text}; border-left-color: {theme.accent};
    }}
    QTabBar {{ background: {theme.window}; qproperty-drawBase: 0; }}
    QTabBar::tab {{
        color: {theme.muted}; padding: 3px 11px 4px; border: 1px solid transparent;
        border-bottom-width: 2px;
    }}
    QTabBar::tab:selected {{ color: {theme.text}; border-bottom-color: {theme.accent}; }}
    QTabBar::tab:selected:focus {{ border-color: {theme.accent}; }}
    QTabBar::tab:hover {{ color: {theme.text}; }}
    QScrollBar {{ background: {theme.window}; }}
    QScrollBar:vertical {{ width: 10px; }}
    QScrollBar:horizontal {{ height: 10px; }}
    QScrollBar::handle {{ background: {theme.muted}; border-radius: 4px; margin: 1px; }}
    QScrollBar::handle:hover {{ background: {theme.text}; }}
    QScrollBar::handle:vertical {{ min-height: 24px; }}
    QScrollBar::handle:horizontal {{ min-width: 24px; }}
    QScrollBar::add-line, QScrollBar::sub-line {{ width: 0; height: 0; }}
    QScrollBar::add-page, QScrollBar::sub-page {{ background: transparent; }}
    QStatusBar {{ border-top: 1px solid {theme.line}; }}
    QStatusBar::item {{ border: none; }}
    """


DARK: Final = Theme(
    canvas="#2b2b2b",
    window="#383838",
    raised="#454545",
    line="#565656",
    text="#e6e6e6",
    muted="#b4b4b4",
    accent="#6cb4ea",
    on_accent="#101010",
    warning="#f0aa1e",
)
LIGHT: Final = Theme(
    canvas="#b8b8b8",
    window="#ececec",
    raised="#fafafa",
    line="#c2c2c2",
    text="#202020",
    muted="#5c5c5c",
    accent="#0067a8",
    on_accent="#ffffff",
    warning="#a34700",
)
