"""The Experiments menu: the paper's instruments."""

from __future__ import annotations

from ..i18n import tr
from .spec import Spec


def specs() -> tuple[Spec, ...]:
    """Return the entries in their order."""
    menu = tr("E&xperiments")
    return (
        Spec(
            "experiment-timing",
            menu,
            tr("Setting and computing &time…"),
            "Ctrl+1",
            tr("Manual and automatic, whole and reduced, on this photo (table 2)"),
        ),
        Spec(
            "experiment-domains",
            menu,
            tr("Reduced &domains…"),
            "Ctrl+2",
            tr("Pixels of the three domains, and what a threshold costs (figures 14 and 15)"),
        ),
        Spec(
            "experiment-distortion",
            menu,
            tr("D&istortion…"),
            "Ctrl+3",
            tr("What can be measured where people called faces unnatural (table 1, figure 11)"),
        ),
        Spec(
            "experiment-methods",
            menu,
            tr("&Methods side by side…"),
            "Ctrl+4",
            tr("Other warps on the same points: speed, exactness, folds"),
            ends_group=True,
        ),
        Spec(
            "rate",
            menu,
            tr("&Rate pictures…"),
            "Ctrl+R",
            tr("Say which pictures of a study look natural (table 1, figure 11)"),
        ),
    )
