"""Small line charts as SVG, told apart by marks and dashes as well as by colour."""

from __future__ import annotations

import html
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from kogao_core.experiments.report import Html

WIDTH: Final = 440
HEIGHT: Final = 280
_LEFT, _END, _TOP, _FLOOR = 62, 424, 34, 230  # the field inside the axes
_DASHES: Final = ("", "7 4", "2 4", "10 4 2 4")
_COLOURS: Final = 6
_KEY_PX: Final = 17  # a line of the key


@dataclass(frozen=True, slots=True)
class Line:
    """One curve.

    Parameters
    ----------
    name : str
        What the key calls it.
    y : sequence of float
        A value for each place along x; NaN and infinity leave a gap.
    """

    name: str
    y: Sequence[float]


@dataclass(frozen=True, slots=True)
class Axis:
    """A name with its unit, and the ticks that lie evenly along it, with their labels."""

    name: str
    ticks: Sequence[str] = ()


def line_chart(title: str, x: Axis, y_name: str, lines: Sequence[Line]) -> Html:
    """Draw curves over places that lie evenly along x, one for each of its ticks; y begins at 0.

    Parameters
    ----------
    title : str
        What it shows; read aloud in place of the picture, with the last values.
    x : Axis
        Name and labels of the places.
    y_name : str
        Name and unit of the values.
    lines : sequence of Line
        The curves, at most a handful.
    """
    finite = [value for line in lines for value in line.y if math.isfinite(value)]
    plot = _Plot(len(x.ticks), *_scale(max(finite, default=1.0)))
    parts = [_text(_LEFT, 18, y_name, extra='font-weight="600"'), plot.rules(), plot.axes(x)]
    for number, line in enumerate(lines):
        parts.append(_curve(plot.points(line.y), number))
        y = HEIGHT + 6 + _KEY_PX * number
        parts += [
            _curve([(_LEFT + 4, y), (_LEFT + 34, y)], number),
            _text(_LEFT + 46, y + 4, line.name),
        ]
    height = HEIGHT + _KEY_PX * len(lines)
    size = f'viewBox="0 0 {WIDTH} {height}" width="{WIDTH}" height="{height}"'
    said = html.escape(f"{title}. {_in_words(lines)}")
    return Html(f'<svg role="img" aria-label="{said}" {size}>{"".join(parts)}</svg>')


@dataclass(frozen=True, slots=True)
class _Plot:
    """The field of a chart: so many places along x, values from 0 to `top` in rules of `step`."""

    places: int
    top: float
    step: float

    def x(self, place: int) -> float:
        return _LEFT + (_END - _LEFT) * (place + 0.5) / self.places

    def y(self, value: float) -> float:
        return _FLOOR - (_FLOOR - _TOP) * value / self.top

    def points(self, values: Sequence[float]) -> list[tuple[float, float]]:
        return [(self.x(k), self.y(v)) for k, v in enumerate(values) if math.isfinite(v)]

    def rules(self) -> str:
        values = [n * self.step for n in range(round(self.top / self.step) + 1)]
        lines = "".join(f"M{_LEFT} {self.y(value):.1f}H{_END}" for value in values)
        labels = [_text(_LEFT - 8, self.y(v) + 4, f"{v:g}", "end", soft=True) for v in values]
        return f'<path class="rule" d="{lines}"/>' + "".join(labels)

    def axes(self, x: Axis) -> str:
        middle = (_LEFT + _END) / 2
        labels = [
            _text(self.x(k), _FLOOR + 18, tick, "middle", soft=True)
            for k, tick in enumerate(x.ticks)
        ]
        name = _text(middle, _FLOOR + 38, x.name, "middle", soft=True)
        return f'<path class="axis" d="M{_LEFT} {_TOP}V{_FLOOR}H{_END}"/>{"".join(labels)}{name}'


def _text(
    x: float, y: float, text: str, anchor: str = "start", *, soft: bool = False, extra: str = ""
) -> str:
    look = ' class="soft"' if soft else ""
    place = f'x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"'
    return f"<text{look} {place} {extra}>{html.escape(text)}</text>"


def _curve(points: Sequence[tuple[float, float]], number: int) -> str:
    dash = _DASHES[number % len(_DASHES)]
    style = f' stroke-dasharray="{dash}"' if dash else ""
    colour = f"c{number % _COLOURS}"
    path = "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in points) if points else ""
    marks = "".join(_mark(x, y, number, colour) for x, y in points)
    return f'<path class="line {colour}"{style} d="{path}"/>{marks}'


def _mark(x: float, y: float, number: int, colour: str) -> str:
    shape = number % 4
    if shape == 0:
        return f'<circle class="mark {colour}" cx="{x:.1f}" cy="{y:.1f}" r="3.5"/>'
    outline = (
        "m-3.5 -3.5h7v7h-7z",
        "m0 -4.5l4.5 8h-9z",
        "m0 -4.8l4.8 4.8l-4.8 4.8l-4.8 -4.8z",
    )[shape - 1]
    return f'<path class="mark {colour}" d="M{x:.1f} {y:.1f}{outline}"/>'


def _scale(largest: float) -> tuple[float, float]:
    """Return the end of the axis and the distance of its rules: a round number."""
    if largest <= 0.0:
        return 1.0, 0.5
    rough = largest / 4.0
    power = 10.0 ** math.floor(math.log10(rough))
    step = next(factor * power for factor in (1.0, 2.0, 2.5, 5.0, 10.0) if factor * power >= rough)
    return step * math.ceil(largest / step - 1e-9), step


def _in_words(lines: Sequence[Line]) -> str:
    ends = [f"{line.name}: from {line.y[0]:.3g} to {line.y[-1]:.3g}" for line in lines if line.y]
    return "; ".join(ends)
