"""What lies round the work: presets, recent photos, film strip, palette, keys, panels."""

import shutil
from collections import Counter

import cv2
import pytest
from kogao_app import theme
from kogao_app.features import recent
from kogao_app.features.commands import Palette
from kogao_app.features.recent import EmptyState
from kogao_app.features.strip import photos_in
from kogao_app.features.strip.facts import thumbnail
from kogao_app.features.strip.film import FilmStrip
from PIL import Image as PillowImage
from PySide6.QtCore import QMimeData, QPointF, Qt, QUrl
from PySide6.QtGui import QDesktopServices, QDragEnterEvent, QDropEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QApplication,
    QDockWidget,
    QFileDialog,
    QInputDialog,
    QLineEdit,
    QToolButton,
)
from scenes import textured_photo

from kogao_core.recipe.recipe import PAPER, Recipe

KEYS, CONTROL, SHIFT = (
    Qt.Key,
    Qt.KeyboardModifier.ControlModifier,
    Qt.KeyboardModifier.ShiftModifier,
)
ALT = Qt.KeyboardModifier.AltModifier
in_one_window = pytest.mark.usefixtures("one_window")


def drop(driver, *paths):
    data = QMimeData()
    data.setUrls([QUrl.fromLocalFile(str(path)) for path in paths])
    drop_data(driver, data)


def drop_data(driver, data):
    at, copy = QPointF(300, 300), Qt.DropAction.CopyAction
    held = (data, Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier)
    QApplication.sendEvent(driver.window, QDragEnterEvent(at.toPoint(), copy, *held))
    QApplication.sendEvent(driver.window, QDropEvent(at, copy, *held))
    driver.settle()
    driver.settle()


# -- history and the guard -------------------------------------------------------------------------


@in_one_window
def test_the_history_lists_gestures_and_leads_back(opened):
    opened.change_something()
    opened.set("lattice", 2.0)
    view = opened.panel("history")
    texts = [view.model().index(row, 0).data() for row in range(view.model().rowCount())]
    rows = ["As it was opened", "Amount 4.0 → 5.0 % of D", "Falloff 1.0 → 2.0"]
    assert texts == rows
    opened.editor.window.docks.show("history")
    opened.qtbot.waitUntil(view.isVisible)
    first = view.visualRect(view.model().index(0, 0)).center()
    said = opened.window.status
    QTest.mouseClick(view.viewport(), Qt.MouseButton.LeftButton, pos=first)
    assert opened.state.recipe == Recipe(percent=4.0)
    assert opened.editor.document.undo.canRedo()
    assert said.hint_text == "Undone: 2 steps"
    opened.press_key(view, KEYS.Key_Down)
    assert said.hint_text == "Done again: Amount 4.0 → 5.0 % of D"


@pytest.mark.usefixtures("unkept", "one_window")
def test_opening_another_photo_asks_before_changes_are_lost(opened, other):
    opened.change_something()
    for answer in ("Cancel", "Discard"):
        drop(opened, other)
        opened.answer(answer)
        opened.settle()
        assert (opened.editor.document.path == other) == (answer == "Discard")


# -- presets ---------------------------------------------------------------------------------------


@in_one_window
def test_the_papers_settings_are_a_preset(opened):
    opened.choose("presets", "The paper's")
    assert opened.state.recipe == PAPER
    assert opened.editor.document.undo.undoText() == "Preset The paper's"


def test_settings_are_kept_under_a_name_and_used_again(opened, start, photo):
    opened.change_something()
    opened.key(KEYS.Key_S, CONTROL, ALT)
    asked = opened.dialog(QInputDialog)
    line = asked.findChild(QLineEdit)
    QTest.keyClicks(line, "Wedding")
    QTest.keyClick(line, KEYS.Key_Return)
    other = start(photo)
    other.choose("presets", "Wedding")
    assert other.state.recipe.percent == 5.0
    removal = next(a for a in other.window.menus["presets"].actions() if a.menu()).menu()
    removal.aboutToShow.emit()
    next(one for one in removal.actions() if "Wedding" in one.text()).trigger()
    other.window.menus["presets"].aboutToShow.emit()
    assert "Wedding" not in [a.text() for a in other.window.menus["presets"].actions()]


