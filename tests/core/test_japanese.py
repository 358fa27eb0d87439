"""Japanese: terms that hold everywhere, letters, spaces; pages that name what is there."""

import re

import pytest
from modules import ROOT

from kogao_core.base.wording import columns

# What an English word is called wherever it stands.
TERMS = {
    r"landmarks?": "特徴点",
    r"targets?": "目標点",
    r"outline": "輪郭",
    r"lattice": "格子",
    r"recipes?": "レシピ",
    r"presets?": "プリセット",
    r"warp distances?": "変形距離",
    r"threshold": "しきい値",
    r"control points?": "制御点",
    r"overlays": "オーバーレイ",
    r"film strip": "フィルムストリップ",
}
JAPANESE = "[\u3041-\u30ff\u4e00-\u9fff々]"
NARROW = "[A-Za-z0-9%]"


@pytest.fixture(scope="module")
def said():
    """English texts with their Japanese, those that are translated."""
    pofile = pytest.importorskip("babel.messages.pofile", reason="pip install -e '.[test]' again")
    with (ROOT / "resources" / "translations" / "ja.po").open("rb") as file:
        catalogue = pofile.read_po(file)
    pairs = [
        (one.id, one.string) if isinstance(one.id, str) else (one.id[-1], one.string[0])
        for one in catalogue
        if one.id
    ]
    return {english: japanese for english, japanese in pairs if japanese}


def page(name):
    return (ROOT / name).read_text(encoding="utf-8")


def letter(text):
    found = re.search(r"&(\w)", text)
    return found[1].upper() if found else ""


def named(said):
    """What commands, controls and columns are called, without letters and dots."""
    return {re.sub(r"\(&\w\)", "", text).rstrip("…") for text in said.values()}


def test_no_text_is_a_guess():
    """Babel leaves fuzzy texts out of the compiled catalogue: the window shows them in English."""
    assert "#, fuzzy" not in page("resources/translations/ja.po")


def test_a_letter_is_that_of_the_english(said):
    texts = {one: said[one] for one in said if letter(one)}
    assert len(texts) > 90
    assert {one: text for one, text in texts.items() if letter(text) != letter(one)} == {}


@pytest.mark.parametrize(("term", "word"), TERMS.items(), ids=TERMS.values())
def test_a_term_is_called_the_same_everywhere(term, word, said):
    spoken = {one: re.sub(r"\{[^}]*\}|--[\w-]+", "", one) for one in said}
    texts = [one for one in said if re.search(rf"\b{term}\b", spoken[one], re.IGNORECASE)]
    assert texts
    assert {one: said[one] for one in texts if word not in said[one]} == {}


def test_japanese_and_narrow_letters_stand_apart(said):
    beside = re.compile(f"{JAPANESE}{NARROW}|{NARROW}{JAPANESE}")
    texts = [re.sub(r"\(&\w\)|\{[^}]*\}", "", text) for text in said.values()]
    assert [text for text in texts if beside.search(text)] == []


def test_whole_sentences_end_as_the_english_do(said):
    ends = {one: text for one, text in said.items() if re.search(r"[a-z)]\.\s*$", one)}
    assert [text for text in ends.values() if not text.rstrip().endswith("。")] == []


def test_what_stands_before_figures_leaves_them_in_one_column(said):
    labels = ("centre", "amount", "accuracy", "folds", "domain", "time", "lines", "kept straight")
    assert [said[one] for one in labels if columns(said[one]) > 14] == []
    header = "face  score      x      y  width  height  tilt"
    assert columns(said[header]) == columns(header)


def test_the_glossary_has_the_words_of_the_catalogue(said):
    rows = re.findall(r"^\| [^|]+ \| ([^|]+) \| [^|]*\|$", page("docs/japanese.md"), re.M)[1:]
    words = {word for row in rows for word in row.split("、")}
    assert len(words) > 40
    everything = "\n".join(said.values())
    assert [word for word in words if word not in everything] == []


def test_the_page_of_the_editor_calls_things_as_the_window_does(said):
    bold = set(re.findall(r"\*\*(.+?)\*\*", page("docs/ja/editor.md")))
    assert len(bold) > 60
    assert bold - named(said) == set()


def test_the_page_of_the_editor_has_keys_that_the_english_one_has():
    keys = set(re.findall(r"`((?:Ctrl|Alt|Shift|F\d)[^`]*)`", page("docs/ja/editor.md")))
    assert len(keys) > 30
    english = "".join(page(f"docs/{name}.md") for name in ("editor", "inspect", "keys"))
    assert [key for key in keys if key not in english] == []


def test_the_page_of_the_command_line_has_what_the_english_one_has():
    japanese, english = (page(f"docs/{one}command-line.md") for one in ("ja/", ""))
    spoken = re.findall(r"`(-[-a-z]+|kogao-cli [a-z]+)`", japanese)
    assert len(spoken) > 25
    assert [one for one in spoken if f"`{one}" not in english and f" {one} " not in english] == []
    codes = re.findall(r"^\| (\d+) \|", japanese, re.MULTILINE)
    assert codes == re.findall(r"^  (\d+)  ", english, re.MULTILINE)
