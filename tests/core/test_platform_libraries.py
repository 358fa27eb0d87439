"""Which of Qt's system libraries are asked for: Wayland's, or X's."""

import socket
import sys

import pytest

from kogao_core.base import installed

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="Linux only")


@pytest.fixture
def compositor(tmp_path, monkeypatch):
    """A place where a compositor would answer."""
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    monkeypatch.setenv("WAYLAND_DISPLAY", "wayland-7")
    monkeypatch.delenv("DISPLAY", raising=False)
    with socket.socket(socket.AF_UNIX) as server:
        server.bind(str(tmp_path / "wayland-7"))
        yield server


def without(monkeypatch, part):
    monkeypatch.setattr(installed, "_loads", lambda name: part not in name)


def test_where_a_compositor_answers_no_x_library_is_asked_for(compositor, monkeypatch):
    without(monkeypatch, "libxcb")
    assert installed.missing_libraries(), "nobody answers yet"
    compositor.listen()
    assert installed.missing_libraries() == {}
    without(monkeypatch, "wayland")
    assert set(installed.missing_libraries().values()) == {
        "libwayland-client0", "libwayland-cursor0",
    }  # fmt: skip
    monkeypatch.setenv("DISPLAY", ":0")
    assert installed.missing_libraries() == {}, "Qt takes X instead"


def test_without_a_compositor_no_wayland_library_is_asked_for(monkeypatch):
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    without(monkeypatch, "wayland")
    assert installed.missing_libraries() == {}
    without(monkeypatch, "libxcb-cursor")
    assert installed.missing_libraries() == {"libxcb-cursor.so.0": "libxcb-cursor0"}
