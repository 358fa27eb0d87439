"""What the plug-ins for GIMP 3 and 2.10 say and do alike: entries, and a file's way and back."""

import os
import subprocess
import tempfile
from pathlib import Path

from kogao_outside import (
    BY_ITSELF,
    CANCELLED,
    EDIT_TITLE,
    EDITOR,
    SHARED,
    SMALLER_TITLE,
    THEIRS,
    cannot_start,
    layer_name,
)

BY_AMOUNT = "kogao-by-itself"
COMMANDS = {"kogao-edit": (EDIT_TITLE, EDITOR), BY_AMOUNT: (SMALLER_TITLE, BY_ITSELF)}
MENU = "<Image>/Filters/Distorts/"
IMAGE_TYPES = "RGB*, GRAY*"
DOCUMENTATION = "Make faces smaller", "The result is a new layer."
ATTRIBUTION = "Kogao", "Kogao", "2026"


class Cancelled(Exception):
    """Nothing was saved."""


class Failed(Exception):
    """There is no result; the text says why."""


def send(name, file, save, lay, percent=None):
    """Have a picture worked on.

    Parameters
    ----------
    name : str
        Which of `COMMANDS`.
    file : str or None
        Where the picture was read, if anywhere: the editor shows and messages tell its name.
    save, lay : callable
        Write the picture to a path; take the result from there, and what its layer is called.
    percent : float, optional
        The amount that was asked for.

    Raises
    ------
    Cancelled, Failed
        Nothing was laid.
    """
    if os.name == "posix":
        os.setpgid(0, 0)  # GIMP's Cancel ends a plug-in, with all of its group if it has one
    with tempfile.TemporaryDirectory(prefix="kogao-", dir=SHARED) as folder:
        path = str(Path(folder, f"{Path(file or 'picture').stem}.tif"))
        save(path)
        command = [*COMMANDS[name][1], *([] if percent is None else ["--percent", f"{percent:g}"])]
        surroundings = {key: value for key, value in os.environ.items() if key not in THEIRS}
        try:
            done = subprocess.run(
                [*command, path], env=surroundings, capture_output=True, encoding="utf-8",
                errors="replace",
            )  # fmt: skip
        except OSError as problem:
            raise Failed(cannot_start(command[0], "gimp")) from problem
        if done.returncode == CANCELLED:
            raise Cancelled
        if done.returncode:
            said = done.stderr.strip().replace(f"{folder}{os.sep}", "")
            raise Failed(said or f"Kogao ended with {done.returncode}.")
        lay(path, layer_name(done.stdout))
