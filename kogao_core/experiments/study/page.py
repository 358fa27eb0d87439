"""The rating session as one HTML file: no server, no outside request, no label."""

from __future__ import annotations

import base64
import hashlib
import json
from importlib import resources

from kogao_core import __version__
from kogao_core.experiments.study import results
from kogao_core.experiments.study.plan import Study


def page(study: Study) -> str:
    """Return the page, to lie in the folder of the pictures that it shows.

    Its content security policy allows its own script and style by their digests and pictures from
    its own folder, and nothing else: no request can leave for anywhere.
    """
    style, script = _part("page.css"), _part("page.js")
    script = script.replace('"STUDY"', _data(study))
    policy = (
        f"default-src 'none'; img-src 'self' file: data:; script-src {_digest(script)}; "
        f"style-src {_digest(style)}; base-uri 'none'; form-action 'none'"
    )
    filled = {"POLICY": policy, "STYLE": style, "SCRIPT": script}
    text = _part("page.html")
    for name, value in filled.items():
        text = text.replace(f"<!--{name}-->", value)
    return text


def _data(study: Study) -> str:
    head = results.header(study.identity, "", "page")
    content = {**study.to_dict(), "header": head, "program": __version__}
    return json.dumps(content).replace("<", "\\u003c")


def _part(name: str) -> str:
    return resources.files(__package__).joinpath(name).read_text(encoding="utf-8")


def _digest(text: str) -> str:
    return "'sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode() + "'"
