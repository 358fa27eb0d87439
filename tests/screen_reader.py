"""A desktop without a screen or a mouse, and what a screen reader learns there over AT-SPI."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from PySide6.QtCore import QLibraryInfo
from timeouts import LONGEST_S

jeepney = pytest.importorskip("jeepney", reason="pip install -e '.[test]' again")
from jeepney.io.blocking import open_dbus_connection  # noqa: E402

_TOOLS = ("Xvfb", "dbus-daemon", "openbox", "xdotool", "ldd")
_LAUNCHER = Path("/usr/share/dbus-1/services/org.a11y.Bus.service")
_REGISTRY = "org.a11y.atspi.Registry"
_ROOT = "/org/a11y/atspi/accessible/root"
_ACCESSIBLE = "org.a11y.atspi.Accessible"
_PROPERTIES = "org.freedesktop.DBus.Properties"
_ACTIVE, _FOCUSED, _SELECTED = 1, 12, 23  # of AtspiStateType


@contextmanager
def desktop() -> Iterator[dict[str, str]]:
    """Run a desktop with an accessibility bus; its environment. Skips where a piece is missing."""
    missing = [tool for tool in _TOOLS if shutil.which(tool) is None]
    missing += [] if _LAUNCHER.exists() else ["at-spi2-core"]
    missing += _libraries_missing()
    if missing:
        pytest.skip(f"no desktop to listen to, for want of {', '.join(missing)} (see .ci/run)")
    with ExitStack() as stack:
        # Sockets lie in it, whose paths may not be long.
        home = stack.enter_context(tempfile.TemporaryDirectory(prefix="kogao-"))
        names = ("HOME", "XDG_RUNTIME_DIR", "XDG_CONFIG_HOME", "XDG_DATA_HOME", "XDG_CACHE_HOME")
        env = {**os.environ, **dict.fromkeys(names, home), "LC_ALL": "C.UTF-8"}
        for name in ("WAYLAND_DISPLAY", "DBUS_SESSION_BUS_ADDRESS", "QT_QPA_PLATFORM"):
            env.pop(name, None)
        screen = ("Xvfb", "-screen", "0", "1280x900x24", "-nolisten", "tcp", "-displayfd", "1")
        env["DISPLAY"] = f":{stack.enter_context(_running(screen, env))}"
        bus = ("dbus-daemon", "--session", "--nofork", "--print-address=1")
        env["DBUS_SESSION_BUS_ADDRESS"] = stack.enter_context(_running(bus, env))
        stack.enter_context(_running(("openbox", "--startup", "echo ready"), env))
        yield env


def _libraries_missing() -> list[str]:
    """Return what Qt needs of X and doesn't find."""
    plugins = Path(QLibraryInfo.path(QLibraryInfo.LibraryPath.PluginsPath))
    command = ("ldd", plugins / "platforms" / "libqxcb.so")
    listed = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    return [line.split()[0] for line in listed.splitlines() if line.endswith("not found")]


@contextmanager
def _running(command: tuple[str, ...], env: dict[str, str]) -> Iterator[str]:
    """Run a program; yields the first line that it prints, which it does when it is ready."""
    process = subprocess.Popen(
        command, env=env, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    )
    try:
        yield process.stdout.readline().strip()
    finally:
        process.terminate()
        process.wait()
        process.stdout.close()


class Thing(NamedTuple):
    """An object of a program: the program's name on the bus, and its own there."""

    bus: str
    path: str


