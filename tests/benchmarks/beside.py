"""What ExifTool, an independent reader, finds beside a picture before and after: silent losses.

For each file of ``tests/beside.py`` the tags are counted that ExifTool sees in it but not in the
same picture without the thing, how many of them a changed photo of the same format still has, and
whether a note names the rest. Needs the program ``exiftool``. Ends with 1 at a silent loss.
"""

from __future__ import annotations

import argparse
import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

import beside

from kogao_core import photo

_PLAIN = {
    ".jpg": beside.jpeg(),
    ".png": beside.png(),
    ".tif": beside.tiff(),
    ".webp": beside.webp(),
}
# Of the file system, of how pixels are stored, and the thumbnail, which goes without a word.
_STORAGE = ("System", "ExifTool", "File:", "IFD1")


def main() -> int:
    """Print a line for each file, and how many losses nobody was told of."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=_Formatter)
    parser.add_argument("--json", action="store_true", help="print JSON")
    options = parser.parse_args()
    if shutil.which("exiftool") is None:
        parser.error("the program exiftool isn't there; install it first")
    with tempfile.TemporaryDirectory() as folder:
        lines = [_tried(case, Path(folder)) for case in beside.CASES]
    if options.json:
        print(json.dumps(lines))
    else:
        for line in lines:
            print("{case:24} {suffix:5} {seen:3} seen, {left:3} left   {note}".format(**line))
    silent = [line["case"] for line in lines if line["left"] < line["seen"] and not line["said"]]
    print(f"{len(lines)} files, {len(silent)} silent losses {' '.join(silent)}", file=sys.stderr)
    return int(bool(silent))


class _Formatter(argparse.RawDescriptionHelpFormatter):
    pass


def _tried(case: beside.Case, folder: Path) -> dict[str, object]:
    source, out = folder / f"in{case.suffix}", folder / f"out{case.suffix}"
    plain = folder / f"plain{case.suffix}"
    plain.write_bytes(_PLAIN[case.suffix])
    source.write_bytes(case.data)
    read = photo.read(source)
    note = photo.write(read, read.pixels // 2, out, force=True)
    seen = _tags(source) - _tags(plain)
    return {
        "case": case.label,
        "suffix": case.suffix,
        "seen": len(seen),
        "left": len(seen & _tags(out)),
        "said": "not kept" in note or "has moved" in note,
        "note": note.partition("; 0.0 %")[0],
    }


def _tags(path: Path) -> set[str]:
    """Return group and name of all tags but those of storage, numbered where one is repeated."""
    command = ["exiftool", "-j", "-G1:4", "-a", "-u", "-U", "-ee", "-struct", str(path)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    (found,) = json.loads(done.stdout)
    keys = {key for key in found if not key.startswith(_STORAGE) and key != "SourceFile"}
    return keys | ({"File:Comment"} & found.keys())


if __name__ == "__main__":
    sys.exit(main())
