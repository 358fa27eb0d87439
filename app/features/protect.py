"""Protection by brush, line and eraser, and the size of all brushes."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable
from pathlib import Path
from typing import Final, Literal

from PySide6.QtGui import QAction, QActionGroup
from PySide6.QtWidgets import QPushButton, QWidget

from kogao_core.field.mask import Mask, read_mask
from kogao_core.field.measures import reduced
from kogao_core.field.protection import NOTHING, Stroke

from ..canvas.tools.gesture import Gesture, PointerEvent
from ..canvas.tools.protect import line_at, move_line, protect
from ..i18n import sentence, tr
from ..theme import GRID_PX
from ..view_state import Brush, Handle, ToolName
from ..widgets.controls import Eye, column_of, heading, muted_label, row_of, segmented
from ..widgets.dialogs import ask_path, photo_filter
from ..widgets.sliders import ValueSlider
from ..widgets.typed import SliderScale
from .feature import Context, Feature

Use = Literal["area", "line", "move"]
# Default radius as a fraction of the photo's longer side, and of the width of the first face.
_OF_PHOTO: Final[dict[Use, float]] = {"area": 1 / 100, "line": 1 / 100, "move": 1 / 25}
_OF_FACE: Final[dict[Use, float]] = {"line": 1 / 40, "move": 1 / 4}
_STEPS_PER_OCTAVE: Final = 8
_SMALLEST_PX: Final = 1.0
_REACH_PX: Final = 8.0  # from a line on the screen
_LARGEST_PX: Final = 512.0
# Four presses of a bracket key double the brush.
_PRESSES_PER_OCTAVE: Final = 4


class Protect(Feature):
    """Paints and erases protection."""

    name = "protect"

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._tools = QActionGroup(self)
        self._radii: dict[Use, float] = {}  # radius of the inactive tools
        self._line: Stroke | None = None  # the line whose width Size sets
        tools = {tool: self.add_tool(tool) for tool in ("points", "brush", "line", "eraser")}
        self.bind("smaller", lambda: self.resize(-1))
        self.bind("larger", lambda: self.resize(1))
        self.bind("protect-mask", self._ask_mask)
        self.bind("unprotect", self.clear)
        self._reading = self.lane(self._take_mask, lambda problem: self.say(sentence(problem)))
        self.done = tools.pop("points")
        self.panel: ProtectPanel = ProtectPanel(
            tools.values(), self.actions["unprotect"], self.done
        )
        self.panel.size_brushes(self)
        self.window.canvas.tools |= dict.fromkeys(("brush", "line", "eraser"), self._draw)
        self.window.canvas.turned.connect(self._turn)
        self._below: ToolName = "points"  # the tool while the eraser end of a pen is away
        self.view.watch(self._show_tool, "brush")
        self.document.opened.connect(self.fit_brush)
        self.view.watch(self._show_reduced, "frame")
        self.document.watch(self._show_count, "protection")
        self.follow_eye(self.panel.eye, "protection")
        # Each photo starts with a fitting brush size.
        self.enable_with_photo(self.panel.size_px.setEnabled)

    def add_tool(self, name: ToolName) -> QAction:
        """Bind the command of a tool and add it to the group of exclusive tools."""
        first = name == self.view.brush.tool
        tool = self.bind(f"tool-{name}", lambda: self.take(name), checked=first)
        self._tools.addAction(tool)
        return tool

    # -- the brush -------------------------------------------------------------------------------

    def take(self, tool: ToolName) -> None:
        """Select a tool. Lines, other protection and moving tools have separate sizes."""
        before = self.view.brush
        self._radii[_use(before)] = before.radius_px
        self._line = None
        use = _use(dataclasses.replace(before, tool=tool))
        self.set_brush(tool=tool, radius_px=self._radii.get(use) or self.fitting_px(use))

    def _turn(self, turned: bool) -> None:
        """Restore, or erase protection, with the eraser end of a pen."""
        brush = self.view.brush
        erases: ToolName = "eraser" if brush.protects else "restore"
        if turned:
            self._below = brush.tool
            self.actions[f"tool-{erases}"].trigger()
        elif brush.tool == erases:
            self.actions[f"tool-{self._below}"].trigger()

    def set_radius(self, radius_px: float) -> None:
        """Set the radius of the brush, and of the line that was moved last, px of the photo."""
        self.window.bar.move_on()
        radius_px, state = min(max(radius_px, _SMALLEST_PX), _LARGEST_PX), self.document.state
        self.set_brush(radius_px=radius_px)
        line = self._line
        if line is not None and line in state.protection.strokes:
            self._line = dataclasses.replace(line, radius_px=radius_px)
            protection = state.protection.replaced(line, self._line)
            state = dataclasses.replace(state, protection=protection)
            self.document.preview(state, tr("Line width"))

    def fit_brush(self) -> None:
        self._radii, use = {}, _use(self.view.brush)  # of other tools once the faces are known
        self.set_radius(self.fitting_px(use))
        self.panel.size_px.show_first(self.fitting_px("area" if use == "move" else use))

    def fitting_px(self, use: Use) -> float:
        """Return the default radius of a tool, px: a line is narrow beside a head."""
        faces, image = self.document.state.faces, self.document.image
        if faces and use in _OF_FACE:
            return min(_OF_FACE[use] * faces[0].box[2], _LARGEST_PX)
        return min(_OF_PHOTO[use] * max(image.width, image.height), _LARGEST_PX)

    def resize(self, steps: int) -> None:
        """Change the brush size by a number of key presses."""
        self.set_radius(self.view.brush.radius_px * 2.0 ** (steps / _PRESSES_PER_OCTAVE))
        self.document.commit()

    # -- strokes ---------------------------------------------------------------------------------

    def _draw(self, _: Handle | None, event: PointerEvent) -> Gesture:
        self._line, canvas = None, self.window.canvas
        grip = line_at(self.document.state.protection, event.point_px, canvas.in_photo(_REACH_PX))
        if grip is None or self.view.brush.tool != "line":
            return protect(self.view, event)
        self._hold(grip[0])
        self.set_brush(radius_px=grip[0].radius_px)
        return move_line(self.view, grip, event, self._hold)

    def _hold(self, line: Stroke) -> None:
        self._line = line

    def follow_eye(self, eye: Eye, field: str) -> None:
        """Switch a field of the state off and on with an eye."""

        def switch(value: object) -> None:
            state = dataclasses.replace(self.document.state, **{field: value})  # type: ignore[arg-type]
            self.document.step(state, eye.accessibleName())

        def show() -> None:
            value = getattr(self.document.state, field)
            eye.show_value(value, None, is_off=not value.strokes)

        eye.switched.connect(switch)
        self.document.opened.connect(eye.forget)
        self.document.watch(show, field)

    def _ask_mask(self) -> None:
        filters, at = [photo_filter()], self.document.path
        ask_path(self.window, tr("Protect from mask"), self.open_mask, filters=filters, at=at)

    def open_mask(self, path: Path) -> None:
        """Protect the white pixels of a picture of the photo's size."""
        image = self.document.image
        self._reading.submit(lambda: read_mask(path, image.width, image.height))

    def _take_mask(self, mask: Mask) -> None:
        state = self.document.state
        protection = state.protection.with_mask(mask)
        if protection is state.protection:
            self.say(tr("The mask has no white pixel, so it protects nothing."))
            return
        state = dataclasses.replace(state, protection=protection)
        self.document.step(state, tr("Protect from mask"))

    def clear(self) -> None:
        if self.document.state.protection.strokes:
            state = dataclasses.replace(self.document.state, protection=NOTHING)
            self.document.step(state, tr("Remove all protection"))

    def set_brush(self, **changes: object) -> None:
        """Change properties of the tool."""
        self.view.set(brush=dataclasses.replace(self.view.brush, **changes))  # type: ignore[arg-type]

    def _show_tool(self) -> None:
        self.panel.show_brush(self.view.brush)
        self._show_need()

    def _show_count(self) -> None:
        self.panel.show_count(len(self.document.state.protection.strokes))
        self._show_need()

    def _show_reduced(self) -> None:
        frame, message, detail = self.view.frame, "", ""
        shares = () if frame is None else frame.figures.protected_shares
        if slowed := reduced(shares):
            message = tr("{n} outline points move less", n=len(slowed))
            detail = tr(
                "{n} of {count} outline points move less, one by {percent:.0f} % of its way",
                n=len(slowed),
                count=sum(map(len, shares)),
                percent=100 * min(slowed),
            )
        self.panel.show_reduced(message, detail)

    def _show_need(self) -> None:
        self.window.need(self.name, self.view.brush.protects)


