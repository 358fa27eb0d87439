"""The page for the person in a photo, in a real browser, with the keyboard alone."""

import json

import pytest

from kogao_core.photo import read
from kogao_core.recipe.recipe import VERSION, Recipe

CODES = {"Tab": 9, "Enter": 13, "ArrowUp": 38, "ArrowDown": 40}


def press(page, *keys):
    for key in keys:
        for kind in ("rawKeyDown", "keyUp"):
            code = {"windowsVirtualKeyCode": CODES[key], "code": key}
            page.call("Input.dispatchKeyEvent", type=kind, key=key, **code)
            if (kind, key) == ("rawKeyDown", "Enter"):
                page.call("Input.dispatchKeyEvent", type="char", key=key, text="\r", **code)


@pytest.mark.parametrize("size", [(390, 844), (1280, 900)])
def test_each_choice_arrives_by_the_keyboard_on_a_phone_and_a_desktop(
    works, chromium, small_portrait, tmp_path, size
):
    output = tmp_path / "proof.html"
    works("proof", small_portrait, "-o", output, "--recipe", '{"percent": 6, "jaw_width": -3}')
    page, answers = chromium, []
    page.afresh()
    page.resize(*size)
    for keys in ([], ["ArrowDown"], ["ArrowDown"] * 2, ["ArrowUp"], ["ArrowUp"] * 2):
        page.open(output.as_uri())
        assert page.ask("answer.value") == json.dumps({"version": VERSION, "percent": 0.0})
        assert page.ask("document.documentElement.scrollWidth <= innerWidth")
        press(page, "Tab", *keys, "Enter")
        assert page.ask("said.textContent")
        answers.append(page.ask("getSelection().toString()"))
    recipes = [Recipe.from_dict(json.loads(one)) for one in answers]
    assert [one.percent for one in recipes] == [0.0, 2.0, 4.0, 6.0, 4.0]
    assert [one.jaw_width for one in recipes] == [0.0, -3.0, -3.0, -3.0, -3.0]
    by_answer, by_options = tmp_path / "answer.png", tmp_path / "options.png"
    works("warp", small_portrait, "-o", by_answer, "--recipe", answers[3])
    works("warp", small_portrait, "-o", by_options, "--amount", 6, "--jaw-width", -3)
    assert (read(by_answer).pixels == read(by_options).pixels).all()
