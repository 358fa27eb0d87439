"""The documentation is read without a network: its pages, their links, pictures and headings."""

import gettext
import re

import pytest
from kogao_app.features import help as helping
from kogao_app.features.help import HelpDialog
from modules import ROOT
from PySide6.QtCore import QPoint, Qt, QUrl
from PySide6.QtGui import QDesktopServices, QTextDocument
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QWidget

from kogao_core.base import assets, language

DOCS = ROOT / "docs"
LINK = re.compile(r"\]\((?!https?:)([^)#]*)(#[^)]*)?\)")


@pytest.fixture
def shown(qapp):  # noqa: ARG001
    """The pages, without an editor behind them."""
    window = QWidget()
    made = HelpDialog(DOCS, window)
    made.show()
    yield made
    window.deleteLater()


def name(shown):
    return shown.pages.source().fileName()


def test_it_begins_with_the_page_of_the_editor(shown):
    assert name(shown) == "editor.md"
    assert shown.list.currentText() == "Editor"
    assert "Ctrl+Shift+P" in shown.pages.toPlainText()
    assert not shown.back.isEnabled()


def test_pages_in_the_language_at_work_come_first(empty, english):  # noqa: ARG001
    language.use_catalogue("ja", gettext.NullTranslations())
    empty.key(Qt.Key.Key_F1)
    shown = empty.dialog(HelpDialog)
    assert shown.pages.source().toLocalFile() == str(DOCS / "ja" / "editor.md")
    assert shown.list.currentText() == shown.list.itemText(1) == "エディター"
    assert shown.list.findText("Editor") > 1
    # No space where a line of the file ends.
    assert re.findall(r"[、。] \w", shown.pages.toPlainText()) == []
    shown.pages.anchorClicked.emit(QUrl("../editor.md"))
    assert shown.list.currentText() == "Editor"


def test_it_is_opened_once(empty):
    empty.key(Qt.Key.Key_F1)
    shown = empty.dialog(HelpDialog)
    shown.pages.anchorClicked.emit(QUrl("fidelity.md"))
    empty.key(Qt.Key.Key_F1)
    assert empty.window.findChildren(HelpDialog) == [shown]
    assert name(shown) == "fidelity.md"


def test_links_lead_to_other_pages_and_back_again(shown):
    shown.pages.anchorClicked.emit(QUrl("fidelity.md"))
    assert name(shown) == "fidelity.md"
    assert shown.list.currentText() == "What happens to your photograph"
    QTest.mouseClick(shown.back, Qt.MouseButton.LeftButton)
    assert name(shown) == "editor.md"
    shown.list.setCurrentIndex(shown.list.findText("From other programs"))
    shown.list.activated.emit(shown.list.currentIndex())
    assert name(shown) == "hosts.md"


def test_a_link_to_a_heading_shows_it(shown):
    shown.pages.anchorClicked.emit(QUrl("fidelity.md#in-place"))
    line = shown.pages.fontMetrics().height()
    near = shown.pages.cursorForPosition(QPoint(line, line)).block().text()
    assert shown.pages.verticalScrollBar().value() > 0
    assert near == "In place"


def test_links_out_of_the_pages_open_in_a_browser(shown, monkeypatch):
    opened = []
    monkeypatch.setattr(QDesktopServices, "openUrl", lambda url: opened.append(url.toString()))
    shown.pages.anchorClicked.emit(QUrl("https://example.org/x"))
    assert (opened, name(shown)) == (["https://example.org/x"], "editor.md")
    shown.pages.anchorClicked.emit(QUrl("no-such-page.md"))
    assert name(shown) == "editor.md"


def test_pictures_are_shown_no_wider_than_the_text(shown):
    links = [link for link, _ in LINK.findall((DOCS / "editor.md").read_text())]
    pictures = [link for link in links if link.endswith(".png")]
    assert pictures
    for picture in pictures:
        image = shown.pages.document().resource(
            QTextDocument.ResourceType.ImageResource, QUrl(picture)
        )
        assert 0 < image.width() <= helping._PICTURE_PX


def test_words_are_found_again_and_again(shown):
    shown.words.setText("undo")
    for _ in range(3):
        QTest.keyClick(shown.words, Qt.Key.Key_Return)
        assert shown.pages.textCursor().selectedText().lower() == "undo"


def test_every_page_is_listed_and_can_be_read(shown):
    pages = sorted(DOCS.glob("*.md"))
    assert shown.list.count() == len(pages)
    for page in pages:
        shown.pages.follow(QUrl.fromLocalFile(str(page)))
        assert name(shown) == page.name
        assert len(shown.pages.toPlainText()) > 500


def test_an_installation_without_pages_says_so(empty, monkeypatch, tmp_path):
    monkeypatch.setattr(assets, "_folder", lambda: tmp_path)
    empty.key(Qt.Key.Key_F1)
    assert "Docs is not in this installation; reinstall Kogao" in empty.say()
    assert not empty.window.findChildren(HelpDialog)
