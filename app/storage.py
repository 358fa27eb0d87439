"""Where the editor keeps what outlives it: settings, and files for recovery."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from PySide6.QtCore import QSettings, QStandardPaths

_NAME = "kogao"


@dataclass(frozen=True, slots=True)
class Storage:
    """Two folders; they are made when something is first written.

    Parameters
    ----------
    config : Path
        For settings.
    data : Path
        For recovery files, and a log of what went wrong.
    """

    config: Path
    data: Path

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
    def log(self) -> Path:
        """Where tracebacks go."""
        return self.data / "kogao.log"

    def settings(self) -> QSettings:
        """Return the settings; every caller sees the same ones."""
        return QSettings(str(self.config / "kogao.ini"), QSettings.Format.IniFormat)
