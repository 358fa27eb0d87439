"""Three ways to work in one window: what each shows, keeps and leaves alone."""

import re
from pathlib import Path

import pytest
from kogao_app.__main__ import _parse
from kogao_app.canvas.overlays.listed import LISTED
from kogao_app.workspaces import WORKSPACES
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QAbstractButton, QDockWidget, QTabBar, QToolButton

ROOT = Path(__file__).parents[2]
LEAST = (1024, 700)
KEYS, ALT = Qt.Key, Qt.KeyboardModifier.AltModifier


def features(driver):
    return {it.name: it for it in driver.editor.features if it.panel is not None}


def docks_of(driver):
    """Which docks are shown, but for that of photos in a folder."""
    docks = {dock.objectName(): not dock.isHidden() for dock in driver.docks}
    return {name for name, shown in docks.items() if shown}


@pytest.fixture
def window(start, photo):
    driver = start(photo, workspace=None)
    driver.docks = driver.window.findChildren(QDockWidget)
    return driver


def test_a_workspace_follows_from_its_declaration(window):
    there = features(window)
    beside = {name for name, it in there.items() if it.dock is None}
    docked = set(there) - beside
    for workspace in WORKSPACES.values():
        assert set(workspace.panels) <= set(there)
        assert set(workspace.overlays) <= {one.name for one in LISTED}
        inserted = {None, "hold-original"}
        assert set(workspace.tools) - inserted <= set(window.window.actions_by_name)
        action = window.window.actions_by_name[f"workspace-{workspace.name}"]
        assert action.shortcut().toString() == workspace.key
        action.trigger()
        assert window.editor.view.switched == set(workspace.overlays)
        shown = {name for name in beside if there[name].panel.isVisible()}
        assert shown == beside & set(workspace.panels)
        assert docks_of(window) == {"settings", *(docked & set(workspace.panels))}
    named = {name for one in WORKSPACES.values() for name in one.panels}
    assert set(there) - named == {"manual", "protect", "push", "strip"}, (
        "these come when they are needed"
    )


def test_a_workspace_is_in_the_menu_the_options_and_the_docs(window):
    actions = window.window.actions_by_name
    assert actions[f"workspace-{next(iter(WORKSPACES))}"].isChecked(), "a new user begins in it"
    view = next(m for m in window.window.menuBar().actions() if m.text() == "&View")
    docs = (ROOT / "docs/inspect.md").read_text(encoding="utf-8")
    for workspace in WORKSPACES.values():
        assert actions[f"workspace-{workspace.name}"] in view.menu().actions()
        assert _parse(["--workspace", workspace.name]).workspace == workspace.name
        row = rf"\| \*\*{workspace.title}\*\* \| `{re.escape(workspace.key)}` \|"
        assert re.search(row, docs)


def test_switching_changes_what_is_shown_and_never_the_document(window):
    window.set("percent", 6.0)
    window.key(KEYS.Key_B)
    before, steps = window.state, window.editor.document.undo.count()
    for key in (KEYS.Key_2, KEYS.Key_3, KEYS.Key_1):
        window.key(key, ALT)
        window.settle()
    assert window.state is before
    assert window.editor.document.undo.count() == steps
    assert window.editor.view.brush.tool == "brush"


def test_the_switch_on_the_toolbar_leads_to_each(window):
    for name, one in WORKSPACES.items():
        buttons = window.window.findChildren(QToolButton)
        (button,) = [b for b in buttons if b.property("part") and b.accessibleName() == one.title]
        assert button.isVisible()
        QTest.mouseClick(button, Qt.MouseButton.LeftButton)
        assert window.window.actions_by_name[f"workspace-{name}"].isChecked()


def test_each_is_left_as_the_user_left_it_until_it_is_reset(window, start):
    window.key(KEYS.Key_T)
    next(one for one in window.docks if one.objectName() == "faces").toggleViewAction().trigger()
    window.key(KEYS.Key_3, ALT)
    assert "landmarks" in window.editor.view.switched
    assert "faces" in docks_of(window)
    window.key(KEYS.Key_G)
    window.key(KEYS.Key_O)
    window.editor.close()
    later = start(workspace=None)
    later.docks = later.window.findChildren(QDockWidget)
    assert later.window.actions_by_name["workspace-inspect"].isChecked()
    assert {"landmarks", "lattice"} <= later.editor.view.switched, "hidden for a moment, not off"
    later.key(KEYS.Key_1, ALT)
    assert "targets" in later.editor.view.switched
    assert "faces" not in docks_of(later)
    later.window.actions_by_name["reset-workspace"].trigger()
    assert later.editor.view.switched == set(WORKSPACES["retouch"].overlays)
    assert "faces" in docks_of(later)
    later.key(KEYS.Key_3, ALT)
    assert "lattice" in later.editor.view.switched, "only the one that is shown is reset"


