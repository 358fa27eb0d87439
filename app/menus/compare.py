"""The Compare menu: ways to see before and after."""

from __future__ import annotations

from ..before_after import CompareName, comparisons
from ..i18n import tr
from .spec import Spec


def specs() -> tuple[Spec, ...]:
    """Return the entries in their order."""
    menu = tr("Com&pare")
    ways = comparisons()
    return (
        *(
            Spec(compare_action(c.name), menu, c.title, c.key, c.tip, False, c is ways[-1])
            for c in ways
        ),
        Spec("wipe-left", menu, tr("Divider to the &left"), ",", tr("See more of the result")),
        Spec("wipe-right", menu, tr("Divider to the &right"), ".", tr("See more of the original")),
        Spec("loupe", menu, tr("&Loupe"), "Z", tr("Before and after magnified"), False),
    )


def compare_action(name: CompareName) -> str:
    """Return the name of the action that compares in one way."""
    return f"compare-{name}"
