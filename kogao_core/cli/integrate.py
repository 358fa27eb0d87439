"""``kogao-cli integrate``: Kogao in the menus of the desktop and of other programs, and away."""

from __future__ import annotations

import json
import os
import shlex
import shutil
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import click

from kogao_core.base import assets, installed
from kogao_core.base.atomic import put
from kogao_core.base.language import Text, translated
from kogao_core.base.wording import system_reason
from kogao_core.cli import common, desktop, ending, words

_OURS: Final = "-- by kogao-cli integrate"
# Named by its path: where darktable is a Flatpak, `require` doesn't look among the user's scripts.
_LINE: Final = (
    "package.loaded.kogao = dofile("
    f'require("darktable").configuration.config_dir .. "/lua/kogao.lua") {_OURS}'
)
_VARIABLES: Final = {".config": "XDG_CONFIG_HOME", ".local/share": "XDG_DATA_HOME"}
_DESKTOP: Final = "desktop"
_OUTSIDE: Final = "kogao_outside.py"  # what starts this program from others' Python
_OUT: Final = "flatpak override --user --talk-name=org.freedesktop.Flatpak"


@dataclass(frozen=True, slots=True)
class Host:
    """A program, or a version of it, that can hand pictures to this one."""

    title: str
    settings: Callable[[], Path]  # returns the folder of its settings
    sandbox: str  # its name as a Flatpak
    # The folder of a Flatpak's settings within its own ones; empty where it shares the user's.
    in_sandbox: str
    # Our files among the resources, and where each goes within that folder; the first is started,
    # and told.
    files: Mapping[str, str]
    # Whether it fills that folder only where there is none yet, so that it must have been there.
    is_filled_once: bool = False
    # File of the settings that must name ours; empty where all of a folder are taken.
    mark: str = ""
    then: Text | None = None  # what is left to do in that program


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


# What our files show, in the language of whoever has them put there.
_WORDS: Final = {
    "@EDIT@": Text("Kogao: edit…"),
    "@SMALLER@": Text("Kogao: smaller faces"),
    "@AMOUNT@": Text("Amount, %"),
    "@RESULT@": Text("Kogao, {percent} %, faces: {faces}"),
    "@RESULT_BESIDE@": Text("the result comes back beside the photo"),
    "@CLOSED@": Text("The picture was closed meanwhile."),
    "@CANNOT_START@": Text("{program} can't be started; run {command} again."),
}
# How the languages of our files write a path, where these have ``@KOGAO@``.
_QUOTED: Final[Mapping[str, Callable[[Path], str]]] = {
    ".lua": _in_lua,
    ".py": lambda path: json.dumps(str(path))[1:-1],
    ".sh": lambda path: shlex.quote(str(path)),
}


def _gimp(version: str, files: Mapping[str, str]) -> Host:
    ours = {f"gimp/{name}": theirs for name, theirs in files.items()}
    files = {**ours, "gimp/common.py": "common.py", _OUTSIDE: _OUTSIDE}
    return Host(
        "GIMP",
        lambda: _settings("APPDATA", "Library/Application Support", ".config", f"GIMP/{version}"),
        "org.gimp.GIMP",
        "",
        {name: f"plug-ins/kogao/{theirs}" for name, theirs in files.items()},
        is_filled_once=True,
    )


_GIMP_3: Final = _gimp("3.0", {"kogao.py": "kogao.py"})
_GIMP_2_10: Final = _gimp("2.10", {"kogao.sh": "kogao", "gimp_2_10.py": "gimp_2_10.py"})

HOSTS: Final[Mapping[str, tuple[Host, ...]]] = {
    "darktable": (
        Host(
            "darktable",
            lambda: _settings("LOCALAPPDATA", ".config", ".config", "darktable"),
            "org.darktable.Darktable",
            "config/darktable",
            {"darktable/kogao.lua": "lua/kogao.lua"},
            mark="luarc",
        ),
    ),
    # Elsewhere GIMP 2.10 starts no scripts, or brings its library where only it finds it.
    "gimp": (_GIMP_3,) if sys.platform in ("win32", "darwin") else (_GIMP_3, _GIMP_2_10),
    "krita": (
        Host(
            "Krita",
            lambda: _settings("APPDATA", "Library/Application Support", ".local/share", "krita"),
            "org.kde.krita",
            "data/krita",
            {
                "krita/kogao.py": "pykrita/kogao/__init__.py",
                _OUTSIDE: f"pykrita/kogao/{_OUTSIDE}",
                "krita/kogao.desktop": "pykrita/kogao.desktop",
            },
            then=Text("then tick Kogao in Settings > Configure Krita > Python Plugin Manager"),
        ),
    ),
}


@words.command("integrate")
@click.argument("host", type=click.Choice((_DESKTOP, *HOSTS)), required=False)
@words.option(
    "--remove", is_flag=True, help="Take it away again; from all of them if none is named."
)
@words.option(
    "--settings", type=common.FOLDER, metavar="FOLDER",
    help="Where the program has its settings, a desktop its menus [where the system has them].",
)  # fmt: skip
@click.pass_context
def command(context: click.Context, host: str | None, remove: bool, settings: Path | None) -> None:
    """Add Kogao to the desktop, darktable, GIMP or Krita.

    Other programs know it when they start next.
    """
    if host is None and (not remove or settings):
        raise click.UsageError(
            Text("name one of {hosts}", hosts=", ".join((_DESKTOP, *HOSTS))), context
        )
    done = []
    try:
        with ending.stopping(assets.AssetMissing, ending.BROKEN):
            for one in (_DESKTOP, *HOSTS) if host is None else (host,):
                if one != _DESKTOP:
                    done += _change_host(one, settings, remove)
                elif host or sys.platform not in ("win32", "darwin"):
                    done += _change_desktop(settings, remove)
    except OSError as error:
        raise ending.Stop(
            Text(
                "{place} can't be changed ({why})",
                place=error.filename or settings or host or _DESKTOP,
                why=system_reason(error),
            ),
            ending.UNREADABLE,
        ) from error
    ending.print_text("\n".join(map(translated, done)))


