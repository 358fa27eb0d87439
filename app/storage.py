"""Where the editor keeps what outlives it: settings, and files for recovery."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from pathlib import Path

from PySide6.QtCore import QSettings, QStandardPaths

from kogao_core.projects import results
from kogao_core.projects.results import Results

_NAME = "kogao"
_ESCAPE = re.compile(r"\\(?:x([0-9a-fA-F]+)|([0-7]+)|([abfnrtv\"?'\\])|\r?\n|.)|\"")
# Values that Qt makes from bytes, Python's objects among them, which run code when they are read.
# Ours are texts, lists of them, flags and bytes.
_NOT_OURS = ("@Variant(", "@DateTime(")


@dataclass(frozen=True, slots=True)
class Storage:
    """Two folders; they are made when something is first written."""

    config: Path  # for settings
    data: Path  # for recovery files, presets, and a log of what went wrong

    @staticmethod
    def of_user() -> Storage:
        """Return the folders that the system keeps for this user and this program."""
        kinds = QStandardPaths.StandardLocation
        places = (kinds.GenericConfigLocation, kinds.GenericDataLocation)
        config, data = (Path(QStandardPaths.writableLocation(place)) for place in places)
        return Storage(config / _NAME, data / _NAME)

    @staticmethod
    def in_folder(folder: Path) -> Storage:
        """Keep everything in one folder."""
        return Storage(folder, folder)

    @property
    def recovery(self) -> Path:
        """The folder of recovery files."""
        return self.data / "recovery"

    @property
    def edits(self) -> Path:
        """The folder of edits that don't lie beside their photos, and of undo steps."""
        return self.data / "edits"

    @property
    def results(self) -> Results:
        """The list of what was made of photos."""
        return Results(self.data / results.NAME)

    @property
    def originals(self) -> Path:
        """The folder of photos as they were before they were written over."""
        return self.data / "originals"

    @property
    def presets(self) -> Path:
        """The folder of the user's presets, which the command line knows, too."""
        return self.data / "presets"

    @property
    def log(self) -> Path:
        """Where tracebacks go."""
        return self.data / "kogao.log"

    def settings(self) -> QSettings:
        """Return the settings; every caller sees the same ones.

        A file with values of kinds that the editor doesn't write is put aside, as
        ``kogao.ini.damaged``, before Qt reads it.
        """
        file = self.config / "kogao.ini"
        place = str(file)
        if _is_foreign(file):
            try:
                file.replace(file.with_name(f"{file.name}.damaged"))
            except OSError:  # then nothing is known, and nothing kept
                place = os.devnull
        return QSettings(place, QSettings.Format.IniFormat)


def _is_foreign(file: Path) -> bool:
    try:
        text = file.read_text(encoding="latin-1")
    except OSError:
        return False
    plain = _ESCAPE.sub(_letter, text)
    return any(kind in plain for kind in _NOT_OURS)


def _letter(escape: re.Match[str]) -> str:
    """Return what Qt reads for an escape; quotes, ends of lines and unknown ones vanish."""
    code = int(escape[1], 16) if escape[1] else int(escape[2], 8) if escape[2] else None
    if code is not None:
        return chr(code & 0xFFFF)
    return " " if escape[3] else ""
