"""A real Chromium without a window, steered through its debugging pipe; skips without one."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path

import pytest
from timeouts import LONGEST_S

_FLAGS = (
    *("--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"),
    *("--disable-sync", "--disable-background-networking", "--disable-component-update"),
    "--disable-dev-shm-usage",  # which is small in containers
    "--remote-debugging-pipe",
)


class Browser:
    """One page. `ask` runs a script in it, and waits for what it promises."""

    def __init__(
        self, profile: Path, size: tuple[int, int] = (1280, 1000), *, kept: bool = False
    ) -> None:
        program = shutil.which("chromium") or shutil.which("chromium-browser")
        if program is None or os.name != "posix":
            pytest.skip("Chromium is absent: the page is driven in none")
        there, answers = os.pipe(), os.pipe()
        flags = (*_FLAGS, f"--user-data-dir={profile}", f"--window-size={size[0]},{size[1]}")
        # Chromium reads commands from its file 3 and answers through 4.
        plumbing = f'exec "$@" 3<&{there[0]} 4>&{answers[1]}'
        self._process = subprocess.Popen(
            ["bash", "-c", plumbing, "bash", program, *flags, "about:blank"],
            pass_fds=(there[0], answers[1]),
            stderr=subprocess.DEVNULL,
        )
        os.close(there[0])
        os.close(answers[1])
        self._to, self._from = os.fdopen(there[1], "wb"), os.fdopen(answers[0], "rb")
        self._number, self._rest, self._session = 0, b"", None
        self._told: list[dict] = []
        self._context: str | None = None
        self.afresh(kept=kept)

    def afresh(self, *, kept: bool = False) -> None:
        """Open a new page: of another user without data, or with the data that the profile kept."""
        self._session = None
        if self._context is not None:
            self.call("Target.disposeBrowserContext", browserContextId=self._context)
        context = {} if kept else self.call("Target.createBrowserContext")
        self._context = context.get("browserContextId")
        page = self.call("Target.createTarget", url="about:blank", **context)
        told = self.call("Target.attachToTarget", targetId=page["targetId"], flatten=True)
        self._session = told["sessionId"]
        self.call("Page.enable")
        self.call("Emulation.setFocusEmulationEnabled", enabled=True)
        self.call("Page.setLifecycleEventsEnabled", enabled=True)

    def call(self, method: str, **parameters):
        """One command of the DevTools protocol, and its result."""
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters}
        if self._session is not None:
            message["sessionId"] = self._session
        self._told.clear()
        self._to.write(json.dumps(message).encode() + b"\0")
        self._to.flush()
        return self._until(lambda told: told.get("id") == self._number)["result"]

    def open(self, address: str) -> None:
        """Load an address and wait until it is there, which may be told before the answer comes."""
        loader = self.call("Page.navigate", url=address)["loaderId"]

        def is_loaded(told) -> bool:
            parameters = told.get("params", {})
            return (parameters.get("name"), parameters.get("loaderId")) == ("load", loader)

        self._until(is_loaded)

    def ask(self, script: str):
        """The value of an expression."""
        told = self.call(
            "Runtime.evaluate", expression=script, awaitPromise=True, returnByValue=True
        )
        assert "exceptionDetails" not in told, told
        return told["result"].get("value")

    def until(self, script: str):
        """Wait until an expression is true, looking after each painted frame."""
        return self.ask(
            f"new Promise((done, failed) => {{ const end = Date.now() + {1e3 * LONGEST_S};"
            f"(function look() {{ if ({script}) done(true); else if (Date.now() > end)"
            f"failed(new Error({json.dumps(script)})); else requestAnimationFrame(look); }})() }})"
        )

    def press(self, key: str, modifiers: int = 0) -> None:
        """Press a key as a hand would."""
        for kind in ("keyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", type=kind, key=key, modifiers=modifiers)

    def resize(self, width: int, height: int, ratio: float = 1.0) -> None:
        """Give the page another viewport, CSS px."""
        self.call(
            "Emulation.setDeviceMetricsOverride",
            width=width, height=height, deviceScaleFactor=ratio, mobile=False,
        )  # fmt: skip

    def close(self) -> None:
        """End it as a user does: the profile is written."""
        self._session = None
        self.call("Browser.close")
        self._process.wait()
        self.kill()

    def kill(self) -> None:
        """End it without a warning, as a crash would."""
        self._process.kill()
        self._process.wait()
        self._to.close()
        self._from.close()

    def _until(self, fits):
        """The first message that fits, of those that came since the last command."""
        for told in self._told:
            if fits(told):
                return told
        while True:
            while b"\0" not in self._rest:
                got = os.read(self._from.fileno(), 1 << 20)
                assert got, "the browser has ended"
                self._rest += got
            line, self._rest = self._rest.split(b"\0", 1)
            told = json.loads(line)
            self._told.append(told)
            if fits(told):
                assert "error" not in told, told
                return told
