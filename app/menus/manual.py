"""The Manual menu: the paper's conventional method."""

from __future__ import annotations

from ..i18n import tr
from .spec import Spec


def specs() -> tuple[Spec, ...]:
    """Return the entries in their order."""
    menu = tr("&Manual")
    return (
        Spec(
            "mode-automatic", menu, tr("&Automatic"), "F2", tr("Points found by the machine"), True
        ),
        Spec(
            "mode-manual",
            menu,
            tr("&Manual"),
            "F3",
            tr("Points set by hand, the paper's conventional method (table 2)"),
            checked=False,
            ends_group=True,
        ),
        Spec(
            "mark",
            menu,
            tr("Mar&k"),
            "M",
            tr("Press to set a landmark, drag to where it goes"),
            checked=False,
        ),
        Spec("mirror", menu, tr("Mi&rror"), "Shift+M", tr("The selected point on the other side")),
        Spec(
            "mirror-side",
            menu,
            tr("Mirror s&ide"),
            "Ctrl+M",
            tr("Make the other side of the face like the selected point's"),
        ),
        Spec(
            "snap",
            menu,
            tr("S&nap"),
            "Shift+N",
            tr("Put the selected point's target on the line to the centre"),
            ends_group=True,
        ),
        Spec("apply", menu, tr("A&pply"), "Ctrl+Return", tr("Everything is set: stop the clock")),
        Spec(
            "compare-modes",
            menu,
            tr("&Compare…"),
            "F4",
            tr("Manual and automatic side by side, with their times"),
        ),
    )
