"""The colour profile of a screen, where the system tells it: Qt doesn't, on any."""

from __future__ import annotations

import ctypes
from typing import Final

from PIL import ImageCms
from PySide6.QtGui import QGuiApplication, QScreen

_MOST_BYTES: Final = 1 << 24
_ANY: Final = 0  # type of a property


def profile_of(screen: QScreen, window: int) -> bytes | None:
    """Return the ICC profile of a screen that shows a window, known by its number.

    None where the system tells none: under Wayland, where the desktop converts what it is given, on
    macOS, where nobody has tried, and where no profile was installed.
    """
    platform = QGuiApplication.platformName()
    if platform == "xcb":
        return _on_x(QGuiApplication.screens().index(screen))
    if platform == "windows":  # Pillow asks GetICMProfile; never tried
        profile = ImageCms.get_display_profile(window)
        return None if profile is None else profile.tobytes()
    return None


class _Reply(ctypes.Structure):
    # Of the property, behind the head that all replies have; the atom of its name lies alike.
    _fields_ = (
        *(("kind", ctypes.c_uint8), ("format", ctypes.c_uint8), ("sequence", ctypes.c_uint16)),
        *(("length", ctypes.c_uint32), ("atom", ctypes.c_uint32)),
    )


class _Screens(ctypes.Structure):
    _fields_ = (
        *(("root", ctypes.POINTER(ctypes.c_uint32)),),
        *(("left", ctypes.c_int), ("index", ctypes.c_int)),
    )


def _on_x(number: int) -> bytes | None:
    """Return what colord or whoever cares for colours has put on X's root window."""
    x, libc = ctypes.CDLL("libxcb.so.1"), ctypes.CDLL(None)
    handle, reply = ctypes.c_void_p, ctypes.POINTER(_Reply)
    for name, result in (
        *(("xcb_connect", handle), ("xcb_get_setup", handle), ("xcb_get_property_value", handle)),
        *(("xcb_intern_atom_reply", reply), ("xcb_get_property_reply", reply)),
        ("xcb_setup_roots_iterator", _Screens),
    ):
        getattr(x, name).restype = result
    connection = handle(x.xcb_connect(None, None))
    try:
        if x.xcb_connection_has_error(connection):
            return None
        root = x.xcb_setup_roots_iterator(handle(x.xcb_get_setup(connection))).root[0]
        wanted = f"_ICC_PROFILE_{number}".removesuffix("_0").encode()
        asked = x.xcb_intern_atom(connection, 1, len(wanted), wanted)
        named = x.xcb_intern_atom_reply(connection, asked, None)
        atom = named.contents.atom if named else 0
        libc.free(named)
        if not atom:
            return None
        asked = x.xcb_get_property(connection, 0, root, atom, _ANY, 0, _MOST_BYTES // 4)
        found = x.xcb_get_property_reply(connection, asked, None)
        if not found:
            return None
        size = x.xcb_get_property_value_length(found)
        profile = ctypes.string_at(x.xcb_get_property_value(found), size)
        libc.free(found)
        return profile or None
    finally:
        x.xcb_disconnect(connection)
