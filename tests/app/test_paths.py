"""Every path that a user chooses is asked for in one place."""

import ast

import pytest
from kogao_app.widgets.dialogs import ask_path
from modules import ROOT, tree
from PySide6.QtWidgets import QFileDialog, QMessageBox

APP = ROOT / "app"
KINDS = ["Pictures (*.png)", "Tables (*.csv)"]


def ask(driver, taken, kind="new", **more):
    return ask_path(driver.window, "Which?", taken.append, kind, **more)


def test_one_module_alone_makes_dialogs_of_files():
    """It must not be of a kind of its own either: Qt gives those no native dialog."""
    makers = {
        path.relative_to(APP).as_posix()
        for path in APP.rglob("*.py")
        for node in ast.walk(tree(path))
        if isinstance(node, ast.Name) and node.id == "QFileDialog"
    }
    assert makers == {"widgets/dialogs.py"}


def test_the_desktops_own_dialog_is_not_refused(hands):
    asked = ask(hands, [])
    assert type(asked) is QFileDialog
    assert asked.metaObject().className() == "QFileDialog"
    assert not asked.testOption(QFileDialog.Option.DontUseNativeDialog)
    asked.reject()


@pytest.mark.parametrize(("kind", "ending"), [(KINDS[0], ".png"), (KINDS[1], ".csv")])
def test_a_name_without_an_ending_gets_that_of_its_kind(hands, tmp_path, kind, ending):
    taken = []
    asked = ask(hands, taken, filters=KINDS, endings=(".png", ".csv"))
    asked.selectNameFilter(kind)
    hands.choose_path(tmp_path / "one")
    assert taken == [tmp_path / f"one{ending}"]


def test_an_ending_that_is_typed_stays(hands, tmp_path):
    taken = []
    ask(hands, taken, filters=KINDS, endings=(".png", ".csv"))
    hands.choose_path(tmp_path / "one.jpg")
    assert taken == [tmp_path / "one.jpg"]


@pytest.mark.parametrize("answer", ["Replace", "Cancel"])
def test_a_file_that_the_dialog_has_not_asked_about_is_asked_about(hands, tmp_path, answer):
    taken = []
    (tmp_path / "one.png").touch()
    ask(hands, taken, filters=KINDS, endings=(".png", ".csv"))
    hands.choose_path(tmp_path / "one")
    assert taken == []
    assert "one.png is there already" in hands.dialog(QMessageBox).text()
    hands.answer(answer)
    assert taken == ([tmp_path / "one.png"] if answer == "Replace" else [])


def test_several_files_come_one_after_the_other(hands, tmp_path):
    taken = []
    asked = ask(hands, taken, "files")
    assert asked.fileMode() == QFileDialog.FileMode.ExistingFiles
    asked.filesSelected.emit([str(tmp_path / "a"), str(tmp_path / "b")])
    asked.reject()
    assert taken == [tmp_path / "a", tmp_path / "b"]


def test_a_dialog_that_is_left_gives_nothing(hands):
    taken = []
    ask(hands, taken).reject()
    assert taken == []