@in_one_window
def test_a_preset_gives_a_chosen_face_settings_of_its_own(opened):
    opened.editor.recipe.choose(0)
    opened.choose("presets", "Small face")
    assert opened.state.faces[0].recipe.percent == 6.0
    assert opened.state.recipe.percent == 4.0


def test_the_menu_opens_the_folder_of_preset_files(opened, storage, monkeypatch):
    shown = []
    monkeypatch.setattr(QDesktopServices, "openUrl", shown.append)
    opened.choose("presets", "Open preset folder")
    assert shown == [QUrl.fromLocalFile(str(storage.presets))]
    (storage.presets / "Laid here.json").write_text('{"percent": 7}')
    opened.choose("presets", "Laid here")
    assert opened.state.recipe.percent == 7.0


def test_a_preset_that_cannot_be_written_gets_a_sentence(opened, storage):
    storage.data.mkdir(parents=True, exist_ok=True)
    storage.presets.write_text("a file where the folder should be")
    opened.key(KEYS.Key_S, CONTROL, ALT)
    opened.dialog(QInputDialog).textValueSelected.emit("Mine")
    assert "can't be written" in opened.say()


# -- recent photos, the film strip -----------------------------------------------------------------


def test_opened_photos_are_offered_again(opened, start, photo, tmp_path):
    other = tmp_path / "a&b.png"
    shutil.copy(photo, other)
    opened.open(other)
    later = start()
    later.window.menus["recent"].aboutToShow.emit()
    texts = [action.text() for action in later.window.menus["recent"].actions()]
    assert texts[:2] == ["a&&b.png", "portrait.png"]
    later.choose("recent", "portrait.png")
    later.settle()
    assert later.editor.document.path == photo
    later.choose("recent", "Clear list")
    later.window.menus["recent"].aboutToShow.emit()
    assert not any("portrait" in action.text() for action in later.window.menus["recent"].actions())


def test_photos_of_one_name_are_told_apart_by_their_folders(storage, tmp_path):
    places = [tmp_path / "a" / "x" / "1.png", tmp_path / "b" / "x" / "1.png"]
    other, single = tmp_path / "c" / "1.png", tmp_path / "c" / "2.png"
    assert recent.titles([places[0], other, single]) == [
        "1.png – x",  # noqa: RUF001
        "1.png – c",  # noqa: RUF001
        "2.png",
    ]
    assert recent.titles(places) == [f"1.png – {place.parent}" for place in places]  # noqa: RUF001
    settings = storage.settings()
    for path in (*places, other):
        recent.add(settings, path)
    other.parent.mkdir()
    other.touch()
    assert recent.there(settings) == [other], "the others are gone, or their drive is away"
    assert len(recent.paths(settings)) == 3


def test_recent_photos_are_ten_at_most_and_each_once(storage, tmp_path):
    settings = storage.settings()
    for number in (*range(12), 5):
        recent.add(settings, tmp_path / f"{number}.png")
    names = [path.stem for path in recent.paths(settings)]
    assert names == ["5", "11", "10", "9", "8", "7", "6", "4", "3", "2"]


@pytest.fixture
def folder(tmp_path):
    place = tmp_path / "shoot"
    place.mkdir()
    for number in range(3):
        assert cv2.imwrite(str(place / f"{number}.png"), textured_photo(seed=number))
    (place / "notes.txt").write_text("no photo")
    (place / "broken.jpg").write_bytes(b"no photo either")
    return place


@pytest.fixture
def shoot(empty, folder):
    """An editor with the folder on its strip and the first photo open."""
    drop(empty, folder)
    return empty


def texts(strip):
    return [strip.item(row).text() for row in range(strip.count())]


def test_dropped_photos_become_a_film_strip(shoot, folder):
    strip = shoot.editor.strip.film
    assert texts(strip) == ["0.png", "1.png", "2.png", "broken.jpg"]
    assert strip.isVisible()
    assert shoot.editor.document.path == folder / "0.png"
    assert strip.currentRow() == 0
    at = strip.visualItemRect(strip.item(2)).center()
    QTest.mouseClick(strip.viewport(), Qt.MouseButton.LeftButton, pos=at)
    shoot.settle()
    assert shoot.editor.document.path == folder / "2.png"
    shoot.key(KEYS.Key_Left, CONTROL)
    shoot.settle()
    assert shoot.editor.document.path == folder / "1.png"
    assert strip.currentRow() == 1
    drop(shoot, folder / "2.png", folder / "0.png")
    assert texts(strip) == ["2.png", "0.png"], "several photos make a strip of them"


