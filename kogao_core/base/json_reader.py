"""Read untrusted JSON: each value is checked for type and range."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, NoReturn

from kogao_core.base.language import Text, TextError
from kogao_core.base.wording import shown, system_reason

# Control characters, and surrogates, which can't be encoded.
_UNPLAIN: Final = re.compile("[\x00-\x1f\ud800-\udfff]")


_FILE: Final = Text("the file")


class BadFile(TextError, ValueError):
    """A file has invalid content; the message tells place and reason."""


@dataclass(frozen=True, slots=True)
class Node:
    """A value inside a file, with its path for error messages."""

    value: Any
    path: str = ""
    root: Text = _FILE

    def field(self, name: str) -> Node:
        """Return a field of an object; null if the field is missing."""
        if not isinstance(self.value, dict):
            self.refuse(Text("must be an object"))
        return Node(self.value.get(name), f"{self.path}: {name}", self.root)

    def only(self, names: Collection[str]) -> Node:
        """Return this object. Raises BadFile if it has other fields than these."""
        if not isinstance(self.value, dict):
            self.refuse(Text("must be an object"))
        unknown = sorted(set(self.value) - set(names))
        if unknown:
            self.refuse(Text("has an unknown field {unknown}", unknown=shown(unknown[0])))
        return self

    def items(self, most: int) -> list[Node]:
        """Return the elements of a list with at most `most` elements."""
        if not isinstance(self.value, list):
            self.refuse(Text("must be a list"))
        if len(self.value) > most:
            self.refuse(
                Text(
                    "has {count} entries; at most {most} are allowed",
                    count=len(self.value),
                    most=most,
                )
            )
        return [Node(value, f"{self.path}[{n}]", self.root) for n, value in enumerate(self.value)]

    def count(self, name: str) -> int:
        """Return the length of a list in a field; 0 for other values."""
        value = self.field(name).value
        return len(value) if isinstance(value, list) else 0

    def number(self, low: float, high: float) -> float:
        """Return a finite number from `low` to `high`."""
        value = self.value
        if isinstance(value, bool) or not isinstance(value, int | float):
            self.refuse(Text("must be a number"))
        if not (low <= value <= high and math.isfinite(value)):
            self.refuse(Text("must be within {low:g}..{high:g}", low=low, high=high))
        return float(value)

    def whole(self, low: int, high: int) -> int:
        """Return a whole number from `low` to `high`."""
        if isinstance(self.value, bool) or not isinstance(self.value, int):
            self.refuse(Text("must be a whole number"))
        return int(self.number(low, high))

    def flag(self) -> bool:
        """Return true or false."""
        if not isinstance(self.value, bool):
            self.refuse(Text("must be true or false"))
        return self.value

    def text(self, longest: int, among: Collection[str] = ()) -> str:
        """Return a text without control characters or surrogates; one of `among` if given."""
        if not isinstance(self.value, str):
            self.refuse(Text("must be a text"))
        if len(self.value) > longest or _UNPLAIN.search(self.value):
            self.refuse(
                Text("must be a text of at most {longest} printable letters", longest=longest)
            )
        if among and self.value not in among:
            self.refuse(Text("must be one of {allowed}", allowed=", ".join(among)))
        return self.value

    def refuse(self, reason: str) -> NoReturn:
        """Raise BadFile for this value."""
        raise BadFile("{root}{path} {reason}", root=self.root, path=self.path, reason=reason)


def read(path: Path, most_bytes: int) -> bytes:
    """Return the content of a file, cut after `most_bytes` + 1: the last byte shows the excess.

    Raises BadFile.
    """
    try:
        with path.open("rb") as file:
            return file.read(most_bytes + 1)
    except FileNotFoundError:
        raise BadFile("{path} doesn't exist; check the name and the folder", path=path) from None
    except OSError as error:
        raise BadFile(
            "{path} can't be read ({reason})", path=path, reason=system_reason(error)
        ) from None


def parse(data: bytes, most_bytes: int) -> Node:
    """Parse JSON text, with or without a byte order mark.

    Raises BadFile, also for NaN, infinities, deep nesting and repeated fields.
    """
    if len(data) > most_bytes:
        raise BadFile(
            "the file has {count} bytes; at most {most_bytes} are allowed",
            count=len(data),
            most_bytes=most_bytes,
        )
    try:
        value = json.loads(
            data.decode("utf-8-sig"), parse_constant=_no_constant, object_pairs_hook=_once
        )
    except RecursionError:
        raise BadFile("the file is nested too deeply") from None
    except UnicodeDecodeError:
        raise BadFile("the file is not JSON, but binary data") from None
    except BadFile:
        raise
    except ValueError as error:  # not JSON, or a number of thousands of digits
        raise BadFile("the file is not JSON ({error})", error=str(error)[:80]) from None
    return Node(value)


def _no_constant(text: str) -> NoReturn:
    raise BadFile("the file contains {text}, which is not a number", text=text)


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) != len(pairs):
        raise BadFile("the file contains a field twice")
    return found
