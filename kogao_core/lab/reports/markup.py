"""Elements of HTML and SVG. Whatever text they are given stays text: the serializer escapes it."""

from __future__ import annotations

from typing import Final
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

_DIGITS: Final = 1  # decimals of a number: coordinates, px


def element(tag: str, *content: Element | str, **attributes: str | float) -> Element:
    """Return an element."""
    named = {name.strip("_").replace("_", "-"): _text(v) for name, v in attributes.items()}
    made = Element(tag, {name: value for name, value in named.items() if value})
    for part in content:
        if isinstance(part, Element):
            made.append(part)
        elif len(made):
            made[-1].tail = (made[-1].tail or "") + part
        else:
            made.text = (made.text or "") + part
    return made


def html(root: Element) -> str:
    """Return an element and all it holds as HTML."""
    return ElementTree.tostring(root, encoding="unicode", method="html")


def _text(value: str | float) -> str:
    return value if isinstance(value, str) else f"{round(value, _DIGITS):g}"