class BrushPanel(QWidget):
    """The panel of the active tool: its tools, the brush, and a button that removes all strokes."""

    def __init__(
        self,
        title: str,
        tools: Iterable[QAction],
        size_px: ValueSlider,
        controls: Iterable[QWidget],
        clear: tuple[QPushButton, QAction],
        nothing: str,
        done: QAction,
        off: object,
    ) -> None:
        super().__init__()
        self.size_px, self.count, self._nothing = size_px, muted_label(), nothing
        self.clear, action = clear
        self.clear.clicked.connect(action.trigger)
        self.clear.setProperty("quiet", "true")
        self.done, self.eye = QPushButton(tr("Done")), Eye(title, off)
        self.done.setToolTip(done.toolTip())
        self.done.clicked.connect(done.trigger)
        below = row_of(self.count, None, self.clear)
        top = row_of(heading(title), self.eye, None, self.done)
        choice = segmented(title, list(tools))
        column_of(self, top, choice, size_px, *controls, below, spacing=GRID_PX)

    def size_brushes(self, brushes: Protect) -> None:
        self.size_px.edited.connect(brushes.set_radius)
        self.size_px.reset.connect(brushes.fit_brush)
        self.size_px.rested.connect(brushes.document.commit)
        self.size_px.refused.connect(brushes.say)

    def show_count(self, strokes: int) -> None:
        self.count.setText(tr("Strokes: {n}", n=strokes) if strokes else self._nothing)
        self.clear.setEnabled(strokes > 0)


