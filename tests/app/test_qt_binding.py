"""The binding under the editor; see docs/decisions/14."""

import gc
import sys

from PySide6.QtCore import QObject


def test_calls_that_return_nothing_keep_none_alive():
    """PySide6 6.12.0 on Python 3.11 lost a reference to None with each: soon the program aborts."""
    thing = QObject()
    gc.collect()  # what it might let go of meanwhile holds None, too
    before = sys.getrefcount(None)
    for _ in range(500):
        thing.setObjectName("name")
    assert abs(sys.getrefcount(None) - before) < 100
