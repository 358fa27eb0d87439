"""Overlays of the displacement field: arrows, maps, lattice, domains, folds."""

from __future__ import annotations

from typing import ClassVar, Final

import numpy as np
import numpy.typing as npt
import pyqtgraph as pg
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QBrush, QImage, QPainter, QPen

from kogao_core.base.display import Rgb8
from kogao_core.base.geometry import Affine, Array, Box
from kogao_core.base.language import Text
from kogao_core.field.field import Field
from kogao_core.paper import domain
from kogao_core.paper.lattice import Grid, Lattice

from ...i18n import tr
from ...render.pictures import qt_image
from ...view_state import RenderedFrame, ViewState
from . import glyphs
from .overlay import FrameOverlay, Place

_ARROWS_EVERY_PX: Final = 32.0
_ARROW_GAIN: Final = 3.0
_LEAST_ARROW_PX: Final = 4.0
# A control point affects two cells to either side.
_REACH: Final = 2
# Sample domains on every third px of the screen: a ninth of the work, no visible difference.
_SAMPLE_PX: Final = 3
# The field is smooth: sample every fourth px of the screen; Qt interpolates between samples.
_SMOOTH_PX: Final = 4.0
_STRONGEST: Final = 0.8  # greatest opacity of a map
_LEGEND_PX: Final = (160.0, 10.0)
_VALUES_LINES: Final = 18.0, 8.0  # room for the values at the upper left, in heights of a line
_MARGIN_PX: Final = 16.0
_NICE: Final = (1.0, 1.5, 2.0, 3.0, 5.0, 7.5, 10.0)
# Leave out the darkest colours of a scale: these look like shadows on a photo.
_DARKEST: Final = 0.2


class Displacement(FrameOverlay):
    """Arrows of the displacement, on a grid fixed to the photo."""

    name = "displacement"
    title = Text("Displacement, 3 × as long")  # noqa: RUF001
    height = 80
    key = "V"

    @classmethod
    def swatch(cls, painter: QPainter, box: QRectF) -> None:
        y = box.center().y()
        shaft = (box.left() + 2, y), (box.right() - 2, y)
        glyphs.arrow(painter, [shaft], glyphs.DISPLACEMENT)

    def draw_frame(self, painter: QPainter, place: Place, frame: RenderedFrame) -> None:
        step = _ARROWS_EVERY_PX / place.zoom
        (left, top), (right, bottom) = place.seen
        xs = np.arange(np.floor(left / step), np.ceil(right / step) + 1) * step
        ys = np.arange(np.floor(top / step), np.ceil(bottom / step) + 1) * step
        tips = np.stack(np.meshgrid(xs, ys), axis=-1).reshape(-1, 2)
        displacement = frame.rendering.field.at(frame.to_photo.inverse(tips)) * frame.scale
        length = np.hypot(displacement[:, 0], displacement[:, 1]) * place.zoom * _ARROW_GAIN
        tips, displacement = tips[length > _LEAST_ARROW_PX], displacement[length > _LEAST_ARROW_PX]
        shafts = np.stack([tips + _ARROW_GAIN * displacement, tips], axis=1)
        glyphs.arrow(painter, place.to_screen(shafts), glyphs.DISPLACEMENT)


