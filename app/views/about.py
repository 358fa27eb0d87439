"""What this program is, whose paper it implements, and the licences of what it is built on."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QMessageBox, QWidget

from kogao_core import __version__

from ..i18n import tr


def about_box(parent: QWidget) -> QMessageBox:
    """Return the box; `open` shows it without stopping the program."""
    box = QMessageBox(parent)
    box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    box.setWindowTitle(tr("About Kogao"))
    box.setTextFormat(Qt.TextFormat.PlainText)
    box.setText(tr("Kogao {version}, an exact small-face editor", version=__version__))
    box.setInformativeText("\n\n".join((_paper(), _licences())))
    box.setStandardButtons(QMessageBox.StandardButton.Close)
    return box


def _paper() -> str:
    return tr(
        "After M. Seo, Y.-W. Chen and H. Aoki, “Automatic Transformation of “KOGAO” (Small Face) "
        "based on Fast B-spline Approximation”, 2011."
    )


def _licences() -> str:
    return tr(
        "Kogao: Apache-2.0. Face networks of MediaPipe: Apache-2.0. Qt and PySide6: LGPL-3.0. "
        "OpenCV: Apache-2.0. NumPy: BSD-3-Clause. Pillow: MIT-CMU. PyQtGraph: MIT."
    )
