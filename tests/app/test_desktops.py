"""What differs between desktops: colour schemes, keyboard layouts, profiles of screens."""

import sys

import pytest
from kogao_app.features import screen
from PySide6.QtCore import QCoreApplication, QEvent, Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtTest import QTest

pytestmark = [
    pytest.mark.usefixtures("one_window"),
    pytest.mark.skipif(sys.platform != "linux", reason="key codes and portals of Linux"),
]
NONE, CONTROL, ALT = (
    getattr(Qt.KeyboardModifier, f"{n}Modifier") for n in ("No", "Control", "Alt")
)
EF, CHE, GREEK_PHI = 0x0424, 0x0427, 0x03A6


def typed(driver, key, code, modifiers=NONE):
    """Press a key of a layout without Latin letters."""
    event = QKeyEvent(QEvent.Type.KeyPress, key, modifiers, code, 0, 0, chr(key))
    QCoreApplication.sendEvent(driver.canvas, event)


def test_letters_work_with_a_layout_that_has_none_of_them(opened):
    wipe = opened.window.actions_by_name["compare-wipe"]
    typed(opened, CHE, 25)
    assert wipe.isChecked(), "W"
    typed(opened, ord("W"), 25)
    assert not wipe.isChecked(), "Latin letters are Qt's, and count once"
    opened.edit(9.0)
    typed(opened, EF, 52, CONTROL)
    assert opened.state.recipe.percent != 9.0, "Ctrl+Z"
    typed(opened, GREEK_PHI, 41, ALT)
    assert opened.window.menuBar().activeAction().text() == "&File"
    QTest.keyClick(opened.window.menuBar().activeAction().menu(), Qt.Key.Key_Escape)


@pytest.mark.parametrize("variants", [1, 2])
def test_the_portal_tells_whether_the_desktop_is_light(qtbot, variants):
    portal = pytest.importorskip("kogao_app.portal")
    dbus = pytest.importorskip("PySide6.QtDBus")
    found = portal.Portal(QCoreApplication.instance())

    def tell(scheme, group="org.freedesktop.appearance"):
        value = scheme
        for _ in range(variants):
            value = dbus.QDBusVariant(value)
        signal = dbus.QDBusMessage.createSignal("/x", "org.x", "SettingChanged")
        signal.setArguments([group, "color-scheme", value])
        found.hear(signal)

    with qtbot.waitSignal(found.changed):
        tell(2)
    assert found.is_light
    tell(1, "org.other")
    assert found.is_light, "another setting"
    tell(1)
    assert not found.is_light
    found.deleteLater()


def test_a_profile_that_changed_meanwhile_is_read_when_the_window_is_active(opened, monkeypatch):
    asked = []
    monkeypatch.setattr(screen, "profile_of", lambda *place: asked.append(place))
    opened.window.activated.emit(True)
    assert len(asked) == 1