def test_a_photo_that_comes_into_the_folder_comes_onto_the_strip(shoot, folder):
    shutil.copy(folder / "0.png", folder / "3.png")
    shoot.qtbot.waitUntil(lambda: shoot.editor.strip.film.count() == 5)
    shoot.settle()
    assert shoot.editor.document.path == folder / "0.png"


@pytest.mark.usefixtures("unkept")
def test_the_strip_keeps_to_the_open_photo_when_its_changes_are_kept(shoot):
    shoot.change_something()
    strip = shoot.editor.strip.film
    at = strip.visualItemRect(strip.item(1)).center()
    QTest.mouseClick(strip.viewport(), Qt.MouseButton.LeftButton, pos=at)
    shoot.answer("Cancel")
    assert strip.currentRow() == 0


def test_a_thumbnail_that_fails_keeps_none_from_the_others(empty, folder, monkeypatch):
    drawn = []

    def draw(path, *_):
        if path.name == "0.png":
            raise MemoryError
        drawn.append(path.name)
        return thumbnail(path, 72)

    monkeypatch.setattr("kogao_app.features.strip.thumbnail", draw)
    drop(empty, folder)
    assert drawn == ["1.png", "2.png", "broken.jpg"]


def test_the_keys_get_past_a_photo_that_cannot_be_opened(empty, folder):
    shutil.copy(folder / "0.png", folder / "last.png")
    drop(empty, folder)
    said = []
    for name in ("1.png", "2.png", "2.png", "last.png"):
        empty.key(KEYS.Key_Right, CONTROL)
        empty.settle()
        assert empty.editor.document.path == folder / name
        said.append("broken.jpg" in empty.say())
    assert said == [False, False, True, False]


def test_steps_count_from_the_photo_that_is_being_opened(shoot, folder):
    """Two presses lead two photos on, however long the first takes."""
    strip, status = shoot.editor.strip.film, shoot.window.status
    strip.step(1)
    assert status.hint_text == "Opening 1.png…"
    strip.step(-1)
    assert "Opening" not in status.hint_text
    shoot.settle()
    assert shoot.editor.document.path == folder / "0.png", "a step back calls the next one off"
    assert strip.currentRow() == 0
    strip.step(1)
    strip.step(1)
    shoot.settle()
    assert shoot.editor.document.path == folder / "2.png"
    assert strip.currentRow() == 2


@pytest.mark.usefixtures("storage")
@pytest.mark.parametrize(
    ("names", "photos", "said"),
    [
        (["."], 4, ""),
        (["2.png", "0.png"], 2, ""),
        (["0.png", "notes.txt", "gone.png"], 1, "notes.txt, gone.png"),
    ],
)
def test_a_folder_or_photos_on_the_command_line_become_a_film_strip(
    run_main, folder, monkeypatch, names, photos, said
):
    monkeypatch.chdir(folder)
    seen = []

    def look(window):
        strip, bar = window.findChild(FilmStrip), window.bar
        if window.windowTitle() == "Kogao[*]" or strip.currentItem() is None:
            return False
        marked = strip.currentItem().text()
        seen.extend((window.windowTitle(), marked, strip.count()))
        seen.append(bar.accessibleDescription() if bar.isVisible() else "")
        return window.close()

    assert run_main(names, look) == 0
    first = names[0] if names != ["."] else "0.png"
    assert seen[:3] == [f"{first}[*] – Kogao", first, photos]  # noqa: RUF001
    assert said in seen[3]
    assert bool(said) == bool(seen[3])


def test_the_start_card_goes_while_a_photo_is_read_and_comes_back_if_that_fails(empty, folder):
    empty.editor.strip.show_places([folder / "broken.jpg"])
    assert not empty.editor.recent.empty.isVisible()
    empty.settle()
    assert "broken.jpg" in empty.say()
    assert empty.editor.recent.empty.isVisible()


