"""Damage what the editor opens: ``python tests/benchmarks/hostile_editor.py [--inputs N]``.

Photos, their projects, points, settings copied or kept by the editor and recovery files,
as ``hostile.py`` does it with the command line. The editor has no screen; nothing may appear on
stderr, where Python and Qt complain.
"""

from __future__ import annotations

import json
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import hostile
import hostile_texts
from damaging.trials import Trial, finish, options, run
from kogao_app.features import recent
from kogao_app.storage import Storage
from PySide6.QtCore import QByteArray

from kogao_core.recipe.recipe import Recipe

Rng = np.random.Generator
# Said by a window system that shows nothing; all else would be a complaint.
OFFSCREEN = ("This plugin does not support propagateSizeHints",)


def settings() -> bytes:
    """Return the settings of someone who has used the editor."""
    with tempfile.TemporaryDirectory() as folder:
        kept = Storage.in_folder(Path(folder)).settings()
        recent.add(kept, Path("photo.png"))
        for name in ("record", "label", "labelled", "welcomed"):
            kept.setValue(name, True)
        kept.setValue("window/geometry", QByteArray(b"\1\xd9\xd0\xcb\0\3\0\0" + bytes(60)))
        kept.setValue("window/docks", QByteArray(b"\0\0\0\xff\0\0\0\0" + bytes(60)))
        kept.sync()
        return Path(folder, "kogao.ini").read_bytes()


def photo_case(rng: Rng) -> tuple[list[str], dict[str, bytes]]:
    """Return a damaged photo to open."""
    kind, data = hostile.damaged(rng, [])
    name = "photo.dng" if kind == "dng" else "photo.jpg"
    return ["open", name], {name: data}


def sidecar_case(rng: Rng) -> tuple[list[str], dict[str, bytes]]:
    """Return a photo with a damaged project beside it."""
    files = {"photo.png.kogao.json": hostile_texts.damaged(hostile_texts.project(), rng)}
    return ["open", "photo.png"], files


def project_case(rng: Rng) -> tuple[list[str], dict[str, bytes]]:
    """Return a damaged project, which is itself opened."""
    return ["open", "photo.png.kogao.json"], sidecar_case(rng)[1]


def paste_case(rng: Rng) -> tuple[list[str], dict[str, bytes]]:
    """Return damaged settings on the clipboard."""
    recipe = json.dumps(Recipe(percent=5.0).to_dict()).encode()
    files = {"r.json": hostile_texts.damaged(recipe, rng)}
    return ["open", "photo.png", "paste", "r.json"], files


def settings_case(rng: Rng) -> tuple[list[str], dict[str, bytes]]:
    """Return an editor with damaged settings of its own."""
    return ["open", "photo.png"], {"home/kogao.ini": hostile_texts.damaged(settings(), rng)}


def recovery_case(rng: Rng) -> tuple[list[str], dict[str, bytes]]:
    """Return what a crash has left, damaged, to be restored."""
    files = {"home/recovery/0123.json": hostile_texts.damaged(hostile_texts.project(), rng)}
    return ["open", "photo.png", "restore", ""], files


MAKERS: dict[str, Callable[[Rng], tuple[list[str], dict[str, bytes]]]] = {
    "photo": photo_case,
    "sidecar": sidecar_case,
    "project": project_case,
    "paste": paste_case,
    "settings": settings_case,
    "recovery": recovery_case,
}


def case(rng: Rng, only: list[str]) -> Trial:
    """Return a visit of a kind; all are as likely."""
    names = only or list(MAKERS)
    kind = names[rng.integers(len(names))]
    steps, files = MAKERS[kind](rng)
    sound = {} if kind == "photo" else {"photo.png": hostile_texts.photo()}
    files = {**sound, **files}
    return Trial(kind, steps, files, own=("home/*", "*.kogao.json"), codes=(0, 3), lines=OFFSCREEN)


if __name__ == "__main__":
    chosen = options(__doc__, 800).parse_args()
    finish(run(lambda rng: case(rng, chosen.only), chosen, "damaging.editing"), chosen)
