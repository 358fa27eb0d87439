"""One HTML file that holds an experiment: tables, pictures, charts, and how it was made.

The file asks nothing of the network: pictures are data URIs, and a content security policy
forbids the rest. Text is escaped here; callers hand in plain strings.
"""

from __future__ import annotations

import base64
import hashlib
import html
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Final, NewType

import cv2
import numpy as np

from kogao_core.experiments.machine import machine
from kogao_core.experiments.style import STYLE
from kogao_core.geometry import Image
from kogao_core.recipe import Recipe

Html = NewType("Html", str)
LONGEST_SIDE_PX: Final = 640
_JPEG_QUALITY: Final = 90
# A sign may stand before it; a dash stands for a number that is missing.
_NUMBER: Final = re.compile("[-+<>\u2212\u00b1\u2264\u2265\u00d7]?\\s?\\.?\\d|[\u2013\u2014]$")


@dataclass(frozen=True, slots=True)
class Table:
    """A table of ready text.

    Parameters
    ----------
    caption : str
        What it shows, with units.
    header : sequence of str
        Names of the columns.
    rows : sequence of sequences of str
        One string a column; the first names the row.
    note : str
        What the reader must know to read it; shown below.
    """

    caption: str
    header: Sequence[str]
    rows: Sequence[Sequence[str]]
    note: str = ""

    def __str__(self) -> str:
        """Return the table as text in columns."""
        lines = [self.header, *self.rows]
        widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
        numeric = [all(map(_is_number, column)) for column in zip(*self.rows, strict=True)]
        texts = []
        for line in lines:
            cells = zip(line, widths, numeric or [False] * len(widths), strict=True)
            texts.append(
                "  ".join(c.rjust(w) if right else c.ljust(w) for c, w, right in cells).rstrip()
            )
        return "\n".join([self.caption, *texts, *([self.note] if self.note else [])])


@dataclass(frozen=True, slots=True)
class Made:
    """How a report came to be.

    Parameters
    ----------
    command : str
        The command line, or what was chosen in the editor.
    at : datetime
        When, with its time zone.
    machine : mapping
        Processor, cores, system and versions (`kogao_core.experiments.machine`).
    left_out : tuple of str
        What was asked for but is missing, and why: photos without a face, absent libraries.
    """

    command: str
    at: datetime
    machine: Mapping[str, object]
    left_out: tuple[str, ...] = ()

    @staticmethod
    def now(command: str, left_out: Sequence[str] = ()) -> Made:
        """Return the record of a report made here and now."""
        return Made(command, datetime.now().astimezone(), machine(), tuple(left_out))

    def to_dict(self) -> dict[str, object]:
        """Return plain JSON values."""
        return {
            "command": self.command,
            "at": self.at.isoformat(timespec="seconds"),
            "machine": dict(self.machine),
            "left_out": list(self.left_out),
        }


def heading(text: str, level: int = 2) -> Html:
    """Return a heading; 2 opens a section, 3 a part of one."""
    return Html(f"<h{level}>{html.escape(text)}</h{level}>")


def paragraph(text: str) -> Html:
    """Return a paragraph."""
    return Html(f"<p>{html.escape(text)}</p>")


def listing(items: Sequence[str]) -> Html:
    """Return a list with a bullet for each item."""
    return Html("<ul>" + "".join(f"<li>{html.escape(item)}</li>" for item in items) + "</ul>")


def table(content: Table) -> Html:
    """Return a table with its caption, column and row headers, and its note."""
    columns = list(zip(*content.rows, strict=True))
    right = [bool(column) and all(map(_is_number, column)) for column in columns]
    right = right or [False] * len(content.header)
    head = "".join(
        f'<th scope="col"{_class(number)}>{html.escape(name)}</th>'
        for name, number in zip(content.header, right, strict=True)
    )
    body = "".join(f"<tr>{_cells(row, right)}</tr>" for row in content.rows)
    caption = html.escape(content.caption)
    note = f'<p class="note">{html.escape(content.note)}</p>' if content.note else ""
    return Html(
        f'<div><div class="scroll" tabindex="0" role="region" aria-label="{caption}"><table>'
        f"<caption>{caption}</caption><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>{note}</div>"
    )


def _cells(row: Sequence[str], right: Sequence[bool]) -> str:
    first = f'<th scope="row"{_class(right[0])}>{html.escape(row[0])}</th>'
    rest = zip(row[1:], right[1:], strict=True)
    return first + "".join(f"<td{_class(n)}>{html.escape(cell)}</td>" for cell, n in rest)


def _is_number(text: str) -> bool:
    return bool(_NUMBER.match(text))


