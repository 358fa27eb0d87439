"""Pictures for `landmarks.py`: cumulative error curves, and sheets of the worst faces."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import cv2
import matplotlib as mpl
import numpy as np
from kogao_resources.training.evaluate import share_below
from matplotlib import pyplot

from kogao_core.base.geometry import Array, Image

if TYPE_CHECKING:
    from landmarks import Outcome

KINDS = ("eyes", "mouth", "jaw")
VIEWS = ("studio", "wild frontal", "wild turned")
LIMITS = np.linspace(0.0, 10.0, 501)
TILE_PX = 400
COLUMNS, ROWS = 4, 3
LABEL, HIDDEN, RESULT = (60, 255, 60), (255, 160, 0), (255, 60, 255)  # RGB


def draw(results: Mapping[str, list[Outcome]], folder: Path) -> None:
    """Write ``curves.png``, and ``worst-SOURCE-SET.png`` for studio and wild faces."""
    folder.mkdir(parents=True, exist_ok=True)
    curves(results, folder / "curves.png")
    for source, outcomes in results.items():
        for name in ("studio", "wild"):
            group = [one for one in outcomes if name in one.sample.sets]
            worst = sorted(group, key=_badness, reverse=True)[: COLUMNS * ROWS]
            path = folder / f"worst-{source}-{name}.png"
            cv2.imwrite(str(path), cv2.cvtColor(sheet(worst), cv2.COLOR_RGB2BGR))


def curves(results: Mapping[str, list[Outcome]], path: Path) -> None:
    """Draw the share of faces whose error stays below a limit; missed faces never do."""
    mpl.use("Agg")
    figure, axes = pyplot.subplots(1, len(KINDS), figsize=(12.0, 4.0), sharey=True, dpi=110)
    for axis, kind in zip(axes, KINDS, strict=True):
        for style, (source, outcomes) in zip(("-", "--", ":"), results.items(), strict=False):
            for color, view in enumerate(VIEWS):
                values = [_value(one, kind) for one in outcomes if view in one.sample.sets]
                axis.plot(
                    LIMITS,
                    share_below(values, LIMITS) * 100.0,
                    style,
                    color=f"C{color}",
                    label=f"{source}, {view}",
                )
        axis.set(title=kind, xlabel="% of the outer inter-ocular distance", xlim=(0, 10))
        axis.grid(alpha=0.3)
    axes[0].set(ylabel="faces with a smaller error, %", ylim=(0, 101))
    axes[-1].legend(loc="lower right", fontsize=8)
    figure.tight_layout()
    figure.savefig(path)
    pyplot.close(figure)


def sheet(outcomes: Sequence[Outcome]) -> Image:
    """Return tiles of faces with their labels in green, hidden ones orange, the result magenta."""
    blank = np.zeros((TILE_PX, TILE_PX, 3), np.uint8)
    tiles = [_tile(one) for one in outcomes] + [blank] * (COLUMNS * ROWS - len(outcomes))
    rows = [np.hstack(tiles[start : start + COLUMNS]) for start in range(0, len(tiles), COLUMNS)]
    return np.vstack(rows)


def _value(outcome: Outcome, kind: str) -> float:
    value = getattr(outcome.errors, kind)
    return np.inf if outcome.face is None else value


def _badness(outcome: Outcome) -> float:
    return _value(outcome, "jaw")


def _tile(outcome: Outcome) -> Image:
    labels = outcome.sample.labels
    points = np.vstack([labels.eyes, labels.mouth, labels.jaw])
    low, high = points.min(axis=0), points.max(axis=0)
    scale = TILE_PX / (1.3 * float((high - low).max()))
    shift = TILE_PX / 2.0 - scale * (low + high) / 2.0
    matrix = np.array([[scale, 0.0, shift[0]], [0.0, scale, shift[1]]])
    pixels = cv2.warpAffine(outcome.sample.read(), matrix, (TILE_PX, TILE_PX), flags=cv2.INTER_AREA)
    seen = np.ones(len(points), bool) if labels.seen is None else labels.seen
    _line(pixels, labels.jaw * scale + shift, LABEL)
    for point, visible in zip(points * scale + shift, seen, strict=True):
        cv2.circle(pixels, _whole(point), 3, LABEL if visible else HIDDEN, -1, cv2.LINE_AA)
    if outcome.face is not None:
        _line(pixels, outcome.face.outline * scale + shift, RESULT)
        for point in outcome.face.points * scale + shift:
            cv2.circle(pixels, _whole(point), 2, RESULT, -1, cv2.LINE_AA)
    text = "{}  {:.1f} / {:.1f} / {:.1f}".format(outcome.sample.name, *outcome.errors)
    for thickness, color in ((3, (0, 0, 0)), (1, (255, 255, 255))):
        cv2.putText(pixels, text, (6, 16), cv2.FONT_HERSHEY_SIMPLEX, 0.45, color, thickness)
    return pixels


def _line(pixels: Image, points: Array, color: tuple[int, int, int]) -> None:
    cv2.polylines(pixels, [np.round(points).astype(np.int32)], False, color, 1, cv2.LINE_AA)


def _whole(point: Array) -> tuple[int, int]:
    return round(float(point[0])), round(float(point[1]))
