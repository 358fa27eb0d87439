"""``kogao-cli integrate``: Kogao in the menus of the desktop and of other programs, and away."""

from __future__ import annotations

import json
import os
import shutil
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import click

from kogao_core import installed
from kogao_core.cli import common, desktop, words
from kogao_core.language import Text, translated
from kogao_core.wording import system_reason

_OURS: Final = "-- by kogao-cli integrate"
# Named by its path: where darktable is a Flatpak, `require` doesn't look among the user's scripts.
_LINE: Final = (
    "package.loaded.kogao = dofile("
    f'require("darktable").configuration.config_dir .. "/lua/kogao.lua") {_OURS}'
)
_VARIABLES: Final = {".config": "XDG_CONFIG_HOME", ".local/share": "XDG_DATA_HOME"}
_DESKTOP: Final = "desktop"
_OUT: Final = "flatpak override --user --talk-name=org.freedesktop.Flatpak"


@dataclass(frozen=True, slots=True)
class Host:
    """A program that can hand pictures to this one.

    Parameters
    ----------
    settings : callable
        Returns the folder of its settings.
    sandbox : str
        Its name as a Flatpak.
    in_sandbox : str
        The folder of a Flatpak's settings within its own ones; empty where it shares the user's.
    files : mapping of str to str
        Our files among the resources, and where each goes within that folder; the first is told.
    quoted : callable
        Writes a path as its language does, where the file has ``@KOGAO@``.
    mark : str
        File of the settings that must name ours; empty where all of a folder are taken.
    then : Text, optional
        What is left to do in that program.
    """

    settings: Callable[[], Path]
    sandbox: str
    in_sandbox: str
    files: Mapping[str, str]
    quoted: Callable[[Path], str]
    mark: str = ""
    then: Text | None = None


def _settings(windows: str, mac: str, other: str, name: str) -> Path:
    if sys.platform == "win32":
        return Path(os.environ.get(windows, Path.home())) / name
    if sys.platform == "darwin":
        return Path.home() / mac / name
    return Path(os.environ.get(_VARIABLES[other]) or Path.home() / other) / name


def _in_lua(path: Path) -> str:
    """Return a path as a shell takes it, within a text of Lua."""
    quote = '"' if sys.platform == "win32" else "'"
    text = str(path).replace("'", r"'\''") if quote == "'" else str(path)
    return f"{quote}{text}{quote}".replace("\\", "\\\\").replace('"', '\\"')


def _in_python(path: Path) -> str:
    return json.dumps(str(path))[1:-1]


HOSTS: Final[Mapping[str, Host]] = {
    "darktable": Host(
        lambda: _settings("LOCALAPPDATA", ".config", ".config", "darktable"),
        "org.darktable.Darktable",
        "config/darktable",
        {"darktable/kogao.lua": "lua/kogao.lua"},
        _in_lua,
        "luarc",
    ),
    "gimp": Host(
        lambda: _settings("APPDATA", "Library/Application Support", ".config", "GIMP/3.0"),
        "org.gimp.GIMP",
        "",
        {"gimp/kogao.py": "plug-ins/kogao/kogao.py"},
        _in_python,
    ),
    "krita": Host(
        lambda: _settings("APPDATA", "Library/Application Support", ".local/share", "krita"),
        "org.kde.krita",
        "data/krita",
        {
            "krita/kogao.py": "pykrita/kogao/__init__.py",
            "krita/kogao.desktop": "pykrita/kogao.desktop",
        },
        _in_python,
        then=Text("then tick Kogao in Settings > Configure Krita > Python Plugin Manager"),
    ),
}


