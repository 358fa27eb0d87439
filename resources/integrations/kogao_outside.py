"""How GIMP's and Krita's plug-ins start Kogao: as a program of its own, on a file it writes over.

`kogao-cli integrate` puts it beside each of them, and fills in where the programs lie, and words.
"""

import json
import os

# Within a Flatpak: out of its sandbox, whose /tmp others may not see; its cache is a usual folder.
SANDBOXED = "FLATPAK_ID" in os.environ
OUT = ["flatpak-spawn", "--host"] if SANDBOXED else []
SHARED = os.environ.get("XDG_CACHE_HOME") if SANDBOXED else None
EDITOR = [*OUT, "@KOGAO@", "--edit", "--temporary"]
BY_ITSELF = [*OUT, "@KOGAO_CLI@", "warp", "--in-place", "--temporary", "--json", "-"]
CANCELLED = 6
# What a host's packages set for their own Python and libraries would lead other programs astray.
THEIRS = ("PYTHONHOME", "PYTHONPATH", "LD_LIBRARY_PATH")

LAYER = "Kogao"
PERCENT = 4.0  # what is asked for first
LARGEST = 15.0
EDIT_TITLE = "@EDIT@"
SMALLER_TITLE = "@SMALLER@"
AMOUNT = "@AMOUNT@"
CLOSED = "@CLOSED@"
RESULT = "@RESULT@"
CANNOT_START = "@CANNOT_START@"


def is_ours(layer):
    """Whether a layer of this name is a result, which doesn't go out again."""
    return layer.startswith(LAYER)


def layer_name(said):
    """Return what a result is called, by what `warp` printed; the editor prints nothing."""
    try:
        done = json.loads(said)
        percent, faces = done["recipe"]["percent"], len(done["faces"])
    except (ValueError, KeyError, TypeError):
        return LAYER
    return RESULT.format(percent=f"{percent:g}", faces=faces)


def cannot_start(program, host):
    """Return what is said where a program isn't there."""
    return CANNOT_START.format(program=program, command=f"kogao-cli integrate {host}")
