"""The File menu."""

from __future__ import annotations

from ..i18n import tr
from .spec import Spec


def specs() -> tuple[Spec, ...]:
    """Return the entries in their order."""
    menu = tr("&File")
    return (
        Spec("open", menu, tr("&Open…"), "Ctrl+O", tr("Open a photo")),
        Spec("folder", menu, tr("Open a &folder…"), "Ctrl+Shift+O", tr("Photos as a film strip")),
        Spec("recent", menu, "", "", ""),
        Spec("next-photo", menu, tr("&Next photo"), "Ctrl+Right", tr("Next on the film strip")),
        Spec(
            "previous-photo",
            menu,
            tr("Pre&vious photo"),
            "Ctrl+Left",
            tr("Previous on the film strip"),
        ),
        Spec(
            "sample",
            menu,
            tr("Open the sample &portrait"),
            "",
            tr("A face to try things on"),
            ends_group=True,
        ),
        Spec(
            "save",
            menu,
            tr("&Save a copy…"),
            "Ctrl+S",
            tr("Save the result under another name; the original is never touched"),
            ends_group=True,
        ),
        Spec("quit", menu, tr("&Quit"), "Ctrl+Q", tr("Close the window")),
    )
