"""Fill in the project's addresses in all metadata files before a release.

``python -m resources.addresses SOURCE SITE DATE`` with the addresses of the repository and of the
built site (docs/site), and the day of the release. Run again for each release or new address.
"""

from __future__ import annotations

import re
import sys
from datetime import date
from pathlib import Path
from xml.sax.saxutils import escape

import kogao_core

ROOT = Path(__file__).resolve().parents[1]
SHOWN = {  # pictures of docs/pictures with captions, in the order of the site
    "window": "Make the faces in a photo smaller with one slider",
    "inspect": "See landmarks, targets and control lattice",
    "compare": "Compare before and after with a wipe and a loupe",
}


def write(root: Path, source: str, site: str, released: date) -> None:
    """Fill in `pyproject.toml` and the AppStream metadata below a root."""
    source, site = source.rstrip("/"), site.rstrip("/")
    project = root / "pyproject.toml"
    text = project.read_text(encoding="utf-8")
    urls = {
        "Homepage": f"{site}/",
        "Source": source,
        "Issues": f"{source}/issues",
        "Changelog": f"{site}/CHANGELOG.html",
    }
    table = "".join(f'{name} = "{url}"\n' for name, url in urls.items())
    text = re.sub(r"\[project\.urls\]\n(?:.+\n)*\n", "", text)
    text = text.replace("[project.scripts]", f"[project.urls]\n{table}\n[project.scripts]", 1)
    project.write_text(text, encoding="utf-8")
    metadata = root / "resources/desktop/org.kogao.Kogao.metainfo.xml"
    told = metadata.read_text(encoding="utf-8")
    told = re.sub(r"  <url .*\n|  <screenshots>\n(?:.*\n)*?  </screenshots>\n", "", told)
    told = re.sub(r"  <releases>\n(?:.*\n)*?  </releases>\n", "", told)
    added = _urls(urls, source) + _screenshots(site) + _releases(kogao_core.__version__, released)
    metadata.write_text(told.replace("</component>", f"{added}</component>"), encoding="utf-8")


def _urls(urls: dict[str, str], source: str) -> str:
    kinds = {"homepage": urls["Homepage"], "bugtracker": urls["Issues"], "vcs-browser": source}
    return "".join(f'  <url type="{kind}">{escape(url)}</url>\n' for kind, url in kinds.items())


def _screenshots(site: str) -> str:
    first, *rest = (
        f"      <caption>{caption}</caption>\n"
        f"      <image>{escape(site)}/_images/{name}.png</image>\n"
        for name, caption in SHOWN.items()
    )
    one = '    <screenshot type="default">\n' + first + "    </screenshot>\n"
    more = "".join(f"    <screenshot>\n{image}    </screenshot>\n" for image in rest)
    return f"  <screenshots>\n{one}{more}  </screenshots>\n"


def _releases(version: str, released: date) -> str:
    return f'  <releases>\n    <release version="{version}" date="{released}"/>\n  </releases>\n'


if __name__ == "__main__":
    write(ROOT, sys.argv[1], sys.argv[2], date.fromisoformat(sys.argv[3]))
