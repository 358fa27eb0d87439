"""Honest timing: cases take turns, and every figure comes with its spread and beside its floor."""

from __future__ import annotations

import dataclasses
import re
import statistics
import subprocess
import textwrap
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from kogao_core.base.machine import machine
from kogao_core.lab.reports.report import NONE
from kogao_core.lab.reports.spread import Spread, in_turns, rounded

Case = Callable[[], float]
"""Measures itself once."""


@dataclass(frozen=True)
class Row:
    """What was measured, round by round, beside its floor."""

    name: str
    unit: str
    ours: list[float]  # one value per round, as in `floor`
    floor: list[float]
    again: list[float] = dataclasses.field(default_factory=list)  # the floor measured again

    @property
    def ratio(self) -> float:
        """Ratio of the medians."""
        return statistics.median(self.ours) / statistics.median(self.floor)

    @property
    def by_round(self) -> Spread:
        """The ratio round by round."""
        return Spread.of([one / other for one, other in zip(self.ours, self.floor, strict=True)])

    @property
    def noise(self) -> Spread | None:
        """The floor's ratio to itself."""
        ratios = [a / b for a, b in zip(self.again, self.floor, strict=False)]
        return Spread.of(ratios) if ratios else None

    @property
    def cells(self) -> list[str]:
        """What a table shows, the name first."""
        return [
            self.name,
            rounded(self.ratio),
            _quartiles(self.by_round),
            NONE if self.noise is None else _quartiles(self.noise),
            rounded(statistics.median(self.ours)),
            rounded(statistics.median(self.floor)),
            self.unit,
        ]


def _quartiles(spread: Spread) -> str:
    return f"{rounded(spread.q1)}\N{EN DASH}{rounded(spread.q3)}"


def timed(work: Callable[[], object]) -> Case:
    """Return a case that measures how long some work takes, ms."""

    def once() -> float:
        start = time.perf_counter()
        work()
        return (time.perf_counter() - start) * 1e3

    return once


def measured(cases: dict[str, Case], rounds: int) -> dict[str, list[float]]:
    """Let every case measure itself, in turns, after one round that doesn't count."""
    found: dict[str, list[float]] = {name: [] for name in cases}
    for name, counts in in_turns(list(cases), rounds, 1):
        value = cases[name]()
        if counts:
            found[name].append(value)
    return found


def take_turns(works: Mapping[str, Callable[[], object]], rounds: int) -> dict[str, list[float]]:
    """Do every work in turns, after one round that doesn't count; return the times of each, ms."""
    return measured({name: timed(work) for name, work in works.items()}, rounds)


def beside_floor(name: str, ours: Case, floor: Case, rounds: int) -> Row:
    """Measure a case, its floor, and the floor again, in turns, ms."""
    times = measured({"ours": ours, "floor": floor, "again": floor}, rounds)
    return Row(name, "ms", times["ours"], times["floor"], times["again"])


def into_page(page: Path, name: str, table: Iterable[Sequence[str]]) -> None:
    """Replace the text between ``<!-- name -->`` and ``<!-- /name -->`` by a table.

    The first row is the head. A line above the table names the commit and the machine.
    """
    git = ["git", "-C", str(Path(__file__).parent), "log", "-1", "--format=%h of %cs"]
    commit = subprocess.run(git, capture_output=True, text=True, check=True).stdout.strip()
    about = machine()
    versions = ", ".join(f"{package} {version}" for package, version in about["packages"].items())
    head, *rows = table
    note = (
        f"Commit {commit}; {about['processor']}, {about['cores']} cores, load at the end "
        f"{str(about['load']).split(',')[0]}; Python {about['python']}, {versions}."
    )
    lines = [
        *textwrap.wrap(note, 100),
        "",
        *("| " + " | ".join(row) + " |" for row in (head, ["---" for _ in head], *rows)),
    ]
    marks = re.compile(rf"(<!-- {name} -->\n).*?(<!-- /{name} -->)", re.DOTALL)
    text, count = marks.subn(
        lambda found: found[1] + "\n".join([*lines, found[2]]), page.read_text(encoding="utf-8")
    )
    if count != 1:
        raise SystemExit(f"{page} has no place for the table {name}")
    page.write_text(text, encoding="utf-8")