def _change_desktop(share: Path | None, remove: bool) -> list[Text]:
    if sys.platform in ("win32", "darwin"):
        raise ending.Stop(Text("menus of this kind are those of Linux desktops"))
    folder = share or desktop.data_home()
    if remove:
        desktop.remove(folder)
        return [Text("Kogao is gone from {folder}", folder=folder)]
    desktop.install(folder, _program("kogao"))
    return [Text("Kogao is among the programs of {folder}", folder=folder)]


def _change_host(name: str, settings: Path | None, remove: bool) -> list[Text]:
    said: list[Text] = []
    titled = HOSTS[name][0].title
    for host, folder in _places(name, settings, remove):
        place = folder / next(iter(host.files.values()))
        if remove:
            if place.exists():
                said.append(Text("{place} is gone; start {host} again", place=place, host=titled))
            _remove(host, folder)
        else:
            _install(host, folder)
            said.append(Text("{place} is there; start {host} again", place=place, host=titled))
    if remove:
        return said
    host = HOSTS[name][0]
    if host.then is not None:
        said.append(host.then)
    if settings is None and _sandboxed(host).is_dir():
        said.append(
            Text(
                "{host} is a Flatpak here, which can start Kogao once it may leave its sandbox: "
                "{command}",
                host=titled,
                command=f"{_OUT} {host.sandbox}",
            )
        )
    return said


def _places(name: str, settings: Path | None, remove: bool) -> list[tuple[Host, Path]]:
    """Return the versions of a program that are here, each with a folder of its settings."""
    hosts = HOSTS[name]
    if settings is not None:
        named = [host for host in hosts if host.settings().name == settings.name]
        return [((named or hosts)[0], settings)]
    places = [
        (host, folder)
        for host in hosts
        for folder in _folders(host)
        if remove or folder.is_dir() or not host.is_filled_once
    ]
    if not places:
        raise ending.Stop(
            Text(
                "{host} has no settings here yet; start it once, and then this again",
                host=hosts[0].title,
            ),
            ending.UNREADABLE,
        )
    return places


def _sandboxed(host: Host) -> Path:
    return Path.home() / ".var/app" / host.sandbox


def _folders(host: Host) -> list[Path]:
    """Return the folders of settings that there are; the system's own if there is none yet."""
    own = host.settings()
    inner = _sandboxed(host) / host.in_sandbox
    if not host.in_sandbox or not inner.is_dir():
        return [own]
    return [own, inner] if own.is_dir() else [inner]


def _install(host: Host, folder: Path) -> None:
    for resource, within in host.files.items():
        text = assets.path(f"integrations/{resource}").read_text(encoding="utf-8")
        for word, said in _WORDS.items():
            text = text.replace(word, translated(said))
        for word, program in _PROGRAMS.items():
            if word in text:
                text = text.replace(word, _QUOTED[Path(resource).suffix](program()))
        place = folder / within
        place.parent.mkdir(parents=True, exist_ok=True)
        put(text.encode(), place)
        # GIMP would start whatever can be started.
        place.chmod(0o755 if within == next(iter(host.files.values())) else 0o644)
    if host.mark:
        _mark(folder / host.mark, wanted=True)


def _remove(host: Host, folder: Path) -> None:
    for within in host.files.values():
        place = folder / within
        place.unlink(missing_ok=True)
        if place.parent.name == "kogao" and place.parent.is_dir():
            shutil.rmtree(place.parent)
    if host.mark:
        _mark(folder / host.mark, wanted=False)


def _program(name: str) -> Path:
    found = installed.program(name)
    if found is None:
        raise ending.Stop(
            Text("{program} isn't here: {command}", program=name, command=installed.again()),
            ending.BROKEN,
        )
    return found


def _python() -> Path:
    """Return the Python at work; where a bundle has it within, the system's."""
    found = shutil.which("python3") if installed.is_bundle() else sys.executable
    if found is None:
        raise ending.Stop(
            Text("GIMP 2.10 starts Kogao by a Python 3, and none is on the path here"),
            ending.BROKEN,
        )
    return Path(found)


_PROGRAMS: Final[Mapping[str, Callable[[], Path]]] = {
    "@KOGAO@": lambda: _program("kogao"),
    "@KOGAO_CLI@": lambda: _program("kogao-cli"),
    "@PYTHON@": _python,
}


def _mark(file: Path, *, wanted: bool) -> None:
    """Add our line to a file of the program's settings, or take it out; the rest stays."""
    before = file.read_bytes() if file.exists() else b""
    lines = [line for line in before.splitlines(keepends=True) if _OURS.encode() not in line]
    if wanted:
        if lines and not lines[-1].endswith(b"\n"):
            lines[-1] += b"\n"
        lines.append(f"{_LINE}\n".encode())
    if b"".join(lines) != before:
        put(b"".join(lines), file)
