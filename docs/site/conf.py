"""The pages as a site: ``sphinx-build -W -c docs/site . OUT``, with the extra [docs]."""

from __future__ import annotations

import inspect
import shutil
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING

import kogao_core

if TYPE_CHECKING:
    from sphinx.application import Sphinx

project = "Kogao"
author = "The Kogao founders"
project_copyright = f"2026, {author}"
version = release = metadata.version("kogao")

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
root_doc = "README"
include_patterns = ["*.md", "docs/*.md", "docs/**/*.md", "resources/samples/*.md"]
exclude_patterns = [".*", "tests", "resources/training", "resources/packaging"]
myst_heading_anchors = 4
myst_enable_extensions = ["attrs_inline"]
autodoc_typehints = "none"  # the docstrings tell, with units
napoleon_google_docstring = False

html_theme = "furo"
html_title = f"Kogao {release}"
html_favicon = str(Path(__file__).parents[2] / "resources/desktop/org.kogao.Kogao.svg")
html_logo = html_favicon
html_show_sourcelink = False

USE = (
    "docs/gallery",
    "docs/install",
    "docs/editor",
    "docs/lens",
    "docs/command-line",
    "docs/hosts",
    "docs/fidelity",
)
LIBRARY = ("docs/python", "docs/api", "docs/interchange")
MEASURED = ("docs/experiments", "docs/study", "docs/landmarks", "docs/engine")
JAPANESE = (
    "README.ja",
    "docs/ja/gallery",
    "docs/ja/editor",
    "docs/ja/lens",
    "docs/ja/command-line",
    "docs/japanese",
)
WITHIN = (
    *("docs/decisions/README", "ARCHITECTURE", "docs/glossary", "docs/extending"),
    *("CONTRIBUTING", "CHANGELOG"),
)
FACES = ("docs/pictures/ATTRIBUTION", "resources/samples/ATTRIBUTION")
CHAPTERS = {
    "Using it": USE,
    "日本語": JAPANESE,
    "As a library": LIBRARY,
    "Experiments": MEASURED,
    "Inside": WITHIN + FACES,
}


def setup(app: Sphinx) -> None:
    """Have what pages lack on the site added when they are read, and a page to begin with."""
    app.connect("source-read", _complete)
    app.connect("build-finished", _begin)


def _begin(app: Sphinx, problem: Exception | None) -> None:
    if problem is None:
        shutil.copy(app.outdir / f"{root_doc}.html", app.outdir / "index.html")


def _complete(_: Sphinx, page: str, text: list[str]) -> None:
    if page == "README":
        text[0] += "".join(_tree(pages, title) for title, pages in CHAPTERS.items())
    elif page == "docs/decisions/README":
        folder = Path(__file__).parents[1] / "decisions"
        text[0] += _tree(sorted(one.stem for one in folder.glob("[0-9]*.md")))
    elif page == "docs/landmarks":
        folder = Path(__file__).parents[1] / "models"
        text[0] += _tree(sorted(f"models/{one.stem}" for one in folder.glob("*.md")))
    elif page == "docs/api":
        text[0] += "".join(map(_documented, kogao_core.__all__))


def _tree(pages: tuple[str, ...] | list[str], caption: str = "") -> str:
    options = f":caption: {caption}\n" if caption else ""
    return "\n\n```{toctree}\n:hidden:\n" + options + "\n" + "\n".join(pages) + "\n```\n"


def _documented(name: str) -> str:
    found = getattr(kogao_core, name)
    if inspect.isclass(found):
        kind = "autoexception" if issubclass(found, Exception) else "autoclass"
    else:
        kind = "autofunction" if inspect.isroutine(found) else "autodata"
    members = "   :members:\n" if kind == "autoclass" else ""
    return f"\n\n## {name}\n\n```{{eval-rst}}\n.. {kind}:: kogao_core.{name}\n{members}```\n"
