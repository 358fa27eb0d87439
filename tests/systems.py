"""Mark tests that state what Linux, its programs, its fonts or its C library give."""

import sys

import pytest


def needs_linux(reason):
    """Skip a test on other systems."""
    return pytest.mark.skipif(sys.platform != "linux", reason=reason)


# pow, sin and exp differ in their last bits; points then move by hundredths of a pixel.
needs_stored_decimals = needs_linux("stored with the decimals of Linux's C library")
needs_linux_fonts = needs_linux("widths of the fonts of a Linux desktop")
# Windows says of a name that is too long that there is no such file.
TOO_LONG = "No such file or directory" if sys.platform == "win32" else "File name too long"
