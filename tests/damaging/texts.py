"""Damage to texts of any kind: JSON values by their place, numbers and words by sight."""

from __future__ import annotations

import json
import re
from typing import Any

import numpy as np

from damaging import bytewise

_DEEP = 100_000
_MOST_LETTERS = 4_000_000  # of what is repeated
# What a number, or a word, may turn into.
TOKENS = (
    *("nan", "inf", "-inf", "NaN", "Infinity", "1e308", "-1e308", "1e400", "-1e400", "1e-320"),
    *("9" * 400, "9" * 5000, "-1", "-0.0", "0", "1", "2", "1.5", "1e5", "126000", "1e9", "9e18"),
    *("2147483648", "-2147483649", "9223372036854775808", "0x10", "\uff11\uff12", "\u0663", "+5"),
    *("", "x", "é顔", "\u202e", "\x1b[31m", "true", "%s", "{0}", "a" * 100_000),
)
_JSON = (
    *("NaN", "Infinity", "-Infinity", "1e308", "-1e308", "1e400", "-1e400", "1e-320", "9" * 400),
    *("9" * 5000, "-1", "-0.0", "0", "1", "2.0", "1.5", "1e5", "1e9", "2147483648", "1e18"),
    *("9223372036854775808", "null", "true", "false", '""', '"x"', "[]", "{}", "[[]]", "[null]"),
    *('"\\ud800"', '"\\u0000"', '"\\u001b[31m"', '"é顔"', '"../../x"', '"/etc/passwd"', '"NaN"'),
    *("[1, 2]", '{"x": 1}', '"' + "a" * 100_000 + '"', "[" + "0," * 200_000 + "0]"),
    *("[" * _DEEP + "]" * _DEEP, '{"a":' * _DEEP + "1" + "}" * _DEEP, "[" * 900 + "]" * 900),
)
_TOKEN = re.compile(r"[^\s,;:{}\[\]\"'()<>=]+")
_NUMBER = re.compile(r"-?\d+\.?\d*(?:e[+-]?\d+)?")


def change(data: bytes, rng: np.random.Generator) -> bytes:
    """Return a text with one change."""
    kind = rng.random()
    text = data.decode("utf-8", "replace")
    if kind < 0.15 or not 0 < len(data) < _MOST_LETTERS:
        return bytewise.change(data, rng, data)
    if kind < 0.2:
        return _encoded(text, rng)
    changed = _changed_lines(text, rng) if kind < 0.6 else None
    return (changed or _changed_token(text, rng)).encode("utf-8", "surrogatepass")


def _encoded(text: str, rng: np.random.Generator) -> bytes:
    ends = ("\n", "\r\n", "\r")[rng.integers(3)]
    coding = ("utf-8", "utf-8-sig", "utf-16", "utf-32", "cp1252")[rng.integers(5)]
    return text.replace("\n", ends).encode(coding, "replace")


def _changed_lines(text: str, rng: np.random.Generator) -> str | None:
    """Change a value of a JSON text, or of one line of JSON lines; None where it is neither."""
    try:
        return _changed_json(json.loads(text), rng)
    except (ValueError, OverflowError, RecursionError):
        lines = text.split("\n")
    at = int(rng.integers(len(lines)))
    try:
        lines[at] = _changed_json(json.loads(lines[at]), rng)
    except (ValueError, OverflowError, RecursionError):
        return None
    return "\n".join(lines)


def _changed_json(value: Any, rng: np.random.Generator) -> str:
    places: list[tuple[Any, Any]] = []
    _walk(value, places)
    if not places:
        return _JSON[rng.integers(len(_JSON))]
    # Each depth is as likely as the others: points would outnumber all else.
    holder, key = _evenly(places, rng)
    kind = rng.integers(8)
    raw = {}
    if kind == 0:
        del holder[key]
    elif kind == 1 and isinstance(holder, dict):
        raw["\ue000"] = f"{json.dumps(key)}: {json.dumps(holder[key])}"
        holder["\ue000"] = 0
    elif kind == 2 and isinstance(holder[key], list):
        holder[key] *= _times(json.dumps(holder[key]), int(rng.choice([0, 2, 50, 1000])))
    elif kind == 3 and _is_number(holder[key]):
        holder[key] *= 10.0 ** int(rng.integers(-6, 10))
    elif kind == 4:
        other, name = _evenly(places, rng)
        holder[key] = json.loads(json.dumps(other[name])) if name in _keys(other) else None
    else:
        holder[key] = "\ue001"
        raw["\ue001"] = _JSON[rng.integers(len(_JSON))]
    text = json.dumps(value, ensure_ascii=False)
    for mark, said in raw.items():
        text = text.replace(f'"{mark}": 0', said).replace(f'"{mark}"', said)
    return text


def _keys(holder: Any) -> Any:
    return holder if isinstance(holder, dict) else range(len(holder))


def _times(text: str, wanted: int) -> int:
    return min(wanted, _MOST_LETTERS // (len(text) + 1))


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _evenly(places: list[tuple[Any, Any]], rng: np.random.Generator) -> tuple[Any, Any]:
    kinds: dict[Any, list[tuple[Any, Any]]] = {}
    for holder, key in places:
        name = key if isinstance(key, str) else type(holder[key]).__name__
        kinds.setdefault(name, []).append((holder, key))
    chosen = list(kinds.values())[rng.integers(len(kinds))]
    return chosen[rng.integers(len(chosen))]


def _walk(value: Any, places: list[tuple[Any, Any]]) -> None:
    if isinstance(value, dict | list):
        for key in _keys(value):
            places.append((value, key))
            _walk(value[key], places)


def _changed_token(text: str, rng: np.random.Generator) -> str:
    kind = rng.integers(4)
    pattern = _NUMBER if rng.random() < 0.6 else _TOKEN
    found = list(pattern.finditer(text))
    if kind == 0 or not found:
        return _changed_line(text, rng)
    token = found[rng.integers(len(found))]
    said = TOKENS[rng.integers(len(TOKENS))]
    if kind == 1 and pattern is _NUMBER:
        said = f"{float(token[0]) * 10.0 ** int(rng.integers(-6, 10)):.6g}"
    return text[: token.start()] + said + text[token.end() :]


def _changed_line(text: str, rng: np.random.Generator) -> str:
    lines = text.split("\n")
    at = int(rng.integers(len(lines)))
    kind = rng.integers(4)
    if kind == 0:
        del lines[at]
    elif kind == 1:
        lines[at:at] = [lines[at]] * _times(lines[at], int(rng.choice([1, 2, 1000, 20_000])))
    elif kind == 2:
        lines.insert(int(rng.integers(len(lines) + 1)), lines[at])
    else:
        lines[at] += " " + TOKENS[rng.integers(len(TOKENS))]
    return "\n".join(lines)
