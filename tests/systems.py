"""Mark tests that state what Linux, its programs, its fonts or its C library give."""

import sys
from importlib import metadata

import numpy as np
import pytest


def needs_linux(reason):
    """Skip a test on other systems."""
    return pytest.mark.skipif(sys.platform != "linux", reason=reason)


# pow, sin and exp differ in their last bits; points then move by hundredths of a pixel.
# numpy 2.1 differs, too.
needs_stored_decimals = pytest.mark.skipif(
    sys.platform != "linux" or np.lib.NumpyVersion(np.__version__) < "2.2.0",
    reason="stored with the decimals of Linux's C library and of newer versions of numpy",
)
needs_own_names = pytest.mark.skipif(
    metadata.version("PySide6-Essentials").startswith("6.8."),
    reason="PySide6 6.8 keeps Qt's own roles and names of what a screen reader is told",
)
# Where a point and a shape's handle lie apart on screen depends on the panels' width.
needs_linux_fonts = needs_linux("the canvas has its size by the fonts of a Linux desktop")
# Windows says in its own language of a name that is too long that there is no such file.
TOO_LONG = ".+" if sys.platform == "win32" else "File name too long"
