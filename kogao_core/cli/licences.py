"""``kogao-cli licenses``: the licences of the program, its dependencies and its assets."""

from __future__ import annotations

import json
from importlib import metadata
from types import SimpleNamespace
from typing import Any, Final

import click

import kogao_core
from kogao_core.base import assets
from kogao_core.base.language import Text, tr, translated

OWN: Final = "Apache-2.0"
# The dependencies in pyproject.toml, and their own. A test compares both.
DEPENDENCIES: Final = (
    "click",
    "jpeglib",
    "numpy",
    "opencv-contrib-python-headless",
    "Pillow",
    "pyqtgraph",
    "PySide6-Essentials",
    "threadpoolctl",
)
_INDIRECT: Final = ("shiboken6", "colorama")
_UNNAMED: Final = Text("see its documentation")


def run(_: SimpleNamespace) -> None:
    """Print the licences."""
    click.echo(text())


def text() -> str:
    """Return the licences of the program, its dependencies and its assets as text."""
    lines = [f"Kogao {kogao_core.__version__}: {OWN}", "", tr("Dependencies")]
    lines += [f"  {_dependency(name)}" for name in (*DEPENDENCIES, *_INDIRECT)]
    lines += ["", tr("Assets")]
    for asset in manifest():
        wheel = asset["wheel"]
        lines.append(f"  {asset['file']}: {asset['licence']}; {asset['from']}")
        lines.append(
            tr(
                "    {what}; taken from {project} {version} ({licence})",
                what=asset["what"],
                project=wheel["project"],
                version=wheel["version"],
                licence=wheel["licence"],
            )
        )
    return "\n".join([*lines, *map(_attribution, ("models", "samples"))])


def manifest() -> list[dict[str, Any]]:
    """Return the entries of the asset manifest; empty if the manifest isn't installed."""
    try:
        stored = assets.path("assets.json").read_text(encoding="utf-8")
    except assets.AssetMissing:
        return []
    entries: list[dict[str, Any]] = json.loads(stored)["assets"]
    return entries


def _dependency(name: str) -> str:
    try:
        about = metadata.metadata(name)
    except metadata.PackageNotFoundError:
        return tr("{name}: not installed", name=name)
    return f"{about['Name']} {about['Version']}: {_licence(about)}"


def _licence(about: metadata.PackageMetadata) -> str:
    for field in (
        "License-Expression",
        "License",
    ):
        for stated in about.get_all(field) or []:
            if stated.strip():
                return str(stated).strip().splitlines()[0]
    classifiers = about.get_all("Classifier") or []
    names = [line.rsplit(" :: ", 1)[-1] for line in classifiers if line.startswith("License ::")]
    return ", ".join(names) or translated(_UNNAMED)


def _attribution(folder: str) -> str:
    try:
        return "\n" + assets.path(f"{folder}/ATTRIBUTION.md").read_text(encoding="utf-8").strip()
    except assets.AssetMissing:
        return tr("\nNo {folder} in this installation.", folder=folder)
