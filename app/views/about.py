"""What this program is, whose paper it implements, and the licences of what it is built on."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QMessageBox, QWidget

from kogao_core import __version__
from kogao_core.cli import licences

from ..i18n import tr


def about_box(parent: QWidget) -> QMessageBox:
    """Return the box; `open` shows it without stopping the program."""
    box = QMessageBox(parent)
    box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    box.setWindowTitle(tr("About Kogao"))
    box.setTextFormat(Qt.TextFormat.PlainText)
    box.setText(tr("Kogao {version}, an exact small-face editor", version=__version__))
    box.setInformativeText("\n\n".join((_paper(), _licences())))
    box.setDetailedText(licences.text())
    box.setStandardButtons(QMessageBox.StandardButton.Close)
    return box


def _paper() -> str:
    return tr(
        "After M. Seo, Y.-W. Chen and H. Aoki, “Automatic Transformation of “KOGAO” (Small Face) "
        "based on Fast B-spline Approximation”, 2011."
    )


def _licences() -> str:
    return tr(
        "Licensed under Apache-2.0. The details name everything it is built on and its licence."
    )
