"""Small SVG charts; lines differ by dashes and words, not only by colour.

The serializer escapes all text of SVG and HTML elements.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final
from xml.etree.ElementTree import Element

from kogao_core.lab.reports.spread import rounded

WIDTH: Final = 440
HEIGHT: Final = 280
_LEFT, _END, _TOP, _FLOOR = 62, 424, 34, 230  # area inside the axes
_DASHES: Final = ("", "7 4", "2 4", "10 4 2 4")
_COLOURS: Final = 6
_KEY_PX: Final = 17  # height of a legend line
_DODGE_PX: Final = 5.0  # offset between markers with intervals at one place
_DIGITS: Final = 1  # decimals of a coordinate, px


@dataclass(frozen=True, slots=True)
class Series:
    """One curve."""

    name: str  # name in the legend
    values: Sequence[float]  # one per place; NaN and infinity leave a gap
    # Lower and upper ends for each value, drawn as error bars.
    intervals: Sequence[tuple[float, float]] = ()


@dataclass(frozen=True, slots=True)
class Chart:
    """A line chart over evenly spaced places."""

    title: str  # read by screen readers, with the values
    places: Sequence[str]  # names of the places
    unit: str  # name and unit of the values; the axis begins at 0
    series: Sequence[Series]  # at most a handful
    along: str  # label of the x axis with its unit
    caption: str  # text below the chart
    # Minimum end of the value axis, to compare charts side by side.
    most: float = 0.0


def svg(chart: Chart) -> Element:
    """Draw a chart."""
    height = HEIGHT + _KEY_PX * len(chart.series)
    return element(
        "svg",
        *_axes_and_curves(chart),
        *_key(chart),
        role="img",
        aria_label=f"{chart.title}. {_in_words(chart)}",
        viewBox=f"0 0 {WIDTH} {height}",
        width=str(WIDTH),
        height=str(height),
    )


def _axes_and_curves(chart: Chart) -> list[Element]:
    top, step = _scale(max([*_finite(chart), chart.most], default=1.0))
    drawn = [_text(_LEFT, 18, chart.unit, class_="name")]

    def y(value: float) -> float:
        return _FLOOR - (_FLOOR - _TOP) * value / top

    for number in range(round(top / step) + 1):
        at = y(number * step)
        drawn.append(element("path", class_="rule", d=f"M{_LEFT} {at:.1f}H{_END}"))
        drawn.append(_text(_LEFT - 8, at + 4, f"{number * step:g}", "end", class_="soft"))
    drawn.append(element("path", class_="axis", d=f"M{_LEFT} {_TOP}V{_FLOOR}H{_END}"))
    middles = [
        _LEFT + (_END - _LEFT) * (place + 0.5) / len(chart.places)
        for place in range(len(chart.places))
    ]
    for x, name in zip(middles, chart.places, strict=True):
        drawn.append(_text(x, _FLOOR + 18, name, "middle", class_="soft"))
    drawn.append(_text((_LEFT + _END) / 2, _FLOOR + 38, chart.along, "middle", class_="soft"))
    for number, series in enumerate(chart.series):
        dodge = _DODGE_PX * (number - (len(chart.series) - 1) / 2) if series.intervals else 0.0
        drawn += _curve([
            (x + dodge, y(value))
            for x, value in zip(middles, series.values, strict=True) if math.isfinite(value)
        ], number)  # fmt: skip
        for x, (low, high) in zip(middles, series.intervals, strict=False):
            drawn.append(_whisker(x + dodge, y(low), y(high), number))
    return drawn


def _key(chart: Chart) -> Iterator[Element]:
    for number, series in enumerate(chart.series):
        y = HEIGHT + 6 + _KEY_PX * number
        yield from _curve([(_LEFT + 4, y), (_LEFT + 34, y)], number)
        yield _text(_LEFT + 46, y + 4, series.name)


def _text(x: float, y: float, text: str, anchor: str = "", class_: str = "") -> Element:
    return element("text", text, x=x, y=y, text_anchor=anchor, class_=class_)


def _curve(points: Sequence[tuple[float, float]], number: int) -> Iterator[Element]:
    colour = f"c{number % _COLOURS}"
    path = "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in points) if points else "M0 0"
    dash = _DASHES[number % len(_DASHES)]
    yield element("path", class_=f"line {colour}", stroke_dasharray=dash, d=path)
    for x, y in points:
        yield element("circle", class_=f"mark {colour}", cx=x, cy=y, r=3.5)


def _whisker(x: float, low: float, high: float, number: int) -> Element:
    """Draw an error bar with caps."""
    path = f"M{x:.1f} {low:.1f}L{x:.1f} {high:.1f}"
    path += "".join(f"M{x:.1f} {y:.1f}m-3 0h6" for y in (low, high))
    return element("path", class_=f"whisker c{number % _COLOURS}", d=path)


def _finite(chart: Chart) -> list[float]:
    """Return all values and ends of intervals."""
    values = [value for series in chart.series for value in series.values]
    ends = [end for series in chart.series for both in series.intervals for end in both]
    return [value for value in (*values, *ends) if math.isfinite(value)]


def _scale(largest: float) -> tuple[float, float]:
    """Return the end of the axis and the distance of the grid lines, a round number."""
    if largest <= 0.0:
        return 1.0, 0.5
    rough = largest / 4.0
    power = 10.0 ** math.floor(math.log10(rough))
    step = next(factor * power for factor in (1.0, 2.0, 2.5, 5.0, 10.0) if factor * power >= rough)
    return step * math.ceil(largest / step - 1e-9), step


def _in_words(chart: Chart) -> str:
    """Return all values as text, for screen readers."""
    return "; ".join(
        f"{series.name}: "
        + ", ".join(
            f"{place} {rounded(value)}"
            for place, value in zip(chart.places, series.values, strict=True)
            if math.isfinite(value)
        )
        for series in chart.series
    )


# -- elements --------------------------------------------------------------------------------------


def element(tag: str, *content: Element | str, **attributes: str | float) -> Element:
    """Return an element."""
    named = {name.strip("_").replace("_", "-"): _told(v) for name, v in attributes.items()}
    made = Element(tag, {name: value for name, value in named.items() if value})
    for part in content:
        if isinstance(part, Element):
            made.append(part)
        elif len(made):
            made[-1].tail = (made[-1].tail or "") + part
        else:
            made.text = (made.text or "") + part
    return made


def _told(value: str | float) -> str:
    return value if isinstance(value, str) else f"{round(value, _DIGITS):g}"
