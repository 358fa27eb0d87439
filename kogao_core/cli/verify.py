"""``kogao-cli verify``: what differs between a result and its original, block by block.

By a reader of its own: nothing that writes photos is asked, and the blocks are read by libjpeg 6b.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, Final

import click
import numpy as np
import numpy.typing as npt

from kogao_core.base.language import Text, tr, translated
from kogao_core.base.stderr import hushed
from kogao_core.cli import common, ending, words

try:
    import jpeglib
except ImportError:
    jpeglib = None

_START, _SCAN, _END = b"\xff\xd8", 0xDA, 0xD9
_MARKER: Final = re.compile(rb"\xff+([^\x00\xff\xd0-\xd7])")  # the next one, restarts left out
_NAMED: Final = {*range(0xE0, 0xF0), 0xFE}  # APP0 to APP15, COM; all others code the picture
_TITLE: Final = re.compile(rb"[\w:/. -]{3,40}")
_LIBRARY: Final = "6b"
_BLOCK_PX: Final = 8
_FILE: Final = click.Path(path_type=Path, readable=False)


@words.command("verify")
@click.argument("result", metavar="RESULT", type=_FILE)
@click.argument("original", metavar="ORIGINAL", type=_FILE)
@common.writes_json
@common.forces
def command(result: Path, original: Path, json_file: Path | None, force: bool) -> None:
    """Tell which blocks and which metadata of two JPEGs differ, and that nothing else does."""
    common.check_report(json_file, force)
    paths = result, original
    found = _beside(*map(_read, paths)) | _differing(*map(_blocks, paths))
    common.deliver(lambda: found, lambda: _told(found), json_file)


def _read(path: Path) -> bytes:
    with ending.refusing(lambda reason: Text("{path} can't be read ({reason})", path=path,
                                             reason=reason)):  # fmt: skip
        data = path.read_bytes()
    if not data.startswith(_START):
        raise ending.Stop(Text("{path} is no JPEG; name two JPEGs to compare", path=path))
    return data


def _beside(result: bytes, original: bytes) -> dict[str, Any]:
    """Return whether two files are the same, and which of their parts beside the picture aren't."""
    mine, theirs = _parts(result), _parts(original)
    return {
        "same_file": result == original,
        "metadata": [
            {"name": name, "bytes": sum(map(len, mine.get(name, []))),
             "original_bytes": sum(map(len, theirs.get(name, [])))}
            for name in dict.fromkeys([*theirs, *mine])
            if mine.get(name) != theirs.get(name)
        ],
    }  # fmt: skip


def _parts(data: bytes) -> dict[str, list[bytes]]:
    """Return all of a file that doesn't code its picture, by name."""
    parts: dict[str, list[bytes]] = {}
    at = len(_START)
    while (marker := _MARKER.search(data, at)) is not None:
        code, at = marker[1][0], marker.end()
        if code == _END:
            break
        size = max(2, int.from_bytes(data[at : at + 2], "big"))
        if code in _NAMED:
            body = data[at + 2 : at + size]
            title = _TITLE.match(body) if code != 0xFE else None
            app = "COM" if code == 0xFE else f"APP{code - 0xE0}"
            name = app if title is None else f"{app} {title[0].decode('latin-1')}"
            parts.setdefault(name, []).append(body)
        at += size
    rest = data[at:]
    return parts | ({"behind the picture": [rest]} if rest else {})


def _blocks(path: Path) -> tuple[list[npt.NDArray[np.int16]], list[tuple[int, int]], bytes, Any]:
    """Return each component's blocks, (rows, columns, 64), factors, tables, and the size in px."""
    if jpeglib is None:
        raise ending.Stop(
            Text("this bundle has no second reader of JPEGs; verify with an installation by pip"),
            ending.BROKEN,
        )
    try:
        with hushed(), jpeglib.version(_LIBRARY):
            jpeg = jpeglib.read_dct(str(path))
            jpeg.load()
    except Exception as error:  # it raises almost anything
        raise ending.Stop(
            Text("the blocks of {path} can't be read; open it in another program", path=path),
            ending.UNREADABLE,
        ) from error
    planes = [one for one in (jpeg.Y, jpeg.Cb, jpeg.Cr, jpeg.K) if one is not None]
    factors = [(1, 1)] if len(planes) == 1 else [tuple(one) for one in jpeg.samp_factor.tolist()]
    used = [jpeg.qt[number].tobytes() for number in jpeg.quant_tbl_no[: len(planes)]]
    flat = [one.reshape(*one.shape[:2], -1) for one in planes]
    return flat, factors, b"".join(used), (jpeg.width, jpeg.height)


def _differing(mine: Any, theirs: Any) -> dict[str, Any]:
    """Return how many units there are and differ, and where; nothing, if they can't be compared."""
    (planes, factors, tables, size), (others, their_factors, their_tables, their_size) = (
        mine,
        theirs,
    )
    same = {"size": size == their_size, "subsampling": factors == their_factors,
            "tables": tables == their_tables}  # fmt: skip
    found: dict[str, Any] = {"same": same, "units": None, "changed_units": None, "box_px": None}
    if not all(same.values()):
        return found
    down, along = (max(axis) for axis in zip(*factors, strict=True))
    changed = np.zeros(
        (-(-size[1] // (down * _BLOCK_PX)), -(-size[0] // (along * _BLOCK_PX))), bool
    )
    for plane, other, (high, wide) in zip(planes, others, factors, strict=True):
        rows, columns = np.nonzero((plane != other).any(axis=2))
        changed[rows // high, columns // wide] = True
    found |= {"units": changed.size, "changed_units": int(changed.sum())}
    if changed.any():
        (top, bottom), (left, right) = (
            (int(one.min()), int(one.max()) + 1) for one in np.nonzero(changed)
        )
        wide, high = along * _BLOCK_PX, down * _BLOCK_PX
        found["box_px"] = [left * wide, top * high, min(right * wide, size[0]),
                           min(bottom * high, size[1])]  # fmt: skip
    return found


def _told(found: dict[str, Any]) -> str:
    if found["same_file"]:
        return tr("The two files are the same, byte for byte.")
    return " ".join(map(translated, [_told_of_blocks(found), _told_of_metadata(found)]))


def _told_of_blocks(found: dict[str, Any]) -> Text:
    if found["units"] is None:
        names = {"size": Text("size"), "subsampling": Text("chroma subsampling"),
                 "tables": Text("quantisation tables")}  # fmt: skip
        others = [names[name] for name, is_same in found["same"].items() if not is_same]
        return Text("No block can be compared: they have another {names}.",
                    names=Text.joined(", ", others))  # fmt: skip
    if not found["changed_units"]:
        return Text("All {units:,} units of blocks are the same, bit for bit.",
                    units=found["units"])  # fmt: skip
    return Text(
        "{same:,} of {units:,} units of blocks are the same, bit for bit; the others lie from "
        "{left}, {top} to {right}, {bottom} px.",
        same=found["units"] - found["changed_units"], units=found["units"],
        **dict(zip(("left", "top", "right", "bottom"), found["box_px"], strict=True)),
    )  # fmt: skip


def _told_of_metadata(found: dict[str, Any]) -> Text:
    if not found["metadata"]:
        return Text("Nothing else differs but how the blocks are coded.")
    names = [
        f"{one['name']} ({one['original_bytes']:,} → {one['bytes']:,} B)"
        for one in found["metadata"]
    ]
    return Text("Beside them differ {names}, and nothing else but how the blocks are coded.",
                names=", ".join(names))  # fmt: skip
