"""Web pages as one HTML file, for the study's raters and for the person in a photo."""

from __future__ import annotations

import base64
import hashlib
import html
from collections.abc import Mapping
from importlib import resources
from typing import Final

from kogao_core.base.language import Text, language, translated

SURROUND: Final = "#b8b8b8"
"""Grey around every picture: the surround changes the perceived colours of a face."""


def filled(
    package: str, page: str, script: str, texts: Mapping[str, Text], markup: Mapping[str, str]
) -> str:
    """Return a page of a package in the current language, with the head and style of all pages.

    The body is `page`.html, with more rules in `page`.css. Its placeholders are the names of texts
    and markup. The content security policy allows the page's script and style
    (by digest) and pictures of the folder; all other requests are blocked.
    """
    style = part(__package__, "page.css") + part(package, f"{page}.css")
    style = style.replace("SURROUND", SURROUND)
    policy = (
        f"default-src 'none'; img-src 'self' file: data:; script-src {_digest(script)}; "
        f"style-src {_digest(style)}; base-uri 'none'; form-action 'none'"
    )
    values = {"POLICY": policy, "STYLE": style, "SCRIPT": script, "LANGUAGE": language()}
    values |= {name: html.escape(translated(text)) for name, text in texts.items()}
    text = part(__package__, "page.html").replace("<!--BODY-->", part(package, f"{page}.html"))
    for name, value in {**values, **markup}.items():
        text = text.replace(f"<!--{name}-->", value)
    return text


def part(package: str, name: str) -> str:
    """Return a text file of a package."""
    return resources.files(package).joinpath(name).read_text(encoding="utf-8")


def _digest(text: str) -> str:
    return "'sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode() + "'"