def _class(number: bool) -> str:
    return ' class="number"' if number else ""


def picture(pixels: Image, caption: str, *, alt: str, exact: bool = False) -> Html:
    """Return a picture with its caption.

    Parameters
    ----------
    pixels : array of shape (H, W) or (H, W, 3)
        Grey or RGB, uint8; shown reduced to `LONGEST_SIDE_PX`.
    caption, alt : str
        Text below it; what it shows, for those who don't see it.
    exact : bool
        Keep the very pixels (PNG), for masks and maps; JPEG otherwise.
    """
    shown = reduced(pixels)
    source = f"data:image/{'png' if exact else 'jpeg'};base64,{_encoded(shown, exact)}"
    size = f'width="{shown.shape[1]}" height="{shown.shape[0]}"'
    image = f'<img src="{source}" alt="{html.escape(alt)}" {size}>'
    return _figure(image, caption)


def chart(svg: Html, caption: str) -> Html:
    """Return a chart (`kogao_core.experiments.charts`) with its caption."""
    return _figure(svg, caption)


def side_by_side(figures: Sequence[Html], *, wide: bool = False) -> Html:
    """Return figures in rows that break with the window; `wide` ones come two to a row."""
    return Html(f'<div class="row{" wide" if wide else ""}">{"".join(figures)}</div>')


def page(title: str, lead: str, blocks: Sequence[Html], made: Made) -> str:
    """Return the whole HTML file.

    Parameters
    ----------
    title, lead : str
        Heading, and what was asked, in a sentence or two.
    blocks : sequence of Html
        What this module's other functions return, in order.
    made : Made
        Command, time and machine; told at the end.
    """
    digest = base64.b64encode(hashlib.sha256(STYLE.encode()).digest()).decode()
    policy = f"default-src 'none'; img-src data:; style-src 'sha256-{digest}'; base-uri 'none'"
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{policy}">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        '<link rel="icon" href="data:,">\n'
        f"<title>{html.escape(title)}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<main>\n"
        f'<h1>{html.escape(title)}</h1>\n<p class="lead">{html.escape(lead)}</p>\n'
        + "\n".join(blocks)
        + "\n"
        + _told(made)
        + "\n</main>\n</body>\n</html>\n"
    )


def recipe_in_words(recipe: Recipe) -> str:
    """Return what decides a warp, such as "4 % of D towards centre 2, exact fit, ..."."""
    unit = "landmark spacings" if recipe.lattice_unit == "spacing" else "warp distances"
    return (
        f"{recipe.percent:g} % of D towards centre {recipe.center:g}, {recipe.fit} fit, lattice "
        f"R = {recipe.lattice:g} {unit}, {recipe.interpolation}"
    )


def reduced(pixels: Image, longest_px: int = LONGEST_SIDE_PX) -> Image:
    """Return a picture made smaller, if need be, to `longest_px` along its longer side."""
    shrink = longest_px / max(pixels.shape[:2])
    if shrink >= 1.0:
        return pixels
    size = [max(1, round(side * shrink)) for side in pixels.shape[1::-1]]
    return np.asarray(cv2.resize(pixels, size, interpolation=cv2.INTER_AREA))


def png(pixels: Image) -> bytes:
    """Return a grey or RGB picture as the bytes of a PNG file."""
    return _file(pixels, ".png")


def _file(pixels: Image, kind: str, *options: int) -> bytes:
    bgr = pixels if pixels.ndim == 2 else cv2.cvtColor(pixels, cv2.COLOR_RGB2BGR)
    _, data = cv2.imencode(kind, bgr, options)
    return data.tobytes()


def _encoded(pixels: Image, exact: bool) -> str:
    jpeg = cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY
    data = png(pixels) if exact else _file(pixels, ".jpg", *jpeg)
    return base64.b64encode(data).decode()


def _figure(content: str, caption: str) -> Html:
    return Html(f"<figure>{content}<figcaption>{html.escape(caption)}</figcaption></figure>")


def _told(made: Made) -> str:
    rows = [(name, str(value)) for name, value in made.machine.items() if name != "packages"]
    packages = made.machine.get("packages")
    if isinstance(packages, Mapping):
        rows += [(str(name), str(version)) for name, version in packages.items()]
    when = ("made", made.at.strftime("%Y-%m-%d %H:%M %Z"))
    record = Table("Machine and versions", ("what", "value"), [when, *rows])
    command = f"<pre>{html.escape(made.command)}</pre>"
    left_out = heading("Left out") + listing(made.left_out) if made.left_out else ""
    return left_out + heading("How this was made") + command + table(record)
