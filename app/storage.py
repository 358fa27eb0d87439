"""Locations of settings, recovery files and other persistent files."""

from __future__ import annotations

import os
import re
import sys
from dataclasses import dataclass
from pathlib import Path

from PySide6.QtCore import QSettings, QStandardPaths

from kogao_core.base.installed import data_folder
from kogao_core.projects import edits
from kogao_core.projects.edits import Edits
from kogao_core.projects.results import Results

_ESCAPE = re.compile(r"\\(?:x([0-9a-fA-F]+)|([0-7]+)|([abfnrtv\"?'\\])|\r?\n|.)|\"")
# Markers of serialised Qt objects. A Python object among the settings would run code on load.
# The editor stores only texts, lists of texts, flags and bytes.
_NOT_OURS = ("@Variant(", "@DateTime(")


@dataclass(frozen=True, slots=True)
class Storage:
    """Configuration and data folders, created on first write."""

    config: Path  # for settings
    data: Path  # for recovery files, presets and the error log

    @staticmethod
    def of_user() -> Storage:
        """Return the standard folders for this user and program."""
        data = data_folder()
        if sys.platform == "win32":  # settings stay with the data, on this computer
            return Storage.in_folder(data)
        place = QStandardPaths.StandardLocation.GenericConfigLocation
        return Storage(Path(QStandardPaths.writableLocation(place), data.name), data)

    @staticmethod
    def in_folder(folder: Path) -> Storage:
        """Use one folder for all files."""
        return Storage(folder, folder)

    @property
    def recovery(self) -> Path:
        return self.data / "recovery"

    @property
    def edits(self) -> Edits:
        """The saved edits of photos, with undo steps."""
        return Edits(self.data / edits.FOLDER)

    @property
    def results(self) -> Results:
        return Results(self.data)

    @property
    def originals(self) -> Path:
        """The folder of original photos, stored before overwriting."""
        return self.data / "originals"

    @property
    def presets(self) -> Path:
        """The folder of user presets, also read by the command line."""
        return self.data / "presets"

    @property
    def exports(self) -> Path:
        return self.data / "exports"

    @property
    def log(self) -> Path:
        return self.data / "kogao.log"

    def settings(self) -> QSettings:
        """Return the settings; all callers share the values.

        A file with values of unexpected kinds is renamed to ``kogao.ini.damaged`` before Qt reads
        the values.
        """
        file = self.config / "kogao.ini"
        place = str(file)
        if _is_foreign(file):
            try:
                file.replace(file.with_name(f"{file.name}.damaged"))
            except OSError:  # use an empty file; settings are not saved
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
    """Return the character that Qt reads for an escape; quotes, newlines and others vanish."""
    code = int(escape[1], 16) if escape[1] else int(escape[2], 8) if escape[2] else None
    if code is not None:
        return chr(code & 0xFFFF)
    return " " if escape[3] else ""
