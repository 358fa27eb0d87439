"""Small SVG charts; lines differ by marks, dashes and words, not only by colour.

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
_LABELS, _BARS_END = 172, 380  # bar charts: right end of the names, and of the longest bar
_BAR_PX: Final = 12
_GAP_PX: Final = 10
_MOST_TICKS: Final = 6  # more tick labels would overlap
_DIGITS: Final = 1  # decimals of a coordinate, px
_LEAST: Final = 1e-3  # smaller values are written as < 0.001


@dataclass(frozen=True, slots=True)
class Series:
    """One curve, or one kind of bar."""

    name: str  # name in the legend
    values: Sequence[float]  # one per place; NaN and infinity leave a gap
    # Lower and upper ends for each value, drawn as error bars.
    intervals: Sequence[tuple[float, float]] = ()


@dataclass(frozen=True, slots=True)
class Chart:
    """A line chart over evenly spaced places, or a bar chart."""

    title: str  # read by screen readers, with the values
    places: Sequence[str]  # names of the places
    unit: str  # name and unit of the values; the axis begins at 0
    series: Sequence[Series]  # at most a handful
    along: str = ""  # label of the x axis with its unit; for curves only
    bars: bool = False  # draw bars
    logarithmic: bool = False  # markers on an axis of powers of ten instead of bars
    caption: str = ""  # text below the chart
    # Minimum end of the value axis, to compare charts side by side.
    most: float = 0.0


def svg(chart: Chart) -> Element:
    """Draw a chart."""
    drawn, height = (_bars if chart.bars else _curves)(chart)
    return element(
        "svg",
        *drawn,
        *_key(chart, height),
        role="img",
        aria_label=f"{chart.title}. {_in_words(chart)}",
        viewBox=f"0 0 {WIDTH} {height + _KEY_PX * len(chart.series)}",
        width=str(WIDTH),
        height=str(height + _KEY_PX * len(chart.series)),
    )


def _curves(chart: Chart) -> tuple[list[Element], int]:
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
            drawn.append(_whisker([(x + dodge, y(low)), (x + dodge, y(high))], number))
    return drawn, HEIGHT


def _bars(chart: Chart) -> tuple[list[Element], int]:
    values = [value for value in _finite(chart) if value > 0.0] or [1.0]
    group = _BAR_PX * len(chart.series) + _GAP_PX
    floor = _TOP + group * len(chart.places)
    if chart.logarithmic:
        low, high = math.floor(math.log10(0.8 * min(values))), math.ceil(math.log10(max(values)))
        ticks = [10.0**power for power in range(low, max(high, low + 1) + 1)]
    else:
        top, step = _scale(max(values))
        ticks = [step * number for number in range(round(top / step) + 1)]

    def x(value: float) -> float:
        first, last = ticks[0], ticks[-1]
        if chart.logarithmic:
            share = math.log(max(value, first) / first) / math.log(last / first)
        else:
            share = value / last
        return _LABELS + (_BARS_END - _LABELS) * share

    drawn = [_text(_LABELS, 18, chart.unit, class_="name")]
    for number, tick in enumerate(ticks):
        drawn.append(element("path", class_="rule", d=f"M{x(tick):.1f} {_TOP}V{floor}"))
        if number % (1 + len(ticks) // _MOST_TICKS) == 0:
            drawn.append(_text(x(tick), floor + 16, f"{tick:g}", "middle", class_="soft"))
    for place, name in enumerate(chart.places):
        beginning = _TOP + group * place + _GAP_PX / 2
        drawn.append(_text(_LABELS - 8, beginning + group / 2 - 1, name, "end"))
        for number, series in enumerate(chart.series):
            value, y = series.values[place], beginning + _BAR_PX * number
            if not math.isfinite(value):
                continue
            drawn.append(_bar(chart, x(value), y, number))
            ends = [x(end) for end in series.intervals[place]] if series.intervals else []
            if ends:
                middle = y + _BAR_PX / 2
                drawn.append(_whisker([(end, middle) for end in ends], number))
            drawn.append(_text(max([x(value), *ends]) + 6, y + 10, _short(value), class_="value"))
    drawn.append(element("path", class_="axis", d=f"M{_LABELS} {_TOP}V{floor}"))
    return drawn, floor + 30


def _bar(chart: Chart, end: float, y: float, number: int) -> Element:
    if chart.logarithmic:  # the length of a bar would mean nothing
        return _mark(end, y + _BAR_PX / 2, number, f"mark c{number % _COLOURS}")
    return element(
        "rect", class_=f"bar c{number % _COLOURS} b{number % 2}",
        x=_LABELS, y=y + 1, width=max(1.0, end - _LABELS), height=_BAR_PX - 2.0,
    )  # fmt: skip


def _key(chart: Chart, top: int) -> Iterator[Element]:
    for number, series in enumerate(chart.series):
        y = top + 6 + _KEY_PX * number
        if chart.bars:
            place = f"translate({_LEFT + 4 - _LABELS} {y - _BAR_PX / 2:g})"
            yield element("g", _bar(chart, _LABELS + 30, 0, number), transform=place)
        else:
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
        yield _mark(x, y, number, f"mark {colour}")


def _whisker(ends: Sequence[tuple[float, float]], number: int) -> Element:
    """Draw an error bar with caps."""
    (x, y), (u, v) = ends
    across = "m-3 0h6" if x == u else "m0 -3v6"
    path = f"M{x:.1f} {y:.1f}L{u:.1f} {v:.1f}" + "".join(
        f"M{a:.1f} {b:.1f}{across}" for a, b in ends
    )
    return element("path", class_=f"whisker c{number % _COLOURS}", d=path)


def _mark(x: float, y: float, number: int, look: str) -> Element:
    shape = number % 4
    if shape == 0:
        return element("circle", class_=look, cx=x, cy=y, r=3.5)
    outline = ("m-3.5 -3.5h7v7h-7z", "m0 -4.5l4.5 8h-9z", "m0 -4.8l4.8 4.8l-4.8 4.8l-4.8 -4.8z")[
        shape - 1
    ]
    return element("path", class_=look, d=f"M{x:.1f} {y:.1f}{outline}")


def _short(value: float) -> str:
    return f"< {_LEAST:g}" if 0.0 < value < _LEAST else rounded(value)


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
            f"{place} {_short(value)}"
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
