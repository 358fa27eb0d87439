"""The rating session as one HTML file: no outside request, no label."""

from __future__ import annotations

import base64
import hashlib
import html
import json
from importlib import resources
from pathlib import Path

from PIL import Image as Pillow

from kogao_core.base.language import language, translated
from kogao_core.lab.study import results, words
from kogao_core.lab.study.conduct import SURROUND
from kogao_core.lab.study.plan import Study
from kogao_core.lab.study.quality import LEAST_MS
from kogao_core.lab.subjects import PAPER_SIZE


def page(study: Study, folder: Path, *, served: bool = False) -> str:
    """Return the page, to lie in the folder of the pictures that it shows.

    Its content security policy allows its own script and style by their digests and pictures from
    its own folder, and nothing else: no request can leave for anywhere. It speaks the language at
    work.
    """
    style = _part("page.css").replace("SURROUND", SURROUND)
    script = _part("page.js").replace('"STUDY"', _data(study, folder, served))
    reached = "connect-src 'self'; img-src 'self' data:" if served else "img-src 'self' file: data:"
    policy = (
        f"default-src 'none'; {reached}; script-src {_digest(script)}; "
        f"style-src {_digest(style)}; base-uri 'none'; form-action 'none'"
    )
    filled = {"POLICY": policy, "STYLE": style, "SCRIPT": script}
    filled |= {name: html.escape(translated(text)) for name, text in words.PAGE.items()}
    filled["LANGUAGE"] = language()
    text = _part("page.html")
    for name, value in filled.items():
        text = text.replace(f"<!--{name}-->", value)
    return text


def _data(study: Study, folder: Path, served: bool) -> str:
    content = {
        **study.to_dict(),
        "header": results.header(study, "", "page"),
        "box": _box(study, folder),
        "least_ms": LEAST_MS,
        "served": served,
        "words": {name: translated(text) for name, text in words.SCRIPT.items()},
    }
    return json.dumps(content).replace("<", "\\u003c")


def _box(study: Study, folder: Path) -> tuple[int, int]:
    """Return the width and height, px, that every picture fits in."""
    sizes = []
    for name in (*study.ratings, *study.satisfaction, *study.practice):
        try:
            with Pillow.open(folder / name) as picture:
                sizes.append(picture.size)
        except OSError:
            continue  # the page says so when that picture's turn comes
    wide, high = zip(*(sizes or [PAPER_SIZE]), strict=True)
    return max(wide), max(high)


def _part(name: str) -> str:
    return resources.files(__package__).joinpath(name).read_text(encoding="utf-8")


def _digest(text: str) -> str:
    return "'sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode() + "'"
