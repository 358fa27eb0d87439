"""The documentation is read without a network: its pages, their links and pictures."""

import gettext

import pytest
from kogao_app.features.help import Pages
from PySide6.QtCore import Qt, QUrl
from PySide6.QtGui import QTextDocument

from kogao_core.base import assets, language

pytestmark = pytest.mark.usefixtures("one_window")


def read(driver) -> Pages:
    driver.key(Qt.Key.Key_F1)
    return driver.dialog(Pages)


@pytest.mark.parametrize(("code", "words"), [("en", "Slim a face"), ("ja", "説明書")])
def test_it_begins_with_the_page_of_the_editor_in_the_language(opened, english, code, words):  # noqa: ARG001
    language.use_catalogue(code, gettext.NullTranslations())
    assert words in read(opened).toPlainText()


def test_links_lead_to_other_pages_and_back_again(opened):
    shown = read(opened)
    shown.setSource(QUrl("fidelity.md"))
    assert "What happens to your photograph" in shown.toPlainText()
    shown.backward()
    assert shown.source().fileName() == "editor.md"


def test_pictures_are_shown_no_wider_than_the_text(opened):
    shown, kind = read(opened), QTextDocument.ResourceType.ImageResource
    image = shown.document().resource(kind, QUrl("pictures/window.png"))
    assert 0 < image.width() < shown.width()


def test_an_installation_without_pages_says_so(opened, monkeypatch, tmp_path):
    monkeypatch.setattr(assets, "_folder", lambda: tmp_path)
    opened.key(Qt.Key.Key_F1)
    assert "Docs is not in this installation; reinstall Kogao" in opened.say()
