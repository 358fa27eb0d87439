"""Push and restore brushes."""

from __future__ import annotations

import dataclasses
from typing import Final

from PySide6.QtGui import QAction
from PySide6.QtWidgets import QPushButton

from kogao_core.additions.brush import LEAST_FALLOFF, UNTOUCHED
from kogao_core.additions.limits import OutOfBounds

from ..canvas.tools.gesture import Gesture, PointerEvent
from ..canvas.tools.push import push
from ..i18n import reason, tr
from ..view_state import Brush, Handle
from ..widgets.controls import WarningLabel
from ..widgets.sliders import ValueSlider
from ..widgets.typed import SliderScale
from .feature import Context, Feature
from .protect import BrushPanel, Protect, sizes

_STEP_PERCENT: Final = 5


class Push(Feature):
    """Pushes pixels with a round brush, and restores the original."""

    name = "push"

    def __init__(self, context: Context, protect: Protect) -> None:
        super().__init__(context)
        tools = [protect.add_tool("push"), protect.add_tool("restore")]
        clear = self.bind("clear-strokes", self.clear)
        self.panel: PushPanel = PushPanel(tools, clear, protect.done)
        for slider, name in ((self.panel.strength, "strength"), (self.panel.falloff, "falloff")):
            slider.edited.connect(lambda value, name=name: protect.set_brush(**{name: value}))
            slider.refused.connect(self.say)
            slider.reset.connect(
                lambda name=name: protect.set_brush(**{name: getattr(Brush(), name)})
            )
        self.panel.size_brushes(protect)
        self.window.canvas.tools |= dict.fromkeys(("push", "restore"), self._draw)
        self.view.watch(self._show_tool, "brush")
        self.view.watch(self._show_held, "frame")
        self._protect = protect
        self.document.watch(self._fit_face, "photo", "faces", value=self._fitted)
        self.document.watch(self._show_count, "brushwork")
        protect.follow_eye(self.panel.eye, "brushwork")
        self.enable_with_photo(self.panel.size_px.setEnabled)

    def _fitted(self) -> tuple[object, ...]:
        return self.document.path, bool(self.document.state.faces)

    def _fit_face(self) -> None:
        """Size the brush by the first face, unless the photo was edited already."""
        if self.document.photo is not None and not self.document.undo.count():
            self._protect.fit_brush()
            self.panel.size_px.show_first(self._protect.fitting_px("move"))

    def _draw(self, _: Handle | None, event: PointerEvent) -> Gesture:
        return push(self.view, event, self._refuse)

    def _refuse(self, problem: OutOfBounds) -> None:
        drawn = self.document.committed
        self.say(reason(problem), applies=lambda: self.document.committed is drawn)

    def clear(self) -> None:
        if self.document.state.brushwork.strokes:
            state = dataclasses.replace(self.document.state, brushwork=UNTOUCHED)
            self.document.step(state, tr("Clear strokes"))

    def _show_tool(self) -> None:
        self.panel.show_brush(self.view.brush)
        self._show_need()

    def _show_count(self) -> None:
        self.panel.show_count(len(self.document.state.brushwork.strokes))

    def _show_held(self) -> None:
        frame = self.view.frame
        shares = () if frame is None else frame.rendering.brush_shares
        held = {number: share for number, share in enumerate(shares, 1) if share < 1.0}
        words = ""
        if held:
            words = tr(
                "⚠ Limited to avoid folding: {strokes}.",
                strokes=", ".join(
                    tr("stroke {n} to {percent:.0f} %", n=number, percent=100 * share)
                    for number, share in held.items()
                ),
            )
        self.panel.show_held(words)
        self._show_need()

    def _show_need(self) -> None:
        self.window.need(self.name, self.view.brush.moves)


class PushPanel(BrushPanel):
    """Tools, size, strength, falloff, and a button that removes all strokes."""

    def __init__(self, tools: list[QAction], clear: QAction, done: QAction) -> None:
        tip = tr("Width of the brush in px of the photo; [ and ] change it")
        size_px = ValueSlider(tr("Size"), sizes(), tip)
        self.strength = ValueSlider(
            tr("Strength"),
            _percents(_STEP_PERCENT),
            tr("Strength of push and restore at full pen pressure"),
        )  # fmt: skip
        self.falloff = ValueSlider(
            tr("Softness"),
            _percents(round(100 * LEAST_FALLOFF)),
            tr("Width of the soft rim, as a share of the brush"),
        )
        self.held = WarningLabel(wraps=True)
        remove = QPushButton(tr("Clear strokes"))
        remove.setToolTip(clear.statusTip())
        controls = self.strength, self.falloff, self.held
        title, nothing = tr("Push and restore"), tr("No strokes")
        content = controls, (remove, clear), nothing, done, UNTOUCHED
        super().__init__(title, tools, size_px, *content)
        self.strength.show_first(Brush().strength)
        self.falloff.show_first(Brush().falloff)
        self.held.warn(True)
        self.show_held("")
        self.show_brush(Brush())

    def show_brush(self, brush: Brush) -> None:
        self.size_px.show_value(brush.radius_px)
        self.strength.show_value(brush.strength)
        self.falloff.show_value(brush.falloff)

    def show_held(self, words: str) -> None:
        """Show which strokes were limited to avoid folds; hide an empty message."""
        self.held.setText(words)
        self.held.setVisible(bool(words))


def _percents(low: int) -> SliderScale:
    return SliderScale(
        *(low, 100, 10),
        lambda n: n / 100,
        lambda v: round(100 * v),
        lambda v: tr("{v} %", v=round(100 * v)),
        lambda percent: round(percent) / 100,
    )
