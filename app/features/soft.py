"""What goes along with a landmark that is moved by hand: its neighbours, the other side."""

from __future__ import annotations

import dataclasses
from typing import Final

from PySide6.QtCore import QSettings, Signal

from ..actions import Spec
from ..i18n import tr
from ..view_state import Following
from .feature import Context, Feature
from .points import Points

# In landmark spacings: nearer than the least nobody follows, beyond the most everybody does.
_LEAST_REACH: Final = 1.5
_MOST_REACH: Final = 12.0
_PER_NOTCH: Final = 1.15
_GROUP: Final = "soft-selection"


class SoftSelection(Feature):
    """Switches the soft and the symmetric drag, and says how far neighbours follow.

    Signals
    -------
    changed
        Something else follows, as `ViewState.following` says.
    """

    changed = Signal()

    def __init__(self, context: Context, points: Points) -> None:
        super().__init__(context)
        self.view.following = _remembered(self.settings)
        self.add_actions(
            Spec(
                "soft",
                tr("Nei&ghbours follow"),
                "Q",
                tr("Neighbours on the outline follow a landmark; turn the wheel while dragging"),
                toggled=lambda on: self._take(soft=on),
                checked=self.view.following.soft,
            ),
            Spec(
                "symmetric",
                tr("&Both sides"),
                "Shift+Q",
                tr("The landmark across the face makes the mirrored move"),
                toggled=lambda on: self._take(symmetric=on),
                checked=self.view.following.symmetric,
            ),
            Spec(
                "reach-wider",
                tr("Follow far&ther"),
                "Ctrl+]",
                tr("More neighbours follow"),
                lambda: self.widen(1.0),
            ),
            Spec(
                "reach-narrower",
                tr("Follow &less far"),
                "Ctrl+[",
                tr("Fewer neighbours follow"),
                lambda: self.widen(-1.0),
            ),
        )
        self.window.canvas.widened.connect(self.widen)
        self.changed.connect(points.follow_anew)
        self._show()

    def widen(self, notches: float) -> None:
        """Let neighbours follow farther along the outline, or less far; a drag in hand, too."""
        self._take(reach=_bounded(self.view.following.reach * _PER_NOTCH**notches))
        text = tr("Neighbours follow over {n:.1f} landmark spacings", n=self.view.following.reach)
        self.window.status.name_point(text)

    def _take(self, **changes: object) -> None:
        self.view.following = dataclasses.replace(self.view.following, **changes)  # type: ignore[arg-type]
        for name, value in changes.items():
            self.settings.setValue(f"{_GROUP}/{name}", value)
        self._show()
        self.changed.emit()

    def _show(self) -> None:
        for name in ("reach-wider", "reach-narrower"):
            self.actions[name].setEnabled(self.view.following.soft)


def _remembered(settings: QSettings) -> Following:
    """Return what followed at the end of the last session; at first, nothing does."""
    first = Following()
    return Following(
        soft=bool(settings.value(f"{_GROUP}/soft", first.soft, bool)),
        reach=_bounded(float(str(settings.value(f"{_GROUP}/reach", first.reach, float)))),
        symmetric=bool(settings.value(f"{_GROUP}/symmetric", first.symmetric, bool)),
    )


def _bounded(reach: float) -> float:
    return min(_MOST_REACH, max(_LEAST_REACH, reach))