class ProtectPanel(BrushPanel):
    """Tools, brush size, the effect on outline points, and a button that removes everything."""

    def __init__(self, tools: Iterable[QAction], clear: QAction, done: QAction) -> None:
        tip = tr("Width of brush, line and eraser in px of the photo; [ and ] change it")
        size_px = ValueSlider(tr("Si&ze"), sizes(), tip, 0)
        self.reduced = muted_label(wraps=True)
        self.reduced.hide()
        remove = QPushButton(tr("Remove all"))
        remove.setAccessibleName(tr("Remove all protection"))
        remove.setToolTip(tr("Remove all painted and drawn protection"))
        nothing = tr("No protection")
        content = [self.reduced], (remove, clear), nothing, done, NOTHING
        super().__init__(tr("Protect"), tools, size_px, *content)

    def show_reduced(self, message: str, detail: str = "") -> None:
        """Show how far protection limits outline points; hide an empty message."""
        self.reduced.setText(message)
        self.reduced.setToolTip(detail)
        self.reduced.setVisible(bool(message))

    def show_brush(self, brush: Brush) -> None:
        self.size_px.show_value(brush.radius_px)


def _use(brush: Brush) -> Use:
    return "move" if brush.moves else "line" if brush.tool == "line" else "area"


def sizes() -> SliderScale:
    """Return the scale for the brush size."""
    low, high = (round(_STEPS_PER_OCTAVE * math.log2(px)) for px in (_SMALLEST_PX, _LARGEST_PX))
    return SliderScale(
        low,
        high,
        _STEPS_PER_OCTAVE,
        lambda n: 2.0 ** (n / _STEPS_PER_OCTAVE),
        lambda v: round(_STEPS_PER_OCTAVE * math.log2(v)),
        lambda v: tr("{v:.0f} px", v=2 * v),
        lambda px: round(px) / 2,
    )
