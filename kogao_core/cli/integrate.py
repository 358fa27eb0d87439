"""``kogao-cli integrate``: add Kogao to the desktop and to other programs, or remove it."""

from __future__ import annotations

import json
import os
import shlex
import shutil
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Final

import click

from kogao_core.base import assets, installed
from kogao_core.base.atomic import atomic_write
from kogao_core.base.language import Text, translated
from kogao_core.base.wording import system_reason
from kogao_core.cli import desktop, ending
from kogao_core.recipe.recipe import Recipe

_MARK: Final = "-- by kogao-cli integrate"
# A full path, because `require` ignores the user's scripts if darktable is a Flatpak.
_LINE: Final = (
    "package.loaded.kogao = dofile("
    f'require("darktable").configuration.config_dir .. "/lua/kogao.lua") {_MARK}'
)
_VARIABLES: Final = {".config": "XDG_CONFIG_HOME", ".local/share": "XDG_DATA_HOME"}
_DESKTOP: Final = "desktop"
_OUTSIDE: Final = "kogao_outside.py"  # starts Kogao from the Python of another program
_PERMIT: Final = "flatpak override --user --talk-name=org.freedesktop.Flatpak"


@dataclass(frozen=True, slots=True)
class Host:
    """A program, or one version of a program, that can send pictures to Kogao."""

    title: str
    settings: Callable[[], Path]  # returns the folder of the program's settings
    sandbox: str  # name of the Flatpak
    in_sandbox: str  # settings within the Flatpak's folder; "" if the Flatpak uses the user's
    files: Mapping[str, str]  # resource to path within the settings; the first is executable
    # The program fills a new folder of settings, but not an existing one: start it first.
    is_filled_once: bool = False
    mark: str = ""  # file of the settings that must load ours; "" if the program loads all files
    then: Text | None = None  # a last step in the program


def _settings(windows: str, mac: str, other: str, name: str) -> Path:
    if sys.platform == "win32":
        return Path(os.environ.get(windows, Path.home())) / name
    if sys.platform == "darwin":
        return Path.home() / mac / name
    return Path(os.environ.get(_VARIABLES[other]) or Path.home() / other) / name


def _in_lua(path: Path) -> str:
    """Return a path quoted for the shell, inside a Lua string."""
    quote = '"' if sys.platform == "win32" else "'"
    text = str(path).replace("'", r"'\''") if quote == "'" else str(path)
    return f"{quote}{text}{quote}".replace("\\", "\\\\").replace('"', '\\"')


_EDIT: Final = Text("Kogao: edit…")
# Texts of the plug-ins, in the language of the person who installs them.
_WORDS: Final = {
    "@EDIT@": _EDIT,
    "@SMALLER@": Text("Kogao: smaller faces…"),
    "@AMOUNT@": f"{Recipe().percent:g}",
    "@AMOUNT_LABEL@": Text("Amount, %"),
    "@RESULT@": Text("Kogao, {amount} %, faces: {faces}"),
    "@RESULT_NEXT_TO@": Text("The result is saved next to the photo."),
    "@CLOSED@": Text("The picture was closed meanwhile."),
    "@NO_FACE@": Text("No face is certain. Choose {edit} to place faces by hand.", edit=_EDIT),
    "@CANNOT_START@": Text("{program} can't be started; run {command} again."),
}
# Quoted paths for ``@KOGAO@`` and so on, by the suffix of the plug-in's file.
_QUOTED: Final[Mapping[str, Callable[[Path], str]]] = {
    ".lua": _in_lua,
    ".py": lambda path: json.dumps(str(path))[1:-1],
    ".sh": lambda path: shlex.quote(str(path)),
}


def _gimp(version: str, own: Mapping[str, str]) -> Host:
    files = {f"gimp/{name}": target for name, target in own.items()}
    files |= {"gimp/common.py": "common.py", _OUTSIDE: _OUTSIDE}
    return Host(
        "GIMP",
        lambda: _settings("APPDATA", "Library/Application Support", ".config", f"GIMP/{version}"),
        "org.gimp.GIMP",
        "",
        {name: f"plug-ins/kogao/{target}" for name, target in files.items()},
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
    # On Windows and macOS, GIMP 2.10 runs no scripts or hides its library.
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
            then=Text("now enable Kogao in Settings > Configure Krita > Python Plugin Manager"),
        ),
    ),
}


def run(args: SimpleNamespace) -> None:
    """Add Kogao to a program or to the desktop, or remove it."""
    if args.host is None and (not args.remove or args.settings):
        raise click.UsageError(
            Text("name one of {hosts}", hosts=", ".join((_DESKTOP, *HOSTS))),
            click.get_current_context(),
        )
    messages: list[Text] = []
    try:
        with ending.stopping(assets.AssetMissing, ending.BROKEN):
            for one in (_DESKTOP, *HOSTS) if args.host is None else (args.host,):
                if one != _DESKTOP:
                    messages += _change_host(one, args.settings, args.remove)
                elif args.host or sys.platform not in ("win32", "darwin"):
                    messages += _change_desktop(args.settings, args.remove)
    except OSError as error:
        raise ending.Stop(
            "{place} can't be changed ({why})",
            ending.UNREADABLE,
            place=error.filename or args.settings or args.host or _DESKTOP,
            why=system_reason(error),
        ) from error
    ending.print_text("\n".join(map(translated, messages)))