def test_what_is_unfolded_is_remembered_by_each_workspace(window, start):
    QTest.mouseClick(window.panel("recipe").more.button, Qt.MouseButton.LeftButton)
    QTest.mouseClick(window.panel("recipe").fold.button, Qt.MouseButton.LeftButton)
    window.key(KEYS.Key_2, ALT)
    assert not window.panel("recipe").lattice.isVisible()
    window.key(KEYS.Key_1, ALT)
    assert window.panel("recipe").lattice.isVisible()
    window.editor.close()
    later = start(workspace=None)
    panel = later.panel("recipe")
    assert panel.choices["fit"].isVisible()
    later.key(KEYS.Key_3, ALT)
    assert panel.lattice.isVisible(), "there it stands without a fold"
    assert not panel.choices["fit"].isVisible()
    later.key(KEYS.Key_1, ALT)
    later.window.actions_by_name["reset-workspace"].trigger()
    assert not panel.lattice.isVisible()


def test_no_tab_of_another_workspace_lies_on_the_photo(window):
    for name in ("inspect", "retouch", "inspect", "compare"):
        window.window.actions_by_name[f"workspace-{name}"].trigger()
        window.settle()
        (tabs,) = window.window.findChildren(QTabBar)
        window.qtbot.waitUntil(lambda: (tabs.x() >= 0) == (name == "inspect"))  # noqa: B023


@pytest.mark.parametrize("stored", [b"nonsense", "text"])
def test_an_arrangement_that_cannot_be_read_is_the_first_one(start, storage, stored):
    storage.settings().setValue("workspaces/now", "elsewhere")
    storage.settings().setValue("workspaces/retouch/docks", stored)
    storage.settings().setValue("workspaces/retouch/overlays", "landmarks,none")
    driver = start(workspace=None)
    driver.docks = driver.window.findChildren(QDockWidget)
    assert docks_of(driver) == {"settings", "faces"}
    assert driver.editor.view.switched == {"landmarks"}


def test_panels_come_when_they_are_needed_and_go_again(window):
    protect, manual = window.panel("protect"), window.panel("manual")
    assert not protect.isVisible()
    window.key(KEYS.Key_B)
    assert protect.isVisible()
    window.key(KEYS.Key_A)
    assert not protect.isVisible()
    window.editor.manual.switch("manual")
    assert manual.isVisible()
    window.key(KEYS.Key_F2)
    assert not manual.isVisible()


def test_one_click_that_is_seen_leads_back_from_points_set_by_hand(window):
    window.window.resize(*LEAST)
    words = {"Automatic", "Back to automatic"}
    for _ in window.workspaces():
        window.editor.manual.switch("manual")
        window.settle()
        buttons = [b for b in window.window.findChildren(QAbstractButton) if b.text() in words]
        (back,) = [one for one in buttons if not one.visibleRegion().isEmpty()]
        QTest.mouseClick(back, Qt.MouseButton.LeftButton)
        assert window.state.mode == "automatic"
        assert back.text() == "Automatic" or not back.isVisible()


def test_tools_by_hand_lie_open_where_points_are_set_by_hand(window):
    window.editor.manual.switch("manual")
    panel = window.panel("manual")
    mirror = next(one for one in panel.findChildren(QToolButton) if one.text() == "Mirror")
    assert not mirror.isVisible()
    QTest.mouseClick(panel.fold.button, Qt.MouseButton.LeftButton)
    assert mirror.isVisible()
    window.key(KEYS.Key_1, ALT)
    assert mirror.isVisible()
    for key in (KEYS.Key_2, KEYS.Key_3):
        window.key(key, ALT)
        assert mirror.isVisible()
        assert panel.time.isVisible()


def test_what_the_mouse_does_is_said_where_marks_step_back(window):
    assert window.window.status.hint_text.startswith("Hover over the face to show its points")
    window.key(KEYS.Key_3, ALT)
    assert window.window.status.hint_text == "Drag a point to correct it"


def test_the_film_strip_stays_through_a_switch(window, photo):
    window.editor.strip.show_places([photo.parent])
    window.settle()
    film = window.editor.strip.film
    assert film.isVisible()
    assert film.height() == film.minimumHeight(), "one row; the rest is the photo's"
    for key in (KEYS.Key_2, KEYS.Key_3, KEYS.Key_1):
        window.key(key, ALT)
        assert "strip" in docks_of(window)


def test_menus_of_experiments_and_manual_mode_show_where_they_are_used(empty):
    menus = {one.text().replace("&", ""): one for one in empty.window.menuBar().actions()}
    for workspace in empty.workspaces():
        shown = {name for name in ("Manual", "Experiments") if menus[name].isVisible()}
        assert shown == set(EXTRA[workspace]), workspace


EXTRA = {"retouch": (), "compare": ("Manual", "Experiments"), "inspect": ("Manual", "Experiments")}
