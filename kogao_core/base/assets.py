"""Where the files that travel with the program lie: network weights, models, sample pictures."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Final

from kogao_core.base.installed import again
from kogao_core.base.language import Text

_SAMPLE: Final = "samples/average.jpg"


class AssetMissing(RuntimeError):
    """A file that this installation should carry isn't there; the message says how to get it."""


def path(name: str) -> Path:
    """Return where a packed file lies. Raises AssetMissing."""
    file = _folder() / name
    if not file.is_file():
        raise AssetMissing(_how_to_get(name))
    return file


def documentation() -> Path:
    """Return the folder of the pages that describe this version, with ``editor.md`` in it.

    Raises AssetMissing.
    """
    name = "docs"
    inside = _folder()
    # A wheel carries them; in a checkout they lie beside the resources.
    for folder in (inside / name, inside.parent / name):
        if (folder / "editor.md").is_file():
            return folder
    raise AssetMissing(_how_to_get(name))


def _folder() -> Path:
    try:
        resources = importlib.import_module("kogao_resources")
    except ModuleNotFoundError:
        raise AssetMissing(
            Text(
                "Kogao runs from a checkout that isn't installed; run `pip install "
                "-e .` in its folder"
            )
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