def _change_desktop(share: Path | None, remove: bool) -> Iterator[Text]:
    """Change the menu of the desktop; yield messages."""
    if sys.platform in ("win32", "darwin"):
        raise ending.Stop("integrate desktop works on Linux only")
    folder = share or desktop.data_home()
    if not remove:
        desktop.install(folder, _program("kogao"))
        yield Text("Kogao was added to {folder}", folder=folder)
    elif desktop.remove(folder):
        yield Text("Kogao was removed from {folder}", folder=folder)
    else:
        yield Text("{folder} has no menu entry of Kogao", folder=folder)


def _change_host(name: str, settings: Path | None, remove: bool) -> Iterator[Text]:
    """Change the settings of each version of a program; yield messages."""
    first = HOSTS[name][0]
    for host, folder in _places(name, settings, remove):
        place = folder / next(iter(host.files.values()))
        if not remove:
            _install(host, folder)
            yield Text("{place} added; restart {host}", place=place, host=first.title)
            continue
        if place.exists():
            yield Text("{place} removed; restart {host}", place=place, host=first.title)
        _remove(host, folder)
    if not remove and first.then is not None:
        yield first.then
    if not remove and settings is None and _sandboxed(first).is_dir():
        yield Text(
            "{host} is a Flatpak; allow it to start Kogao: {command}",
            host=first.title,
            command=f"{_PERMIT} {first.sandbox}",
        )


def _places(name: str, settings: Path | None, remove: bool) -> list[tuple[Host, Path]]:
    """Return the installed versions of a program, each with a folder of settings. Raises Stop."""
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
            "{host} has no settings yet; start {host} once, then run this command again",
            ending.UNREADABLE,
            host=hosts[0].title,
        )
    return places


def _sandboxed(host: Host) -> Path:
    return Path.home() / ".var/app" / host.sandbox


def _folders(host: Host) -> list[Path]:
    """Return the existing folders of settings, or the usual folder if none exists."""
    own = host.settings()
    inner = _sandboxed(host) / host.in_sandbox
    if not host.in_sandbox or not inner.is_dir():
        return [own]
    return [own, inner] if own.is_dir() else [inner]


def _install(host: Host, folder: Path) -> None:
    for resource, within in host.files.items():
        text = assets.path(f"integrations/{resource}").read_text(encoding="utf-8")
        for word, shown in _WORDS.items():
            text = text.replace(word, translated(shown))
        for word, program in _PROGRAMS.items():
            if word in text:
                text = text.replace(word, _QUOTED[Path(resource).suffix](program()))
        place = folder / within
        place.parent.mkdir(parents=True, exist_ok=True)
        atomic_write(text.encode(), place)
        # GIMP starts every executable file.
        place.chmod(0o755 if within == next(iter(host.files.values())) else 0o644)
    if host.mark:
        _set_line(folder / host.mark, is_loaded=True)


def _remove(host: Host, folder: Path) -> None:
    for within in host.files.values():
        place = folder / within
        place.unlink(missing_ok=True)
        if place.parent.name == "kogao" and place.parent.is_dir():
            shutil.rmtree(place.parent)
    if host.mark:
        _set_line(folder / host.mark, is_loaded=False)


def _program(name: str) -> Path:
    found = installed.program(name)
    if found is None:
        raise ending.Stop(
            "{program} is missing: {command}",
            ending.BROKEN,
            program=name,
            command=installed.again(),
        )
    return found


def _python() -> Path:
    """Return this Python, or the system's Python for a bundle."""
    found = shutil.which("python3") if installed.is_bundle() else sys.executable
    if found is None:
        raise ending.Stop(
            "GIMP 2.10 needs a Python 3 to start Kogao, and none is on the path", ending.BROKEN
        )
    return Path(found)


_PROGRAMS: Final[Mapping[str, Callable[[], Path]]] = {
    "@KOGAO@": lambda: _program("kogao"),
    "@KOGAO_CLI@": lambda: _program("kogao-cli"),
    "@PYTHON@": _python,
}


def _set_line(file: Path, *, is_loaded: bool) -> None:
    """Add our line to a file of settings, or remove the line."""
    before = file.read_bytes() if file.exists() else b""
    lines = [line for line in before.splitlines(keepends=True) if _MARK.encode() not in line]
    if is_loaded:
        if lines and not lines[-1].endswith(b"\n"):
            lines[-1] += b"\n"
        lines.append(f"{_LINE}\n".encode())
    if b"".join(lines) != before:
        atomic_write(b"".join(lines), file)
