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
        ),
        Spec(
            "save-project",
            menu,
            tr("Save pro&ject"),
            "Ctrl+Alt+P",
            tr("Keep points and settings beside the photo, to go on with another time"),
        ),
        Spec(
            "save-options",
            menu,
            tr("Save opt&ions…"),
            "Ctrl+Alt+O",
            tr("What saved pictures tell of themselves"),
            ends_group=True,
        ),
        Spec(
            "batch",
            menu,
            tr("&Batch…"),
            "Ctrl+B",
            tr("The same settings for many photos"),
            ends_group=True,
        ),
        Spec(
            "import-landmarks",
            menu,
            tr("I&mport landmarks…"),
            "Ctrl+Shift+I",
            tr("Points from WebMorph, iBUG or a table in place of those found"),
        ),
        Spec(
            "export-landmarks",
            menu,
            tr("&Export landmarks…"),
            "Ctrl+Shift+E",
            tr("The points for WebMorph, iBUG or a table"),
            ends_group=True,
        ),
        Spec("quit", menu, tr("&Quit"), "Ctrl+Q", tr("Close the window")),
    )