class LatticeLines(FrameOverlay):
    """The control lattice, displaced like the photo."""

    name = "lattice"
    title = Text("Lattice")
    height = 60
    key = "G"

    @classmethod
    def swatch(cls, painter: QPainter, box: QRectF) -> None:
        places = (box.left() + 4, box.center().x(), box.right() - 4)
        rungs = [((box.left() + 2, y), (box.right() - 2, y)) for y in places]
        rails = [((x, box.top() + 2), (x, box.bottom() - 2)) for x in places]
        glyphs.fine_lines(painter, [*rungs, *rails], glyphs.LATTICE)

    def draw_frame(self, painter: QPainter, place: Place, frame: RenderedFrame) -> None:
        """Draw lines through the control points, and mark displaced control points."""
        for lattice in frame.rendering.field.lattices:
            rows, columns = lattice.shape
            rows, columns = rows + 2 * _REACH, columns + 2 * _REACH
            xs = lattice.grid.nodes_px(lattice.first[0] - _REACH, columns, 0)
            ys = lattice.grid.nodes_px(lattice.first[1] - _REACH, rows, 1)
            phi = np.pad(lattice.phi, ((_REACH, _REACH), (_REACH, _REACH), (0, 0)))
            nodes = frame.to_photo(np.stack(np.meshgrid(xs, ys), axis=-1) - phi)
            seen = place.to_screen(nodes)
            segments = [
                np.stack([line[:-1], line[1:]], axis=-2).reshape(-1, 2, 2)
                for line in (seen, seen.swapaxes(0, 1))
            ]
            glyphs.fine_lines(painter, np.concatenate(segments), glyphs.LATTICE)
            moving = np.hypot(phi[..., 0], phi[..., 1]) > 0.0
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(glyphs.LATTICE)
            half = min(2.0, 0.08 * lattice.grid.spacing_px * frame.scale * place.zoom)
            for x, y in seen[moving].tolist():
                painter.drawRect(QRectF(x - half, y - half, 2 * half, 2 * half))


class DomainRegions(FrameOverlay):
    """The domains of figures 12 to 15: the reduced one filled, the two larger ones as outlines."""

    name = "domains"
    title = Text("Reduced warp domain")
    height = 30
    key = "D"

    @classmethod
    def swatch(cls, painter: QPainter, box: QRectF) -> None:
        glyphs.domain_mark("threshold")(painter, box)

    def draw_frame(self, painter: QPainter, place: Place, frame: RenderedFrame) -> None:
        """Fill the reduced domain, outline every domain, and write the reduced share beside it."""
        photo = place.box(self.shown.image)
        screen = photo.intersected(place.viewport)
        masks, to_screen = _masks(place, frame, screen, self.shown.state.recipe.threshold_px)
        regions = {
            name: glyphs.mask_outline(painter, mask, to_screen) for name, mask in masks.items()
        }
        reduced = regions["threshold"]
        painter.setRenderHint(QPainter.RenderHint.Antialiasing, False)
        painter.fillPath(reduced, glyphs.DOMAIN)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        glyphs.domain_edge(painter, glyphs.framed(painter, photo), "image")
        for name, path in regions.items():
            glyphs.domain_edge(painter, path, name)
        self._tell(painter, place, reduced.boundingRect())

    def _tell(self, painter: QPainter, place: Place, region: QRectF) -> None:
        counts = self.shown.counts
        if not counts or region.isEmpty():
            return
        share = 100 * counts["threshold"] / max(1, counts["image"])
        text = tr("Only these {n:.1f} % are computed", n=share)
        seen = region.intersected(place.viewport)
        width = glyphs.plate(painter.font(), QPointF(), text, bold=True).width()
        # At the top: the legend is at the bottom. Beside or below the values under the cursor.
        at = QPointF(seen.center().x() - width / 2, seen.top() + 20.0)
        line, corner = painter.fontMetrics().height(), place.viewport.topLeft()
        values = corner + QPointF(*_VALUES_LINES) * line
        if at.x() < values.x() and at.y() < values.y():
            if values.x() + width < place.viewport.right():
                at.setX(values.x())
            else:
                at.setY(values.y())
        glyphs.label(painter, at, text, bold=True, within=place.viewport)


class Folds(FrameOverlay):
    """Lattice cells in which the warp folds."""

    name = "folds"
    title = Text("Folded cells")
    height = 40
    key = "J"

    @classmethod
    def swatch(cls, painter: QPainter, box: QRectF) -> None:
        glyphs.warning(painter, box.center() + QPointF(0, 0.5))

    @classmethod
    def is_there(cls, view: ViewState) -> bool:
        return view.frame is not None and bool(len(view.frame.figures.one_to_one.folded_cells))

    def draw_frame(self, painter: QPainter, place: Place, frame: RenderedFrame) -> None:
        for left, top, width, height in frame.figures.one_to_one.folded_cells:
            ends = frame.to_photo([(left, top), (left + width, top + height)])
            cell = place.rect(*ends.ravel().tolist())
            painter.fillRect(cell, glyphs.translucent(glyphs.FOLD, 130))
            glyphs.outlined(painter, glyphs.framed(painter, cell), glyphs.TURNED)
            glyphs.warning(painter, cell.center(), min(14.0, 0.8 * cell.width()))


