"""``kogao-cli integrate``: Kogao among the tools of other programs, and away again."""

from __future__ import annotations

import json
import os
import shutil
import sys
import sysconfig
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

import click

from kogao_core.cli import common, words

if TYPE_CHECKING:
    from collections.abc import Mapping

_LINE: Final = 'require "kogao" -- by kogao-cli integrate'


@dataclass(frozen=True, slots=True)
class Host:
    """A program that can hand pictures to this one.

    Parameters
    ----------
    settings : callable
        Returns the folder of its settings.
    resource, place : str
        Our file among the resources, and where it goes within that folder.
    quoted : callable
        Writes a path as its language does, where the file has ``@KOGAO@``.
    mark : str
        File of the settings that must name ours; empty where all of a folder are taken.
    """

    settings: Callable[[], Path]
    resource: str
    place: str
    quoted: Callable[[Path], str]
    mark: str = ""


def _settings(windows: str, mac: str, other: str, name: str) -> Path:
    if sys.platform == "win32":
        return Path(os.environ.get(windows, Path.home())) / name
    if sys.platform == "darwin":
        return Path.home() / mac / name
    return Path(os.environ.get("XDG_CONFIG_HOME") or Path.home() / other) / name


def _in_lua(path: Path) -> str:
    """Return a path as a shell takes it, within a text of Lua."""
    quote = '"' if sys.platform == "win32" else "'"
    text = str(path).replace("'", r"'\''") if quote == "'" else str(path)
    return f"{quote}{text}{quote}".replace("\\", "\\\\").replace('"', '\\"')


HOSTS: Final[Mapping[str, Host]] = {
    "darktable": Host(
        lambda: _settings("LOCALAPPDATA", ".config", ".config", "darktable"),
        "darktable/kogao.lua",
        "lua/kogao.lua",
        _in_lua,
        "luarc",
    ),
    "gimp": Host(
        lambda: _settings("APPDATA", "Library/Application Support", ".config", "GIMP/3.0"),
        "gimp/kogao.py",
        "plug-ins/kogao/kogao.py",
        lambda path: json.dumps(str(path))[1:-1],
    ),
}


@words.command("integrate")
@click.argument("host", type=click.Choice(tuple(HOSTS)))
@words.option("--remove", is_flag=True, help="Take it away again.")
@words.option(
    "--settings", type=click.Path(path_type=Path, file_okay=False), metavar="FOLDER",
    help="Where the program keeps its settings [where the system has them].",
)  # fmt: skip
def command(host: str, remove: bool, settings: Path | None) -> None:
    """Put Kogao among the tools of darktable or of GIMP 3.

    It takes effect when that program starts next.
    """
    from kogao_core import assets

    one = HOSTS[host]
    folder = settings or one.settings()
    place = folder / one.place
    try:
        if remove:
            _remove(one, folder, place)
        else:
            with common.stopping(assets.AssetMissing, common.BROKEN):
                text = assets.path(f"integrations/{one.resource}").read_text(encoding="utf-8")
            _install(one, folder, place, text)
    except OSError as error:
        raise common.Stop(
            f"{error.filename or place} can't be changed ({error.strerror or error})",
            common.UNREADABLE,
        ) from error
    click.echo(f"{place} is {'gone' if remove else 'there'}; start {host} again")


def _install(host: Host, folder: Path, place: Path, text: str) -> None:
    from kogao_core.atomic import put

    for word, program in (("@KOGAO@", "kogao"), ("@KOGAO_CLI@", "kogao-cli")):
        text = text.replace(word, host.quoted(_program(program)))
    place.parent.mkdir(parents=True, exist_ok=True)
    put(text.encode(), place)
    place.chmod(0o755)
    if host.mark:
        _mark(folder / host.mark, wanted=True)


def _remove(host: Host, folder: Path, place: Path) -> None:
    place.unlink(missing_ok=True)
    if place.parent.name == "kogao" and place.parent.is_dir():
        shutil.rmtree(place.parent)
    if host.mark and (folder / host.mark).exists():
        _mark(folder / host.mark, wanted=False)


def _mark(file: Path, *, wanted: bool) -> None:
    """Add our line to a file of the program's settings, or take it out; the rest stays."""
    from kogao_core.atomic import put

    before = file.read_bytes() if file.exists() else b""
    lines = [line for line in before.splitlines(keepends=True) if _LINE.encode() not in line]
    if wanted:
        if lines and not lines[-1].endswith(b"\n"):
            lines[-1] += b"\n"
        lines.append(f"{_LINE}\n".encode())
    if b"".join(lines) != before:
        put(b"".join(lines), file)


def _program(name: str) -> Path:
    """Return where one of our programs lies: beside this Python, else on the path."""
    ending = ".exe" if sys.platform == "win32" else ""
    beside = Path(sysconfig.get_path("scripts")) / (name + ending)
    found = beside if beside.is_file() else shutil.which(name)
    if found is None:
        raise common.Stop(f"{name} isn't installed here; pip install kogao", common.BROKEN)
    return Path(found).absolute()
