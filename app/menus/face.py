"""The Face menu: finding, placing, and the source of landmarks."""

from __future__ import annotations

from itertools import chain, repeat
from typing import Final

from kogao_core.landmarks import CHOICES, Measured

from ..i18n import tr
from .spec import Spec

_KEYS: Final = ("F5", "F6", "F7")  # of the landmark sources, in turn


def specs() -> tuple[Spec, ...]:
    """Return the entries in their order."""
    menu = tr("F&ace")
    return (
        Spec("find", menu, tr("&Find faces again"), "Ctrl+F", tr("Undo all corrections of points")),
        Spec(
            "place",
            menu,
            tr("&Place a face by hand"),
            "Ctrl+P",
            tr("A mean face to drag into place"),
            ends_group=True,
        ),
        Spec(
            "follow-photo",
            menu,
            tr("&Use the photo's settings"),
            "",
            tr("Forget the settings of this face's own"),
        ),
        Spec(
            "next-point", menu, tr("Ne&xt point"), "Ctrl+.", tr("Select a point for the arrow keys")
        ),
        Spec(
            "previous-point",
            menu,
            tr("Pre&vious point"),
            "Ctrl+,",
            tr("Select a point for the arrow keys"),
        ),
        Spec(
            "delete",
            menu,
            tr("&Delete the selected point"),
            "Delete",
            tr("Delete a landmark set by hand; put a target back on its line"),
            ends_group=True,
        ),
        *_sources(menu),
    )


def _sources(menu: str) -> list[Spec]:
    return [
        *(
            Spec(
                f"landmarks-{choice.name}",
                menu,
                tr("Landmarks by the &{title}", title=tr(choice.title)),
                key,
                _figures(choice.measured),
                checked=False,
            )
            for choice, key in zip(CHOICES, chain(_KEYS, repeat("")), strict=False)
        ),
        Spec(
            "landmarks-file",
            menu,
            tr("Landmarks by a model of &yours…"),
            "Shift+F6",
            tr("An LBF or Kazemi model of 68 points, as cv2.face reads them"),
            checked=False,
        ),
    ]


def _figures(measured: Measured | None) -> str:
    if measured is None:
        return tr("How exact it is wasn't measured")
    return tr(
        "Outline within {studio:g} % of the eyes' distance on studio portraits, "
        "{wild:g} % elsewhere; about {ms:.0f} ms",
        studio=measured.studio_jaw,
        wild=measured.wild_jaw,
        ms=measured.typical_ms,
    )
