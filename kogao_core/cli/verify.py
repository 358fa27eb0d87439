"""``kogao-cli verify``: compare a result with its original, block by block.

This module shares no code with the writer: libjpeg 6b reads the blocks.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Final

import jpeglib
import numpy as np
import numpy.typing as npt

from kogao_core.base.installed import is_bundle
from kogao_core.base.language import Text, tr, translated
from kogao_core.base.stderr import hushed
from kogao_core.cli import common, ending

_START, _END = b"\xff\xd8", 0xD9
_APP0, _COMMENT = 0xE0, 0xFE
_FRAMES: Final = {*range(0xC0, 0xD0)} - {0xC4, 0xC8, 0xCC}
_MARKER: Final = re.compile(rb"\xff+([^\x00\xff\xd0-\xd7])")  # the next one, restarts left out
_NAMED: Final = {*range(_APP0, 0xF0), _COMMENT}  # APP0 to APP15, COM; the others code pixels
_TITLE: Final = re.compile(rb"[\w:/. -]{3,40}")
_LIBRARY: Final = "6b"
_BLOCK_PX: Final = 8


def run(args: SimpleNamespace) -> int:
    """Run the command."""
    common.check_report(args.json_file, args.force)
    found = _compare_files(*map(_read, (args.result, args.original)))
    if not found["same_file"]:
        found |= _compare_blocks(*map(_blocks, (args.result, args.original)))
    common.deliver(lambda: found, lambda: _described(found), args.json_file)
    is_only_picture = found["same_file"] or (all(found["same"].values()) and not found["metadata"])
    return 0 if is_only_picture else ending.BROKEN


def _read(path: Path) -> bytes:
    with ending.refusing(lambda reason: Text("{path} can't be read ({reason})", path=path,
                                             reason=reason)):  # fmt: skip
        data = path.read_bytes()
    if not data.startswith(_START):
        raise ending.Stop(Text("{path} is no JPEG; name two JPEGs to compare", path=path))
    return data


def _compare_files(result: bytes, original: bytes) -> dict[str, Any]:
    """Return whether two files are the same, and which metadata differ."""
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


def _segments(data: bytes) -> Iterator[tuple[int, bytes]]:
    """Yield marker and body of each segment. The body of the end marker is the appended data."""
    at = len(_START)
    while (marker := _MARKER.search(data, at)) is not None:
        code, at = marker[1][0], marker.end()
        if code == _END:
            yield code, data[at:]
            return
        size = max(2, int.from_bytes(data[at : at + 2], "big"))
        yield code, data[at + 2 : at + size]
        at += size


def _parts(data: bytes) -> dict[str, list[bytes]]:
    """Return the metadata segments of a file, and the appended data, by name."""
    parts: dict[str, list[bytes]] = {}
    for code, body in _segments(data):
        name = {_COMMENT: "COM", _END: "appended data"}.get(code, f"APP{code - _APP0}")
        title = _TITLE.match(body) if _APP0 <= code < _COMMENT else None
        if title is not None:
            name += f" {title[0].decode('latin-1')}"
        if code in _NAMED or (code == _END and body):
            parts.setdefault(name, []).append(body)
    return parts


def _blocks(path: Path) -> tuple[list[npt.NDArray[np.int16]], dict[str, Any]]:
    """Return the blocks of each component, shape (rows, columns, 64), and facts of the frame."""
    if is_bundle():
        text = Text("this bundle has no second reader of JPEGs; install Kogao by pip to verify")
        raise ending.Stop(text, ending.BROKEN)
    try:
        with hushed(), jpeglib.version(_LIBRARY):
            jpeg = jpeglib.read_dct(str(path))
            jpeg.load()
    except Exception as error:  # it raises almost anything
        text = Text("the blocks of {path} can't be read; open it in another program", path=path)
        raise ending.Stop(text, ending.UNREADABLE) from error
    planes = [one for one in (jpeg.Y, jpeg.Cb, jpeg.Cr, jpeg.K) if one is not None]
    used = jpeg.quant_tbl_no[: len(planes)]
    return [one.reshape(*one.shape[:2], -1) for one in planes], {
        "size": (jpeg.width, jpeg.height),
        "subsampling": [(1, 1)] if len(planes) == 1 else jpeg.samp_factor.tolist(),
        "tables": [jpeg.qt[number].tolist() for number in used],
        **_frame(path.read_bytes()),
    }


def _frame(data: bytes) -> dict[str, Any]:
    """Return the type of the frame and the identifiers of the components.

    Decoders guess the colours from the identifiers.
    """
    code, body = next((one for one in _segments(data) if one[0] in _FRAMES), (min(_FRAMES), b""))
    return {"frame": f"SOF{code - min(_FRAMES)}", "components": list(body[6::3])}


def _compare_blocks(mine: Any, theirs: Any) -> dict[str, Any]:
    """Return the number and place of units of blocks that differ; None if incomparable."""
    (planes, frame), (others, other_frame) = mine, theirs
    frames = [other_frame.pop("frame"), frame.pop("frame")]
    same = {name: value == other_frame[name] for name, value in frame.items()}
    found: dict[str, Any] = {
        "same": same, "frames": frames, "units": None, "changed_units": None, "box_px": None,
    }  # fmt: skip
    if not all(same.values()):
        return found
    (width, height), factors = frame["size"], frame["subsampling"]
    down, along = (_BLOCK_PX * max(axis) for axis in zip(*factors, strict=True))
    changed = np.zeros((-(-height // down), -(-width // along)), bool)
    for plane, other, (high, wide) in zip(planes, others, factors, strict=True):
        rows, columns = np.nonzero((plane != other).any(axis=2))
        changed[rows // high, columns // wide] = True
    found |= {"units": changed.size, "changed_units": int(changed.sum())}
    if changed.any():
        (top, bottom), (left, right) = ((int(one.min()), int(one.max()) + 1)
                                        for one in np.nonzero(changed))  # fmt: skip
        found["box_px"] = [left * along, top * down,
                           min(right * along, width), min(bottom * down, height)]  # fmt: skip
    return found


def _described(found: dict[str, Any]) -> str:
    if found["same_file"]:
        return tr("The two files are the same, byte for byte.")
    said = [_blocks_described(found), _metadata_described(found)]
    before, after = found["frames"]
    if before != after:
        said.append(Text("The frame type changed: {before} → {after}.", before=before, after=after))
    return " ".join(map(translated, said))


def _blocks_described(found: dict[str, Any]) -> Text:
    if found["units"] is None:
        names = {"size": Text("size"), "subsampling": Text("chroma subsampling"),
                 "tables": Text("quantisation tables"),
                 "components": Text("colour components")}  # fmt: skip
        others = [names[name] for name, is_same in found["same"].items() if not is_same]
        return Text("The blocks can't be compared. Different: {names}.",
                    names=Text.joined(", ", others))  # fmt: skip
    units, changed, box = found["units"], found["changed_units"], found["box_px"]
    if not changed:
        return Text("All {units:,} units of blocks are the same, bit for bit.", units=units)
    sides = dict(zip(("left", "top", "right", "bottom"), box, strict=True))
    return Text("{same:,} of {units:,} units of blocks are the same, bit for bit; the others lie "
                "from {left}, {top} to {right}, {bottom} px.",
                same=units - changed, units=units, **sides)  # fmt: skip


def _metadata_described(found: dict[str, Any]) -> Text:
    if not found["metadata"]:
        return Text("The metadata are the same.")
    names = [f"{one['name']} ({one['original_bytes']:,} → {one['bytes']:,} B)"
             for one in found["metadata"]]  # fmt: skip
    return Text("Different metadata: {names}.", names=", ".join(names))
