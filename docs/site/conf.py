"""The pages as a site: ``sphinx-build -W -c docs/site . OUT``, with the extra [docs]."""

from __future__ import annotations

import html
import re
import shutil
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sphinx.application import Sphinx

project = "Kogao"
author = "The Kogao founders"
project_copyright = f"2026, {author}"
version = release = metadata.version("kogao")

extensions = ["myst_parser"]
root_doc = "README"
include_patterns = ["*.md", "docs/*.md", "docs/**/*.md", "resources/samples/*.md"]
exclude_patterns = [".*", "tests", "resources/training", "resources/packaging"]
myst_heading_anchors = 4
myst_enable_extensions = ["attrs_inline"]

html_theme = "furo"
html_title = f"Kogao {release}"
html_favicon = str(Path(__file__).parents[2] / "resources/desktop/org.kogao.Kogao.svg")
html_logo = html_favicon
html_show_sourcelink = False
highlight_language = "none"

USE = (
    "docs/gallery",
    "docs/install",
    "docs/editor",
    "docs/inspect",
    "docs/keys",
    "docs/lens",
    "docs/read",
    "docs/command-line",
    "docs/hosts",
    "docs/fidelity",
    "docs/hdr",
    "docs/faq",
)
LIBRARY = ("docs/python", "docs/api", "docs/interchange")
MEASURED = ("docs/experiments", "docs/paper", "docs/slimming", "docs/study", "docs/measurements")
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
    *("CONTRIBUTING", "CHANGELOG", "docs/roadmap", "SECURITY", "CODE_OF_CONDUCT"),
)
FACES = ("docs/pictures/ATTRIBUTION", "resources/samples/ATTRIBUTION")
CHAPTERS = {
    "Using it": USE,
    "日本語": JAPANESE,
    "As a library": LIBRARY,
    "Experiments": MEASURED,
    "Inside": WITHIN + FACES,
}


LANDING = Path(__file__).parent / "landing"
PICTURES = Path(__file__).parents[1] / "pictures"
ON_LANDING = ("landing-before.jpg", "landing-after.jpg", "inspect.png", "lens.jpg")


def setup(app: Sphinx) -> None:
    """Add tables of contents, page languages, link previews and the landing page."""
    app.connect("source-read", _complete)
    app.connect("html-page-context", _describe)
    app.connect("build-finished", _add_landing_page)


def _describe(_: Sphinx, page: str, __: str, context: dict[str, Any], ___: object) -> None:
    """Set the language of Japanese pages, and a title and picture for link previews."""
    if page in JAPANESE:
        context["language"] = "ja"
    title = html.escape(re.sub("<.*?>", "", context.get("title", project)), quote=True)
    context["metatags"] = context.get("metatags", "") + (
        f'<meta property="og:title" content="{title}">'
        '<meta property="og:site_name" content="Kogao">'
        f'<meta property="og:image" content="{context["pathto"]("_static/landing-after.jpg", 1)}">'
    )


def _add_landing_page(app: Sphinx, problem: Exception | None) -> None:
    """Write index.html, with the README's commands and today's version filled in."""
    if problem is not None:
        return
    readme = (Path(__file__).parents[2] / "README.md").read_text(encoding="utf-8")
    commands = readme.partition("```sh\n")[2].partition("```")[0].strip()
    page = (LANDING / "index.html").read_text(encoding="utf-8")
    page = page.replace("@INSTALL@", html.escape(commands)).replace("@VERSION@", release)
    (app.outdir / "index.html").write_text(page, encoding="utf-8")
    files = [PICTURES / name for name in ON_LANDING]
    files += [*LANDING.glob("*.js"), *LANDING.glob("*.css")]
    for file in (*files, Path(html_favicon)):
        shutil.copy(file, app.outdir / "_static")


def _complete(_: Sphinx, page: str, text: list[str]) -> None:
    if page == "README":
        text[0] += "".join(_tree(pages, title) for title, pages in CHAPTERS.items())
    elif page == "docs/decisions/README":
        folder = Path(__file__).parents[1] / "decisions"
        text[0] += _tree(sorted(one.stem for one in folder.glob("[0-9]*.md")))
    elif page == "docs/measurements":
        folder = Path(__file__).parents[1] / "models"
        text[0] += _tree(sorted(f"models/{one.stem}" for one in folder.glob("*.md")))


def _tree(pages: tuple[str, ...] | list[str], caption: str = "") -> str:
    options = f":caption: {caption}\n" if caption else ""
    return "\n\n```{toctree}\n:hidden:\n" + options + "\n" + "\n".join(pages) + "\n```\n"
