"""The rating session as one HTML file and its texts; the page makes no outside request."""

from __future__ import annotations

import base64
import hashlib
import html
import json
from importlib import resources
from pathlib import Path
from typing import Final

from PIL import Image as Pillow

from kogao_core.base.language import Text, language, translated
from kogao_core.lab.study import results
from kogao_core.lab.study.design import GAP_PX, LEAST_MS, SURROUND
from kogao_core.lab.study.plan import Study
from kogao_core.lab.subjects import PAPER_SIZE

PAGE: Final = {
    "title": Text("Natural or unnatural?"),
    "back_key": Text("take the last answer back"),
    "then": Text("Then you grade some pictures from 0 to 100."),
    "stop_alone": Text(
        "You may stop at any time and go on later in this browser, or withdraw your answers: they"
        " are deleted at once."
    ),
    "stop_served": Text(
        "You may stop at any time and go on later, or withdraw your answers: they are deleted at"
        " once."
    ),
    "withdraw": Text("Withdraw my answers"),
    "kept": Text(
        "Kept are your answers, how long each took and how large the pictures were, under"
        " the code below: no name, no address."
    ),
    "stay_alone": Text(
        "They stay on this computer until you save the file at the end and hand it over yourself."
    ),
    "stay_served": Text("They stay on this computer."),
    "window": Text("Make this window as large as you can, and leave it so."),
    "again": Text("To go on later, type the same code again: keep it."),
    "agree": Text("I have read this and agree to take part."),
    "measure": Text("How large is this screen?"),
    "card": Text(
        "Hold a bank card, or any card of that size, against the screen, and move the slider until"
        " the field below is exactly as wide."
    ),
    "card_width": Text("Width of the field"),
    "fits": Text("It is as wide as the card"),
    "full": Text("Full screen"),
    "code": Text("Your code; leave it as it is unless you were given one"),
    "code_rule": Text("a to z, 0 to 9 and dashes"),
    "begin": Text("Begin"),
    "go_on": Text("Go on"),
    "picture": Text("The face to judge"),
    "next": Text("Next"),
    "not_mine": Text("Not my picture"),
    "progress": Text("Progress"),
    "take_back": Text("Take back"),
    "save_so_far": Text("Save answers so far"),
    "thanks": Text("Thank you"),
    "close": Text("You may close this page."),
    "save": Text("Save my answers"),
    "last_back": Text("Take the last answer back"),
}
"""Texts of `page.html`, by the name of the placeholder."""

SCRIPT: Final = {
    "natural": Text("Natural"),
    "unnatural": Text("Unnatural"),
    "left": Text("The left one"),
    "right": Text("The right one"),
    "same": Text("The same"),
    "different": Text("Different"),
    "task_pair": Text(
        "You will see {n} times two pictures side by side. Say, without thinking long, in which"
        " the face looks more natural."
    ),
    "task_same": Text(
        "You will see {n} times two pictures side by side. Say, without thinking long, whether"
        " they are the same or differ."
    ),
    "ask_pair": Text("In which picture does the face look more natural?"),
    "ask_same": Text("Are these pictures the same?"),
    "task_slider": Text(
        "You will see {n} pictures one after another. Say of each, without thinking long, how"
        " natural the face looks."
    ),
    "scale_satisfied": Text("0 not at all satisfied, 100 wholly satisfied"),
    "scale_natural": Text("0 not at all natural, 100 wholly natural"),
    "ask_slider": Text("How natural does this face look?"),
    "distance": Text("Sit so that your eyes are {cm} cm from the screen, and stay so."),
    "break": Text("A break"),
    "practised": Text("That was for practice; now it begins"),
    "practice": Text("Practice {done} of {total}"),
    "small_screen": Text(
        "This screen is too small for this study: its pictures need {size} px, and the screen has"
        " {screen}. Go on with the same code on a larger one."
    ),
    "not_full": Text("This study is shown on the full screen only."),
    "never_full": Text(
        "This browser can't show a page on the full screen. Go on with the same code in another."
    ),
    "disagrees": Text("Who doesn't agree doesn't take part: you may close this page."),
    "completion": Text("Your completion code: {code}"),
    "code": Text("Code: {rater}"),
    "task_one": Text(
        "You will see one picture. Say, without thinking long, whether the face looks "
        "natural or unnatural."
    ),
    "task": Text(
        "You will see {n} pictures one after another. Say of each, without thinking long,"
        " whether the face looks natural or unnatural."
    ),
    "ended": Text(
        "Kogao has ended. Nothing is lost: start it again, and go on with your code on "
        "the page that it opens."
    ),
    "keeps_nothing": Text(
        "This browser keeps nothing for a file: do the session in one go, and save at the end."
    ),
    "place": Text("{done} of {total}"),
    "ask_satisfied": Text("How satisfied are you with this picture of yourself?"),
    "ask_natural": Text("Does this face look natural or unnatural?"),
    "missing": Text("The picture {name} is missing: copy the whole folder again."),
    "larger": Text(
        "Make this window larger: the pictures of a session keep their size, and need "
        "{size} px beside the buttons."
    ),
    "elsewhere": Text("This session went on in another window; here it goes on from there."),
    "said": Text("{n} answers are kept under the code {rater}."),
    "withdraw_sure": Text("Delete all your answers? This can't be undone."),
    "withdrawn": Text("Your answers have been deleted."),
    "hand": Text("Hand the file {file} to whoever asked you."),
}
"""Texts of `page.js`, which fills in the fields."""


def page(study: Study, folder: Path, *, served: bool = False) -> str:
    """Return the page for the folder of the pictures, in the current language.

    The content security policy allows the page's script and style (by digest) and pictures of the
    folder. All other requests are blocked.
    """
    style = _part("page.css").replace("SURROUND", SURROUND)
    script = _part("page.js").replace('"STUDY"', _data(study, folder, served))
    reached = "connect-src 'self'; img-src 'self' data:" if served else "img-src 'self' file: data:"
    policy = (
        f"default-src 'none'; {reached}; script-src {_digest(script)}; "
        f"style-src {_digest(style)}; base-uri 'none'; form-action 'none'"
    )
    filled = {"POLICY": policy, "STYLE": style, "SCRIPT": script}
    filled |= {name: html.escape(translated(text)) for name, text in PAGE.items()}
    filled["LANGUAGE"] = language()
    text = _part("page.html")
    for name, value in filled.items():
        text = text.replace(f"<!--{name}-->", value)
    return text


def _data(study: Study, folder: Path, served: bool) -> str:
    content = {
        **study.to_dict(),
        "header": results.header(study, "", "page"),
        "box": _box(study, folder),
        "gap": GAP_PX if study.conduct.pairs else 0,
        "least_ms": LEAST_MS,
        "served": served,
        "words": {name: translated(text) for name, text in SCRIPT.items()},
    }
    return json.dumps(content).replace("<", "\\u003c")


def _box(study: Study, folder: Path) -> tuple[int, int]:
    """Return the width and height, px, that every picture fits in."""
    sizes = []
    for name in (*study.ratings, *study.satisfaction, *study.practice):
        try:
            with Pillow.open(folder / name) as picture:
                sizes.append(picture.size)
        except OSError:
            continue  # the page reports the missing picture when needed
    wide, high = zip(*(sizes or [PAPER_SIZE]), strict=True)
    return max(wide), max(high)


def _part(name: str) -> str:
    return resources.files(__package__).joinpath(name).read_text(encoding="utf-8")


def _digest(text: str) -> str:
    return "'sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode() + "'"
