"""How GIMP's and Krita's plug-ins start Kogao: as a program of its own, on a file it writes over.

`kogao-cli integrate` puts it beside each of them, and fills in where the programs lie.
"""

import os

# Within a Flatpak: out of its sandbox, whose /tmp others may not see; its cache is a usual folder.
SANDBOXED = "FLATPAK_ID" in os.environ
OUT = ["flatpak-spawn", "--host"] if SANDBOXED else []
SHARED = os.environ.get("XDG_CACHE_HOME") if SANDBOXED else None
EDITOR = [*OUT, "@KOGAO@", "--edit", "--temporary"]
BY_ITSELF = [*OUT, "@KOGAO_CLI@", "warp", "--in-place", "--temporary"]
CANCELLED = 6
# What a host's packages set for their own Python and libraries would lead other programs astray.
THEIRS = ("PYTHONHOME", "PYTHONPATH", "LD_LIBRARY_PATH")
