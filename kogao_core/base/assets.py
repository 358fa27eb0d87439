"""Paths of packed files: network weights, models, sample pictures, documentation."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Final

from kogao_core.base.installed import again
from kogao_core.base.language import Text, TextError

_SAMPLE: Final = "samples/average.jpg"


class AssetMissing(TextError, RuntimeError):
    """A packed file is missing from this installation. The message tells how to get the file."""


def path(name: str) -> Path:
    """Return the path of a packed file. Raises AssetMissing."""
    file = _folder() / name
    if not file.is_file():
        raise AssetMissing(_how_to_get(name))
    return file


def documentation() -> Path:
    """Return the folder of this version's documentation, which contains ``editor.md``.

    Raises AssetMissing.
    """
    name = "docs"
    inside = _folder()
    # A wheel has the folder inside the resources, a checkout next to the resources.
    for folder in (inside / name, inside.parent / name):
        if (folder / "editor.md").is_file():
            return folder
    raise AssetMissing(_how_to_get(name))


def _folder() -> Path:
    try:
        resources = importlib.import_module("kogao_resources")
    except ModuleNotFoundError:
        raise AssetMissing(
            "Kogao runs from a checkout that isn't installed; run `pip install -e .` in its folder"
        ) from None
    return Path(resources.__path__[0])


def sample() -> Path:
    """Return the path of the built-in portrait, the average of 81 faces.

    Returns
    -------
    Path
        A JPEG of 900 x 900 px.

    Raises
    ------
    AssetMissing
        If the resources aren't installed.

    Examples
    --------
    >>> import kogao_core as kogao
    >>> kogao.sample().name
    'average.jpg'
    """
    return path(_SAMPLE)


def _how_to_get(name: str) -> str:
    if not name.endswith(".tflite"):
        return Text("{name} is not in this installation; reinstall Kogao", name=name)
    return Text(
        "the networks are not in this installation ({name} is missing). Reinstall with a network "
        "connection and without KOGAO_SKIP_ASSETS: {command}. Faces can still be placed by hand.",
        name=name,
        command=again("--no-deps"),
    )
