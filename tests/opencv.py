"""Mark tests that fail under OpenCV 5, which `pyproject.toml` excludes (docs/decisions/14)."""

import cv2
import pytest


def needs_opencv_4(reason):
    """Expect a failure under OpenCV 5; `.ci/opencv5` runs these tests, too."""
    return pytest.mark.xfail(int(cv2.__version__.split(".")[0]) > 4, reason=reason)


# OpenCV 4 rounds positions to 1/32 px; OpenCV 5 reads them exactly.
needs_rounded_positions = needs_opencv_4("a move below 1/64 px changes a pixel")