def test_a_strip_without_photos_is_hidden_at_the_next_start(shoot, start, folder):
    assert shoot.editor.strip.film.isVisible()
    shoot.editor.close()
    later = start(folder / "0.png")
    assert dock(later, "strip").isHidden()
    assert later.panel("readings").isVisible()


def test_the_panel_of_the_strip_is_only_there_with_something_on_it(empty, folder, tmp_path):
    toggle = dock(empty, "strip").toggleViewAction()
    assert not toggle.isVisible()
    empty.open(folder / "0.png")
    assert not toggle.isVisible()
    steps = [empty.window.actions_by_name[name] for name in ("next-photo", "previous-photo")]
    assert not any(step.isEnabled() for step in steps)
    drop(empty, folder)
    assert toggle.isVisible()
    assert all(step.isEnabled() for step in steps)
    (tmp_path / "none").mkdir()
    drop(empty, tmp_path / "none")
    assert toggle.isVisible(), "an empty folder chosen by mistake leaves the strip alone"
    assert "No photos in this folder" in empty.say()


@in_one_window
def test_what_is_dropped_from_elsewhere_gets_a_sentence(opened, photo):
    data = QMimeData()
    data.setUrls([QUrl("https://example.com/portrait.jpg")])
    drop_data(opened, data)
    assert "isn't a file on this computer" in opened.say()
    assert opened.editor.document.path == photo


def test_a_folder_can_be_chosen_by_key(empty, folder):
    empty.key(KEYS.Key_O, CONTROL, SHIFT)
    asked = empty.dialog(QFileDialog)
    assert asked.fileMode() == QFileDialog.FileMode.Directory
    empty.choose_path(folder)
    empty.settle()
    empty.qtbot.waitUntil(lambda: empty.editor.document.path == folder / "0.png")


def test_what_qt_cannot_read_has_a_thumbnail(tmp_path):
    picture, turned = PillowImage.fromarray(textured_photo(300, 200)), 6
    picture.save(tmp_path / "a.tif", compression="jpeg", tiffinfo={274: turned})
    image = thumbnail(tmp_path / "a.tif", 144).picture
    assert (image.width(), image.height()) == (96, 144)


def test_thumbnails_are_small_and_a_broken_file_has_none(folder):
    image = thumbnail(folder / "0.png").picture
    assert 0 < max(image.width(), image.height()) <= 144
    assert thumbnail(folder / "broken.jpg").picture.isNull()
    assert photos_in([folder / "gone"]) == []


# -- palette and keys ------------------------------------------------------------------------------


@in_one_window
def test_the_palette_finds_and_runs_a_command(opened):
    opened.key(KEYS.Key_P, CONTROL, SHIFT)
    palette = opened.dialog(Palette)
    QTest.keyClicks(palette.words, "place hand")
    shown = [palette.list.item(r) for r in range(palette.list.count())]
    assert [item.text() for item in shown if not item.isHidden()] == [
        "Place a face by hand   Ctrl+P"
    ]
    QTest.keyClick(palette.words, KEYS.Key_Return)
    assert opened.editor.view.placing == 1


@in_one_window
def test_arrows_walk_through_the_palette(opened):
    before = opened.state
    opened.key(KEYS.Key_P, CONTROL, SHIFT)
    palette = opened.dialog(Palette)
    QTest.keyClicks(palette.words, "zoom")
    first = palette.list.currentRow()
    QTest.keyClick(palette.words, KEYS.Key_Down)
    assert palette.list.currentItem().text().startswith("Zoom in")
    assert palette.list.currentRow() > first
    QTest.keyClicks(palette.words, "qqq")
    QTest.keyClick(palette.words, KEYS.Key_Return)
    assert opened.state is before, "nothing is found, nothing runs"
    QTest.keyClick(palette.words, KEYS.Key_Escape)
    assert not palette.isVisible()


def test_every_action_has_a_tip_and_no_key_belongs_to_two(empty):
    actions = empty.window.actions_by_name.values()
    for action in actions:
        assert action.text()
        assert action.statusTip()
    keys = [key.toString() for action in actions for key in action.shortcuts()]
    assert len(keys) > 40
    assert [key for key, times in Counter(keys).items() if times > 1] == []


