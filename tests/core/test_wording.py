"""Messages show values shortened, and sentences on one line that any terminal bears."""

import pytest

from kogao_core.base.wording import columns, sentence, shown


@pytest.mark.parametrize(
    ("value", "words"),
    [
        ("image", "'image'"),
        (True, "True"),
        (1.5, "1.5"),
        ("é\u202e\x1b", "'é\\u202e\\x1b'"),
        (None, "None"),
        ([1, "a"], "[1, 'a']"),
    ],
)
def test_short_values_stand_as_python_writes_them(value, words):
    assert shown(value) == words


@pytest.mark.parametrize(
    "value", ["x" * 10**6, [0] * 10**6, {"x" * 1000: ["y" * 1000]}, 10**400, [[[[["z" * 99]]]]]]
)
def test_long_values_are_cut(value):
    assert 4 < len(shown(value)) <= 41


def test_values_of_any_depth_are_shown():
    value = []
    for _ in range(10_000):
        value = [value]
    assert shown(value).startswith("[[[")


def test_a_sentence_has_one_line():
    assert sentence("can't read a.jpg; copy it") == "can't read a.jpg; copy it"
    assert sentence("a\nb\x1b[31m\u202e\udcff.jpg") == "a?b?[31m??.jpg"


def test_a_long_sentence_keeps_its_beginning_and_what_to_do():
    text = sentence(f"the photo {'x' * 10_000} is empty; copy it again")
    assert text.startswith("the photo xxx")
    assert " … " in text
    assert text.endswith("xxx is empty; copy it again")
    assert len(text) < 650


def test_letters_of_chinese_and_japanese_are_as_wide_as_two():
    assert [columns(text) for text in ("lattice", "格子 R", "しきい値…")] == [7, 6, 9]
