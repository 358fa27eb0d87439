"""The list of what is kept, and its deletion by mouse."""

from kogao_app.features.kept import KeptDialog
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QPushButton

from kogao_core.projects.forgetting import kept


def press(dialog, words):
    one = next(b for b in dialog.findChildren(QPushButton) if words in b.text().replace("&", ""))
    QTest.mouseClick(one, Qt.MouseButton.LeftButton)


def test_photos_are_listed_and_deleted_by_photo_or_all(start, photo, other):
    driver = start(photo)
    driver.edit(6.0)
    driver.open(other)
    driver.edit(6.0)
    data = driver.editor.sync.storage.data
    driver.window.actions_by_name["kept"].trigger()
    dialog = driver.dialog(KeptDialog)
    rows = [dialog.list.item(row, 0).text() for row in range(dialog.list.rowCount())]
    assert rows == sorted(map(str, (photo, other)))
    assert "edits" in dialog.list.item(0, 1).text()
    dialog.list.selectRow(rows.index(str(photo)))
    press(dialog, "Delete all of")
    driver.answer("Delete")
    driver.qtbot.waitUntil(lambda: [one.photo for one in kept(data)] == [other])
    driver.settle()
    names = str(driver.editor.sync.settings.value("recent"))
    assert photo.name not in names
    assert other.name in names
    press(driver.dialog(KeptDialog), "Delete everything")
    driver.answer("Delete")
    driver.qtbot.waitUntil(lambda: kept(data) == [])
    assert driver.dialog(KeptDialog).list.rowCount() == 0