@words.command("integrate")
@click.argument("host", type=click.Choice((_DESKTOP, *HOSTS)))
@words.option("--remove", is_flag=True, help="Take it away again.")
@words.option(
    "--settings", type=click.Path(path_type=Path, file_okay=False), metavar="FOLDER",
    help="Where the program has its settings, a desktop its menus [where the system has them].",
)  # fmt: skip
def command(host: str, remove: bool, settings: Path | None) -> None:
    """Put Kogao into the menus of the desktop, or among the tools of darktable, GIMP 3 or Krita.

    Other programs know it when they start next.
    """
    from kogao_core import assets

    try:
        with common.stopping(assets.AssetMissing, common.BROKEN):
            if host == _DESKTOP:
                done = _change_desktop(settings, remove)
            else:
                done = _change_host(host, settings, remove)
    except OSError as error:
        raise common.Stop(
            Text(
                "{place} can't be changed ({why})",
                place=error.filename or settings or host,
                why=system_reason(error),
            ),
            common.UNREADABLE,
        ) from error
    common.print_text("\n".join(map(translated, done)))


def _change_desktop(share: Path | None, remove: bool) -> list[Text]:
    if sys.platform in ("win32", "darwin"):
        raise common.Stop(Text("menus of this kind are those of Linux desktops"), common.USAGE)
    folder = share or desktop.of_user()
    if remove:
        desktop.remove(folder)
        return [Text("Kogao is gone from {folder}", folder=folder)]
    desktop.install(folder, _program("kogao"))
    return [Text("Kogao is among the programs of {folder}", folder=folder)]


def _change_host(name: str, settings: Path | None, remove: bool) -> list[Text]:
    host = HOSTS[name]
    sandboxed = Path.home() / ".var/app" / host.sandbox
    folders = [settings] if settings else _folders(host, sandboxed)
    said = []
    for folder in folders:
        place = folder / next(iter(host.files.values()))
        if remove:
            _remove(host, folder)
            said.append(Text("{place} is gone; start {host} again", place=place, host=name))
        else:
            _install(host, folder)
            said.append(Text("{place} is there; start {host} again", place=place, host=name))
    if not remove and host.then is not None:
        said.append(host.then)
    if not remove and settings is None and sandboxed.is_dir():
        said.append(
            Text(
                "{host} is a Flatpak here, which can start Kogao once it may leave its sandbox: "
                "{command}",
                host=name,
                command=f"{_OUT} {host.sandbox}",
            )
        )
    return said


def _folders(host: Host, sandboxed: Path) -> list[Path]:
    """Return the folders of settings that there are; the system's own if there is none yet."""
    own = host.settings()
    inner = sandboxed / host.in_sandbox
    if not host.in_sandbox or not inner.is_dir():
        return [own]
    return [own, inner] if own.is_dir() else [inner]


def _install(host: Host, folder: Path) -> None:
    from kogao_core import assets
    from kogao_core.atomic import put

    for resource, within in host.files.items():
        text = assets.path(f"integrations/{resource}").read_text(encoding="utf-8")
        for word, name in (("@KOGAO@", "kogao"), ("@KOGAO_CLI@", "kogao-cli")):
            text = text.replace(word, host.quoted(_program(name)))
        place = folder / within
        place.parent.mkdir(parents=True, exist_ok=True)
        put(text.encode(), place)
        place.chmod(0o755)
    if host.mark:
        _mark(folder / host.mark, wanted=True)


def _remove(host: Host, folder: Path) -> None:
    for within in host.files.values():
        place = folder / within
        place.unlink(missing_ok=True)
        if place.parent.name == "kogao" and place.parent.is_dir():
            shutil.rmtree(place.parent)
    if host.mark and (folder / host.mark).exists():
        _mark(folder / host.mark, wanted=False)


def _program(name: str) -> Path:
    found = installed.program(name)
    if found is None:
        raise common.Stop(
            Text("{program} isn't installed here; pip install kogao", program=name), common.BROKEN
        )
    return found


def _mark(file: Path, *, wanted: bool) -> None:
    """Add our line to a file of the program's settings, or take it out; the rest stays."""
    from kogao_core.atomic import put

    before = file.read_bytes() if file.exists() else b""
    lines = [line for line in before.splitlines(keepends=True) if _OURS.encode() not in line]
    if wanted:
        if lines and not lines[-1].endswith(b"\n"):
            lines[-1] += b"\n"
        lines.append(f"{_LINE}\n".encode())
    if b"".join(lines) != before:
        put(b"".join(lines), file)