def _masks(
    place: Place, frame: RenderedFrame, screen: QRectF, threshold_px: float
) -> tuple[dict[str, npt.NDArray[np.bool_]], Affine]:
    """Return masks of the two smaller domains, and the transform from samples to the screen."""
    corner = np.array([screen.left(), screen.top()])
    shrink = Affine(np.eye(2) / _SAMPLE_PX, -corner / _SAMPLE_PX)
    to_sample = shrink.after(place.to_screen)
    field = _carried(frame.rendering.field, to_sample.after(frame.to_photo))
    box = Box(0, 0, int(screen.width()) // _SAMPLE_PX + 1, int(screen.height()) // _SAMPLE_PX + 1)
    cells = domain.reduce(field.lattices, box, "control-points").mask(box)
    moved = domain.threshold_mask(field.lattices, box, threshold_px * to_sample.scale)
    return {"control-points": cells, "threshold": moved}, shrink.inverse


def _carried(field: Field, transform: Affine) -> Field:
    """Return a field in the coordinates of a scaled and shifted image."""
    scale = transform.scale
    lattices = []
    for lattice in field.lattices:
        x, y = transform(lattice.grid.origin_px).tolist()
        grid = Grid((x, y), lattice.grid.spacing_px * scale)
        lattices.append(Lattice(grid, lattice.first, lattice.phi * scale))
    return Field(tuple(lattices))


_FOLD: Final = (glyphs.FOLD.red(), glyphs.FOLD.green(), glyphs.FOLD.blue(), 255)


class _Map(FrameOverlay):
    """A colour map of a value, transparent at 0, with a legend on the canvas."""

    colours: ClassVar[str]  # name of a pyqtgraph colour map
    # First value of the legend as a fraction of the greatest, and number of colours.
    ramp: ClassVar[tuple[float, int]]
    row = 0  # row of the legend, from below
    _key: tuple[object, ...] = ()
    _image = QImage()
    _top = 1.0

    @classmethod
    def swatch(cls, painter: QPainter, box: QRectF) -> None:
        gradient = pg.colormap.get(cls.colours).getGradient(box.topLeft(), box.topRight())
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(QBrush(gradient))
        painter.drawRoundedRect(box.adjusted(2, 4, -2, -4), 2, 2)

    def draw_frame(self, painter: QPainter, place: Place, frame: RenderedFrame) -> None:
        """Draw the map, from the cache if frame and view are the same."""
        area = place.box(self.shown.image).intersected(place.viewport)
        if area.isEmpty():
            return
        key = (frame, area.getRect(), place.zoom, place.to_screen.shift.tobytes())
        if key != self._key:
            self._key = key
            self._image, self._top = self._painted(frame, place, area)
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
        painter.drawImage(area, self._image)
        self._draw_legend(painter, place)

    def _painted(self, frame: RenderedFrame, place: Place, area: QRectF) -> tuple[QImage, float]:
        xs = _middles(area.left(), area.width())
        ys = _middles(area.top(), area.height())
        there = frame.to_photo.inverse.after(place.to_screen.inverse)
        columns = there(np.column_stack([xs, np.full_like(xs, area.top())]))[:, 0]
        rows = there(np.column_stack([np.full_like(ys, area.left()), ys]))[:, 1]
        values = self.measure(frame, columns, rows)
        top = _nice(float(np.abs(values).max(initial=0.0)))
        return qt_image(self.shades(values, top)).copy(), top

    def _draw_legend(self, painter: QPainter, place: Place) -> None:
        width, height = _LEGEND_PX
        line = painter.fontMetrics().height()
        # In the lower left corner, where no message covers the legend.
        top = place.viewport.bottom() - _MARGIN_PX - (self.row + 1) * (height + 2.5 * line + 12.0)
        box = QRectF(place.viewport.left() + _MARGIN_PX, top + line + 8.0, width, height)
        plate = box.adjusted(-8.0, -line - 8.0, 8.0, line + 8.0)
        glyphs.ground(painter, plate, 4)
        first, count = self.ramp
        values = np.linspace(first * self._top, self._top, count)
        scale = self.shades(values[None], self._top)
        scale[..., 3] = 255
        painter.drawImage(box, qt_image(scale))
        painter.setPen(QPen(glyphs.HALO))
        names, left = self.captions(self._top), Qt.AlignmentFlag.AlignLeft
        painter.drawText(plate.adjusted(8, 2, -8, 0), left | Qt.AlignmentFlag.AlignTop, names[0])
        below = plate.adjusted(8, 0, -8, -2)
        bottom = Qt.AlignmentFlag.AlignBottom
        sides = (left, Qt.AlignmentFlag.AlignHCenter, Qt.AlignmentFlag.AlignRight)
        for side, text in zip(sides, names[1:], strict=True):
            painter.drawText(below, side | bottom, text)

    def measure(self, frame: RenderedFrame, xs: Array, ys: Array) -> Array:
        """Return values at px of the rendering, shape (len(ys), len(xs))."""
        raise NotImplementedError

    def shades(self, values: Array, top: float) -> Rgb8:
        """Return RGBA colours for values up to `top`, shape (..., 4)."""
        raise NotImplementedError

    def captions(self, top: float) -> tuple[str, str, str, str]:
        """Return the title of the legend and the labels at the left, middle and right."""
        raise NotImplementedError


class HeatMap(_Map):
    """Length of the displacement, px of the photo."""

    name = "heat"
    title = Text("Heat map of the move")
    height = 10
    key = "H"
    colours = "inferno"
    ramp = (0.0, 64)

    def measure(self, frame: RenderedFrame, xs: Array, ys: Array) -> Array:
        displacement = frame.rendering.field.on_grid(xs, ys)
        return np.asarray(np.hypot(displacement[0], displacement[1]) * frame.scale)

    def shades(self, values: Array, top: float) -> Rgb8:
        """Return inferno's colours; opacity increases with the displacement."""
        share = np.clip(values / top, 0.0, 1.0)
        return _coloured(self.colours, _DARKEST + (1.0 - _DARKEST) * share, np.cbrt(share))

    def captions(self, top: float) -> tuple[str, str, str, str]:
        return (tr("moved by"), "0", f"{top / 2:g}", tr("{px:g} px", px=top))


class JacobianMap(_Map):
    """det J of the inverse map: the photo is stretched below 1, compressed above 1, folded at 0."""

    name = "jacobian"
    title = Text("Jacobian map")
    height = 20
    key = "K"
    colours = "CET-D1"
    ramp = (-1.0, 65)  # down to a determinant below 0, a fold
    row = 1

    def measure(self, frame: RenderedFrame, xs: Array, ys: Array) -> Array:
        """Return det J - 1: 0 without a change of area."""
        return frame.rendering.field.det_jacobian(xs, ys) - 1.0

    def shades(self, values: Array, top: float) -> Rgb8:
        """Return blue for stretched, red for compressed, and the fold colour for folds."""
        share = np.clip(values / top, -1.0, 1.0)
        shades = _coloured(self.colours, (share + 1.0) / 2.0, np.sqrt(np.abs(share)))
        shades[values <= -1.0] = _FOLD
        return shades

    def captions(self, top: float) -> tuple[str, str, str, str]:
        left = f"{1 - top:g}" if top < 1.0 else tr("folds")
        return (tr("det J: stretched, pressed"), left, "1", f"{1 + top:g}")


def _coloured(name: str, share: Array, strength: Array) -> Rgb8:
    shades = pg.colormap.get(name).map(share.ravel(), mode="byte")
    shades = np.asarray(shades).reshape(*share.shape, -1)
    alpha = np.round(255.0 * _STRONGEST * strength).astype(np.uint8)
    return np.ascontiguousarray(np.dstack([shades[..., :3], alpha]))


def _middles(start: float, length: float) -> Array:
    """Return sample centres: one sample for `_SMOOTH_PX` of the length."""
    count = max(1, round(length / _SMOOTH_PX))
    return np.asarray(start + (np.arange(count) + 0.5) * length / count)


def _nice(value: float) -> float:
    """Return the smallest round number at or above `value`, so that the scale rarely changes."""
    if value < 1e-3:
        return 1e-3
    power = 10.0 ** np.floor(np.log10(value))
    return float(next(n * power for n in _NICE if n * power >= 0.999 * value))
