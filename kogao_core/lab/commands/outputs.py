"""Output files of an experiment: JSON, CSV, HTML report, pictures."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any, Final

import click

from kogao_core.base import atomic
from kogao_core.base.display import png
from kogao_core.base.geometry import Image
from kogao_core.base.language import Text
from kogao_core.cli import common, ending, words
from kogao_core.lab.reports.report import Made, Report, files, translated_report

KINDS: Final = ("json", "csv", "html")
STDOUT: Final = common.STDOUT
# Adds ``--json``, ``--csv``, ``--html``, which `asked_for` reads, and ``--force``.
writes_files = words.together(
    common.writes_json,
    common.writes("csv", Text("Write a table of all figures (- prints the table).")),
    common.writes("html", Text("Write a report for a browser (- prints the report).")),
    common.forces,
)


def asked_for(given: Mapping[str, Any]) -> dict[str, Path]:
    """Return the requested files, by type."""
    files = {kind: given[f"{kind}_file"] for kind in KINDS}
    return {kind: file for kind, file in files.items() if file is not None}


class Outputs:
    """Output files and folder; checked before the experiment begins."""

    def __init__(self, files: Mapping[str, Path], folder: Path | None, force: bool) -> None:
        self._files, self._folder = files, folder
        if list(files.values()).count(STDOUT) > 1:
            raise ending.Stop("only one file can be printed; give names to the others")
        for file in files.values():
            if file != STDOUT and file.parent == folder:
                common.check_free(file, force)
            else:
                common.check_report(file, force)
        if folder is not None:
            _check_folder(folder)
            check_empty(folder, force)

    def keep(self, files: Iterable[tuple[str, Image | str]]) -> None:
        """Write pictures (grey or RGB) and texts by file name, if a folder was requested."""
        if self._folder is None:
            return
        with _writing(self._folder):
            self._folder.mkdir(parents=True, exist_ok=True)
            for name, one in files:
                data = one.encode() if isinstance(one, str) else png(one)
                atomic.atomic_write(data, self._folder / name)

    def write(self, report: Report, left_out: Sequence[str] = ()) -> None:
        """Write the files; print the tables unless a file goes to standard output."""
        text_of = files(report, Made.now(click.get_current_context().obj, left_out))
        if STDOUT not in self._files.values():
            ending.print_text(translated_report(report).text())
        self.keep(())
        for kind, file in self._files.items():
            text = text_of[kind]()
            if file == STDOUT:
                click.echo(text, nl=False)
            else:
                with _writing(file):
                    atomic.atomic_write(text.encode(), file)


def _writing(place: Path) -> AbstractContextManager[None]:
    return ending.refusing(
        "{place} can't be written ({reason}); choose another folder or make room", place=place
    )


def check_empty(folder: Path, force: bool) -> None:
    """Stop if the folder isn't empty, unless `force`."""
    if folder.is_dir() and any(folder.iterdir()) and not force:
        raise ending.Stop(
            "{folder} isn't empty; choose another folder, or overwrite files with --force",
            folder=folder,
        )


def _check_folder(folder: Path) -> None:
    """Stop if the folder isn't writable or can't be made."""
    nearest = next((place for place in (folder, *folder.parents) if place.exists()), folder)
    if not nearest.is_dir():
        raise ending.Stop("there is no folder {folder}", ending.UNREADABLE, folder=folder)
    if not os.access(nearest, os.W_OK):
        raise ending.Stop("no permission to write to {nearest}", ending.UNREADABLE, nearest=nearest)
