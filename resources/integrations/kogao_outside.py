"""Start Kogao from the plug-ins for GIMP and Krita, on a temporary file that Kogao overwrites.

`kogao-cli integrate` copies this file next to each plug-in and fills in programs and texts.
"""

import json
import os

# A Flatpak starts Kogao outside of its sandbox. Other programs can't see the sandbox's /tmp, but
# its cache is an ordinary folder.
SANDBOXED = "FLATPAK_ID" in os.environ
LAUNCHER = ["flatpak-spawn", "--host"] if SANDBOXED else []
TEMPORARY = os.environ.get("XDG_CACHE_HOME") if SANDBOXED else None
EDITOR = [*LAUNCHER, "@KOGAO@", "--edit", "--temporary"]
SMALLER = [*LAUNCHER, "@KOGAO_CLI@", "warp", "--in-place", "--temporary", "--json", "-"]
NO_FACE_CODE, CANCELLED = 4, 6  # exit codes
# The host's settings for its own Python and libraries; other programs must not get these.
HOST_VARIABLES = ("PYTHONHOME", "PYTHONPATH", "LD_LIBRARY_PATH")

LAYER = "Kogao"
AMOUNT = float("@AMOUNT@")
LARGEST = 15.0
EDIT_TITLE = "@EDIT@"
SMALLER_TITLE = "@SMALLER@"
AMOUNT_LABEL = "@AMOUNT_LABEL@"
CLOSED = "@CLOSED@"
NO_FACE = "@NO_FACE@"
RESULT = "@RESULT@"
CANNOT_START = "@CANNOT_START@"


def is_result(layer):
    """Return whether a layer of this name is a result of Kogao."""
    return layer.startswith(LAYER)


def layer_name(output):
    """Return the name of the new layer from the output of `warp`; the editor has no output."""
    try:
        report = json.loads(output)
        amount, faces = report["recipe"]["percent"], len(report["faces"])
    except (ValueError, KeyError, TypeError):
        return LAYER
    return RESULT.format(amount=f"{amount:g}", faces=faces)


def problem(code, errors, path, picture):
    """Return the message for an exit code, with the picture's name instead of the file's path."""
    if code == NO_FACE_CODE:
        return NO_FACE
    last = (errors.strip() or f"Kogao: {code}").splitlines()[-1]
    return last.removeprefix("kogao-cli: ").replace(path, picture)


def cannot_start(program, host):
    """Return the message if Kogao can't be started."""
    return CANNOT_START.format(program=program, command=f"kogao-cli integrate {host}")
