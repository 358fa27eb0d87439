"""Menu entries of the plug-ins for GIMP 3 and 2.10, and the exchange of files with Kogao."""

import os
import subprocess
import tempfile
from pathlib import Path

from kogao_outside import (
    CANCELLED,
    EDIT_TITLE,
    EDITOR,
    HOST_VARIABLES,
    SMALLER,
    SMALLER_TITLE,
    TEMPORARY,
    cannot_start,
    layer_name,
    problem,
)

SMALLER_NAME = "kogao-smaller"
COMMANDS = {"kogao-edit": (EDIT_TITLE, EDITOR), SMALLER_NAME: (SMALLER_TITLE, SMALLER)}
MASK_OPTIONS = {"kogao-edit": "--mask", SMALLER_NAME: "--protect"}
MENU = "<Image>/Filters/Distorts/"
IMAGE_TYPES = "RGB*, GRAY*"
DOCUMENTATION = "Make faces smaller", "The result is a new layer."
ATTRIBUTION = "Kogao", "Kogao", "2026"


class Cancelled(Exception):
    """The user cancelled."""


class Failed(Exception):
    """Kogao failed; the text is the message."""


def send(name, file, save, add_layer, amount=None, save_selection=None):
    """Send a picture to Kogao and add the result as a layer.

    Parameters
    ----------
    name : str
        Which of `COMMANDS`.
    file : str or None
        File of the picture, if any: the editor and messages show its name.
    save, add_layer : callable
        Write the picture to a path; add a layer from a path, with a name.
    amount : float, optional
        Amount, %.
    save_selection : callable, optional
        Write the selection to a path as a mask; return False without a selection.

    Raises
    ------
    Cancelled, Failed
        No layer was added.
    """
    if os.name == "posix":
        os.setpgid(0, 0)  # GIMP's Cancel ends the plug-in with its process group
    with tempfile.TemporaryDirectory(prefix="kogao-", dir=TEMPORARY) as folder:
        path = str(Path(folder, f"{Path(file or 'picture').stem}.tif"))
        save(path)
        command = [*COMMANDS[name][1], *([] if amount is None else ["--amount", f"{amount:g}"])]
        mask = str(Path(folder, "selection", "mask.tif"))
        Path(mask).parent.mkdir()
        if save_selection is not None and save_selection(mask):
            command += [MASK_OPTIONS[name], mask]
        variables = {key: value for key, value in os.environ.items() if key not in HOST_VARIABLES}
        try:
            ended = subprocess.run(
                [*command, path], env=variables, capture_output=True, encoding="utf-8",
                errors="replace",
            )  # fmt: skip
        except OSError as error:
            raise Failed(cannot_start(command[0], "gimp")) from error
        if ended.returncode == CANCELLED:
            raise Cancelled
        if ended.returncode:
            picture = Path(file or "picture").name
            raise Failed(problem(ended.returncode, ended.stderr, path, picture))
        add_layer(path, layer_name(ended.stdout))
