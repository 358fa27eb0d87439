"""What goes along with a landmark that is moved by hand: its neighbours, the other side."""

from __future__ import annotations

import dataclasses
from typing import Final

from PySide6.QtCore import Signal

from ..actions import Spec
from ..i18n import tr
from .feature import Context, Feature
from .points import Points

# In landmark spacings: nearer than the least nobody follows, beyond the most everybody does.
_LEAST_REACH: Final = 1.5
_MOST_REACH: Final = 12.0
_PER_NOTCH: Final = 1.15


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
        self.add_actions(
            Spec(
                "soft",
                tr("Nei&ghbours follow"),
                "Q",
                tr("Neighbours on the outline follow a landmark; turn the wheel while dragging"),
                toggled=lambda on: self._take(soft=on),
                checked=False,
            ),
            Spec(
                "symmetric",
                tr("&Both sides"),
                "Shift+Q",
                tr("The landmark across the face makes the mirrored move"),
                toggled=lambda on: self._take(symmetric=on),
                checked=False,
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
        reach = self.view.following.reach * _PER_NOTCH**notches
        self._take(reach=min(_MOST_REACH, max(_LEAST_REACH, reach)))
        text = tr("Neighbours follow over {n:.1f} landmark spacings", n=self.view.following.reach)
        self.window.status.name_point(text)

    def _take(self, **changes: object) -> None:
        self.view.following = dataclasses.replace(self.view.following, **changes)  # type: ignore[arg-type]
        self._show()
        self.changed.emit()

    def _show(self) -> None:
        for name in ("reach-wider", "reach-narrower"):
            self.actions[name].setEnabled(self.view.following.soft)
