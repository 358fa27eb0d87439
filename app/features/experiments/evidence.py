"""Write the evidence of the current result, and compare evidence files."""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path
from typing import Final, Literal

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QPointF
from PySide6.QtWidgets import QWidget

from kogao_core.base.geometry import Array
from kogao_core.base.json_reader import BadFile
from kogao_core.pipeline import Rendering
from kogao_core.projects.evidence import Evidence, load
from kogao_core.projects.project import sha256_of

from ...actions import Item
from ...i18n import sentence, tr, unwritten
from ...theme import GRID_PX
from ...widgets.controls import ChoiceBox, column_of, muted_label, named, row_of
from ...widgets.dialogs import Dialog, ask_path
from ..feature import Context, Feature

Layer = Literal["displacement", "det", "domain"]
_SIZE_PX: Final = (1100, 560)
_SUFFIX: Final = ".npz"


class EvidenceFiles(Feature):
    """Writes an evidence file of the current result, and shows one file or two."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._writing = self.lane(self._show_written, self._fail)
        self.bind(
            Item(
                "experiment-evidence",
                "&Write evidence…",
                "Ctrl+Shift+N",
                "Save displacement, lattice and domains",
                photo=True,
            ),
            self._ask_where,
        )
        self.bind(
            Item(
                "experiment-compare-evidence",
                "Compare evidence…",
                "Ctrl+Alt+6",
                "Show evidence files and their difference",
            ),
            self._ask_files,
        )

    @property
    def _rendering(self) -> Rendering | None:
        """The full result of the newest state, or None."""
        frame = self.view.frame
        return frame.rendering if frame is not None and self.live.is_final(frame) else None

    def _ask_where(self) -> None:
        path, rendering = self.document.path, self._rendering
        if rendering is None or path is None:
            text = tr("The result is not complete yet. Try again in a moment.")
            self.say(text, applies=lambda: self._rendering is None)
            return
        ask_path(
            self.window, tr("Write evidence"), partial(self.write, rendering), "new",
            filters=[tr("Evidence (*.npz)")], endings=[_SUFFIX],
            at=path.with_name(f"{path.stem}-evidence{_SUFFIX}"),
        )  # fmt: skip

    def write(self, rendering: Rendering, path: Path) -> None:
        """Write the evidence file in the background."""
        photo = self.document.path
        self.window.bar.clear()

        def work() -> Path:
            sha256 = "" if photo is None else sha256_of(photo)
            rendering.save_evidence(path, sha256)
            return path

        self._writing.submit(work)

    def _show_written(self, path: Path) -> None:
        self.did.emit(tr("Evidence written to {name}", name=path.name))

    def _fail(self, problem: Exception) -> None:
        where = getattr(problem, "filename", None) or tr("The file")
        self.say(unwritten(where, problem) if isinstance(problem, OSError) else sentence(problem))

    def _ask_files(self) -> None:
        filters = [tr("Evidence (*.npz)")]
        ask_path(self.window, tr("Evidence A"), self._ask_second, filters=filters)

    def _ask_second(self, first: Path) -> None:
        title = tr("Evidence B; cancel to show A alone")
        taken: list[Path] = []

        def compare(second: Path) -> None:
            taken.append(second)
            self.compare(first, second)

        dialog = ask_path(self.window, title, compare, filters=[tr("Evidence (*.npz)")])
        dialog.rejected.connect(lambda: None if taken else self.compare(first))

    def compare(self, *paths: Path) -> None:
        """Show one file, or two files and their difference."""
        self.window.bar.clear()
        try:
            numbers = [load(path) for path in paths]
        except BadFile as problem:
            self.say(sentence(problem))
            return
        if len({one.size for one in numbers}) > 1:
            self.say(tr("These files belong to photos of different sizes."))
            return
        EvidenceDialog(self.window, [path.name for path in paths], numbers).open()


class EvidenceDialog(Dialog):
    """Shows A, B and A - B with linked views and cursors."""

    def __init__(self, parent: QWidget, names: list[str], numbers: list[Evidence]) -> None:
        super().__init__(tr("Evidence"), parent, _SIZE_PX)
        self._names, self._numbers = names, numbers
        self.layers = ChoiceBox()
        for name, title in (
            ("displacement", tr("Displacement, px")), ("det", "det J"),
            ("domain", tr("Domain: 0 image, 1 control points, 2 threshold")),
        ):  # fmt: skip
            self.layers.addItem(title, name)
        self.layers.currentIndexChanged.connect(self._show)
        # One line for each file, so that the dialog keeps the size.
        self.values = muted_label("\n" * len(numbers), wraps=True)
        self.images: list[pg.ImageItem] = []
        self._cursors: list[tuple[pg.InfiniteLine, pg.InfiniteLine]] = []
        graphics = pg.GraphicsLayoutWidget()
        graphics.setAccessibleName(tr("Evidence"))
        titles = [f"A: {names[0]}", *([f"B: {names[1]}", "A - B"] if len(numbers) > 1 else [])]
        for title in titles:
            self._add_pane(graphics, title)
        graphics.scene().sigMouseMoved.connect(self._follow)
        chosen = row_of(named(tr("&Layer"), self.layers), self.layers, None)
        content = chosen, graphics, self.values, self.closing()
        column_of(self, *content, margin=4 * GRID_PX, spacing=2 * GRID_PX)
        self._show()
        width, height = numbers[0].size
        for image in self.images:
            image.getViewBox().setRange(xRange=(0, width), yRange=(0, height), padding=0.0)

    def _add_pane(self, graphics: pg.GraphicsLayoutWidget, title: str) -> None:
        plot = graphics.addPlot(title=title)
        plot.setAspectLocked(True)
        plot.invertY(True)
        image = pg.ImageItem(axisOrder="row-major")
        image.setColorMap(pg.colormap.get("viridis"))
        plot.addItem(image)
        # Pixel centres are at whole numbers.
        image.setPos(-0.5, -0.5)
        lines = (pg.InfiniteLine(angle=90), pg.InfiniteLine(angle=0))
        for line in lines:
            plot.addItem(line, ignoreBounds=True)
        if self.images:
            first = self.images[0].getViewBox()
            plot.setXLink(first)
            plot.setYLink(first)
        self.images.append(image)
        self._cursors.append(lines)

    def _show(self) -> None:
        name: Layer = self.layers.currentData()
        shown = [layer(one, name) for one in self._numbers]
        low, high = min(one.min() for one in shown), max(one.max() for one in shown)
        if len(shown) > 1:
            shown.append(shown[0] - shown[1])
        for image, pixels in zip(self.images, shown, strict=True):
            image.setImage(pixels, levels=(low, max(high, low + 1e-6)))
        if len(shown) > 1:
            most = max(float(np.abs(shown[-1]).max()), 1e-6)
            self.images[-1].setLevels((-most, most))

    def _follow(self, place: QPointF) -> None:
        for image in self.images:
            box = image.getViewBox()
            if box.sceneBoundingRect().contains(place):
                at = box.mapSceneToView(place)
                self.point_at(at.x(), at.y())

    def point_at(self, x: float, y: float) -> None:
        """Move all cursors to a pixel and show the values there."""
        width, height = self._numbers[0].size
        column, row = math.floor(x + 0.5), math.floor(y + 0.5)
        if not (0 <= column < width and 0 <= row < height):
            return
        for vertical, horizontal in self._cursors:
            vertical.setPos(column)
            horizontal.setPos(row)
        lines = [
            f"{letter}: {values(one, column, row)}"
            for letter, one in zip("AB", self._numbers, strict=False)
        ]
        self.values.setText("\n".join(lines))


def layer(numbers: Evidence, name: Layer) -> Array:
    """Return one value for each pixel, shape (H, W)."""
    if name == "displacement":
        x, y = np.moveaxis(numbers.displacement_px, 2, 0)
        return np.asarray(np.hypot(x, y), np.float64)
    if name == "det":
        return numbers.det_j.astype(np.float64)
    masks = numbers.masks
    return masks["control-points"].astype(np.float64) + masks["threshold"]


def values(numbers: Evidence, column: int, row: int) -> str:
    """Return the numbers of one pixel as text."""
    dx, dy = numbers.displacement_px[row, column].tolist()
    cells = []
    for number, lattice in enumerate(numbers.lattices, start=1):
        if lattice.reaches(np.array([[column, row]], np.float64))[0]:
            i, _ = lattice.grid.locate(column, 0)
            j, _ = lattice.grid.locate(row, 1)
            cells.append(f"{number}: ({int(i)}, {int(j)})")
    return tr(
        "x {x}, y {y}; displacement {dx:.3f}, {dy:.3f} px; det J {det:.3f}; domain {domain}; "
        "cell of lattice {cells}",
        x=column,
        y=row,
        dx=dx,
        dy=dy,
        det=float(numbers.det_j[row, column]),
        domain=int(layer(numbers, "domain")[row, column]),
        cells=", ".join(cells) or "-",
    )