class ScreenReader:
    """A screen reader: asks objects what they are, and hears what they tell."""

    def __init__(self, env: dict[str, str]) -> None:
        self._env = env
        with open_dbus_connection(env["DBUS_SESSION_BUS_ADDRESS"]) as session:
            a11y = jeepney.DBusAddress("/org/a11y/bus", "org.a11y.Bus", "org.a11y.Bus")
            call = jeepney.new_method_call(a11y, "GetAddress")
            (address,) = session.send_and_get_reply(call).body
            # What a screen reader does first: programs tell nothing unless there is one.
            status = jeepney.DBusAddress("/org/a11y/bus", "org.a11y.Bus", _PROPERTIES)
            for name in ("IsEnabled", "ScreenReaderEnabled"):
                body = ("org.a11y.Status", name, ("b", True))
                call = jeepney.new_method_call(status, "Set", "ssv", body)
                assert session.send_and_get_reply(call).header.message_type.name == "method_return"
        self._bus = open_dbus_connection(address)
        self._heard: deque[Any] = deque()
        self.said: list[str] = []
        self.focus: Thing | None = None
        for kind in ("object:", "focus:"):
            self._call(_REGISTRY, "/org/a11y/atspi/registry", _REGISTRY, "RegisterEvent", kind)
        for kind in ("Object", "Focus"):
            rule = jeepney.MatchRule(type="signal", interface=f"org.a11y.atspi.Event.{kind}")
            self._bus.send_and_get_reply(jeepney.message_bus.AddMatch(rule))
            self._bus.filter(rule, queue=self._heard)

    def close(self) -> None:
        """Leave the bus."""
        self._bus.close()

    def _call(self, bus: str, path: str, interface: str, name: str, *texts: Any) -> tuple[Any, ...]:
        kinds = "".join("i" if isinstance(text, int) else "s" for text in texts) or None
        address = jeepney.DBusAddress(path, bus, interface)
        call = jeepney.new_method_call(address, name, kinds, texts)
        reply = self._bus.send_and_get_reply(call, timeout=LONGEST_S)
        if reply.header.message_type is jeepney.MessageType.error:
            raise LookupError(f"{name} of {path}: {reply.body}")
        return reply.body

    def _property(self, thing: Thing, name: str, interface: str = _ACCESSIBLE) -> Any:
        return self._call(*thing, _PROPERTIES, "Get", interface, name)[0][1]

    def name(self, thing: Thing) -> str:
        return self._property(thing, "Name")

    def description(self, thing: Thing) -> str:
        return self._property(thing, "Description")

    def role(self, thing: Thing) -> str:
        return self._call(*thing, _ACCESSIBLE, "GetRoleName")[0]

    def value(self, thing: Thing) -> float:
        return self._property(thing, "CurrentValue", "org.a11y.atspi.Value")

    def extents(self, thing: Thing) -> tuple[int, int, int, int]:
        """Where it lies on the screen: x, y, width, height, px."""
        (extents,) = self._call(*thing, "org.a11y.atspi.Component", "GetExtents", 0)
        return extents

    def press(self, thing: Thing) -> None:
        """Take its first action."""
        assert self._call(*thing, "org.a11y.atspi.Action", "DoAction", 0) == (True,)

    def selected(self, thing: Thing) -> bool:
        return self._has(thing, _SELECTED)

    def focused(self, thing: Thing) -> bool:
        return self._has(thing, _FOCUSED)

    def _has(self, thing: Thing, state: int) -> bool:
        low, high = self._call(*thing, _ACCESSIBLE, "GetState")[0]
        return bool((low | high << 32) >> state & 1)

    def children(self, thing: Thing) -> list[Thing]:
        return [Thing(*child) for child in self._call(*thing, _ACCESSIBLE, "GetChildren")[0]]

    def all(self, within: Thing = Thing(_REGISTRY, _ROOT)) -> Iterator[Thing]:  # noqa: B008
        """Yield everything that there is, as a walk through all windows finds it."""
        yield within
        for child in self.children(within):
            yield from self.all(child)

    def find(self, role: str, name: str) -> Thing:
        """Return the one thing of a role whose name begins so, once it is there."""

        def found() -> Thing | None:
            alike = (thing for thing in self.all() if self.role(thing) == role)
            return next((thing for thing in alike if self.name(thing).startswith(name)), None)

        return self.until(found, f"{role} {name!r}")

    def in_front(self, name: str) -> Thing:
        """Wait until the window whose name begins so gets the keys."""
        frame = self.find("frame", name)
        self.until(lambda: self._has(frame, _ACTIVE), f"{name} in front")
        return frame

    def listen(self) -> None:
        """Take in what programs have told since."""
        # A call comes back behind all that was told before it.
        self._call(_REGISTRY, _ROOT, _ACCESSIBLE, "GetRoleName")
        while self._heard:
            message = self._heard.popleft()
            fields = message.header.fields
            member = fields[jeepney.HeaderFields.member]
            if member == "Announcement":
                self.said.append(message.body[3][1])
            elif member == "Focus":
                path = fields[jeepney.HeaderFields.path]
                self.focus = Thing(fields[jeepney.HeaderFields.sender], path)

    def until(self, ask: Callable[[], Any], what: str) -> Any:
        """Ask until there is an answer."""
        end = time.monotonic() + LONGEST_S
        while time.monotonic() < end:
            self.listen()
            answer = ask()
            if answer:
                return answer
            time.sleep(0.05)
        raise AssertionError(f"never heard: {what}; said: {self.said}; focus: {self.in_focus()}")

    def in_focus(self) -> str:
        """Return role and name of the focused object; empty if a closed dialog contained it."""
        try:
            return "" if self.focus is None else f"{self.role(self.focus)} {self.name(self.focus)}"
        except LookupError:
            return ""

    def hears(self, text: str) -> str:
        """Wait for an announcement that begins so, and forget those up to it."""

        def found() -> str | None:
            return next((said for said in self.said if said.startswith(text)), None)

        said = self.until(found, text)
        del self.said[: self.said.index(said) + 1]
        return said

    def focus_on(self, text: str) -> Thing:
        """Wait until the focus is on something, told by its role and name."""
        self.until(lambda: self.in_focus().startswith(text), f"focus on {text}")
        return self.focus

    def tab_to(self, text: str) -> Thing:
        """Press Tab until the focus is on something, told by its role and name."""
        on_the_way: list[Thing | None] = []
        while not self.in_focus().startswith(text):
            assert self.focus not in on_the_way, f"Tab never gets to {text}"
            on_the_way.append(self.focus)
            self.keys("Tab")
            self.until(lambda: self.focus != on_the_way[-1], "another focus")
        return self.focus

    def keys(self, *names: str) -> None:
        """Press keys, as a keyboard does."""
        subprocess.run(["xdotool", "key", *names], env=self._env, check=True)

    def types(self, text: str) -> None:
        """Type a text."""
        subprocess.run(["xdotool", "type", text], env=self._env, check=True)