# -- panels ----------------------------------------------------------------------------------------


def dock(driver, name):
    return driver.window.findChild(QDockWidget, name)


@in_one_window
def test_all_panels_go_and_come_back_with_one_key(opened):
    def in_front(name):
        return not dock(opened, name).visibleRegion().isEmpty()

    opened.window.docks.show("history")
    opened.qtbot.waitUntil(lambda: in_front("history") and not in_front("readings"))
    width = opened.canvas.width()
    opened.key(KEYS.Key_F8)
    opened.qtbot.waitUntil(lambda: opened.canvas.width() > width)
    assert dock(opened, "settings").isHidden()
    opened.key(KEYS.Key_F8)
    opened.qtbot.waitUntil(lambda: opened.canvas.width() == width)
    opened.qtbot.waitUntil(lambda: in_front("history") and not in_front("readings"))
    assert dock(opened, "strip").isHidden()


def test_panels_are_there_next_time_but_those_that_were_closed(opened, start):
    opened.window.docks.show("history")
    next(it for it in opened.window.docks.toggles() if "Faces" in it.text()).trigger()
    opened.key(KEYS.Key_F8)
    opened.editor.close()
    later = start()
    later.qtbot.waitUntil(lambda: later.panel("history").isVisible())
    assert not dock(later, "settings").isHidden(), "hidden for a moment, not closed"
    assert dock(later, "faces").isHidden()


# -- nothing open ----------------------------------------------------------------------------------


def test_without_a_photo_the_window_says_what_to_do(empty, photo):
    state = empty.editor.recent.empty
    assert state.isVisible()
    middle = state.mapTo(empty.window, state.rect().center())
    assert state.isAncestorOf(empty.window.childAt(middle)) or empty.window.childAt(middle) is state
    QTest.mouseClick(state.buttons[0], Qt.MouseButton.LeftButton)
    asked = empty.dialog(QFileDialog)
    asked.close()
    QTest.mouseClick(state.buttons[2], Qt.MouseButton.LeftButton)
    empty.settle()
    assert empty.editor.document.path.name == "average.jpg"
    assert not state.isVisible()
    empty.open(photo)


def test_without_a_photo_the_last_ones_and_their_folder_are_offered(opened, start, photo):
    later, at_last = start(), start()
    for driver, place in ((later, 1), (at_last, 0)):
        page = driver.editor.recent.empty
        links = [one for one in page.findChildren(QToolButton) if one.isVisible()]
        link, folder = links
        driver.qtbot.waitUntil(lambda: not link.icon().isNull())  # noqa: B023
        assert photo.parent.name in folder.toolTip()
        assert link.text() == "portrait.png"
        QTest.mouseClick((folder, link)[place], Qt.MouseButton.LeftButton)
        driver.settle()
        assert driver.editor.document.path == photo
    assert not later.editor.strip.film.count()
    assert at_last.editor.strip.film.count() == 1
    assert opened.editor.document.path == photo


@pytest.mark.usefixtures("storage")
def test_only_a_new_user_is_welcomed_with_the_sample(run_main):
    starts = []

    def look(window):
        is_empty = window.windowTitle() == "Kogao[*]"
        # The sample is being opened while the start card is hidden.
        if is_empty and not window.findChild(EmptyState).isVisible():
            return False
        starts.append("empty" if is_empty else window.windowTitle())
        return window.close()

    for _ in range(2):
        assert run_main([], look) == 0
    assert starts[0].startswith("average.jpg")
    assert starts[1] == "empty"


@in_one_window
def test_what_lies_round_the_work_has_names_for_screen_readers(opened):
    editor = opened.editor
    for control in (editor.strip.film, editor.history.panel, editor.recent.empty):
        assert control.accessibleName()


@in_one_window
def test_the_window_follows_the_systems_mode(opened, qapp, monkeypatch):
    for mode, wanted in (("light", theme.LIGHT), ("dark", theme.DARK)):
        monkeypatch.setattr(theme, "current", lambda *_, wanted=wanted: wanted)
        qapp.styleHints().colorSchemeChanged.emit(Qt.ColorScheme.Unknown)
        assert opened.window.palette().window().color().name() == wanted.window, mode
