"""The rating session as one HTML file and its texts; the page makes no outside request."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Final

from PIL import Image as Pillow

from kogao_core.base.language import Text, translated
from kogao_core.base.web_page import filled, part
from kogao_core.lab.study import results
from kogao_core.lab.study.design import LEAST_MS
from kogao_core.lab.study.plan import Study
from kogao_core.lab.subjects import PAPER_SIZE

PAGE: Final = {
    "title": Text("Natural or unnatural?"),
    "back_key": Text("undo the last answer"),
    "then": Text("After these, you grade some pictures from 0 to 100."),
    "stop": Text(
        "You may stop at any time and continue later in this browser. You may withdraw: all "
        "your answers are deleted at once."
    ),
    "withdraw": Text("Withdraw my answers"),
    "kept": Text(
        "The study stores your answers, the time of each answer and the size of the pictures "
        "under the code below. No name and no address are stored."
    ),
    "stay": Text(
        "The data stays on this computer until you save the file at the end and hand over the file."
    ),
    "window": Text("Make this window as large as possible, and keep this size."),
    "again": Text("Keep the code: to continue later, type the same code."),
    "agree": Text("I have read this and agree to take part."),
    "full": Text("Full screen"),
    "code": Text("Your code; change only if you were given another code"),
    "code_rule": Text("a to z, 0 to 9 and dashes"),
    "begin": Text("Begin"),
    "go_on": Text("Continue"),
    "picture": Text("The face to judge"),
    "next": Text("Next"),
    "not_mine": Text("Not my picture"),
    "progress": Text("Progress"),
    "take_back": Text("Undo"),
    "save_so_far": Text("Save answers so far"),
    "thanks": Text("Thank you"),
    "save": Text("Save my answers"),
    "last_back": Text("Undo the last answer"),
}
"""Texts of `page.html`, by the name of the placeholder."""

SCRIPT: Final = {
    "natural": Text("Natural"),
    "unnatural": Text("Unnatural"),
    "scale_satisfied": Text("0 not at all satisfied, 100 completely satisfied"),
    "ask_slider": Text("How natural does this face look?"),
    "break": Text("A break"),
    "practised": Text("End of practice; now the study begins"),
    "practice": Text("Practice {done} of {total}"),
    "small_screen": Text(
        "This screen is too small for this study: the pictures need {size} px, and the screen"
        " has {screen}. Continue with the same code on a larger screen."
    ),
    "not_full": Text("This study needs the full screen."),
    "never_full": Text(
        "This browser can't show a page on the full screen. Continue with the same code in "
        "another browser."
    ),
    "disagrees": Text("If you don't agree, you can't take part. You may close this page."),
    "completion": Text("Your completion code: {code}"),
    "code": Text("Code: {rater}"),
    "task_one": Text(
        "You will see one picture. Answer quickly: does the face look natural or unnatural?"
    ),
    "task": Text(
        "You will see {n} pictures one after another. For each picture, answer quickly: does "
        "the face look natural or unnatural?"
    ),
    "keeps_nothing": Text(
        "This browser stores no data for local files. Finish the session without a break and "
        "save at the end."
    ),
    "place": Text("{done} of {total}"),
    "ask_satisfied": Text("How satisfied are you with this picture of yourself?"),
    "ask_natural": Text("Does this face look natural or unnatural?"),
    "missing": Text("The picture {name} is missing: copy the whole folder again."),
    "larger": Text(
        "Make this window larger: the pictures keep one size and need {size} px next to the "
        "buttons."
    ),
    "elsewhere": Text(
        "This session was continued in another window. This window continues from there."
    ),
    "said": Text("{n} answers are stored in this browser only. Save them as a file."),
    "withdraw_sure": Text("Delete all your answers? This can't be undone."),
    "withdrawn": Text("Your answers have been deleted."),
    "hand": Text("Hand the file {file} to the person who invited you."),
}
"""Texts of `page.js`, which fills in the fields."""


def page(study: Study, folder: Path) -> str:
    """Return the page for the folder of the pictures, in the current language."""
    script = part(__package__, "page.js").replace('"STUDY"', _data(study, folder))
    return filled(__package__, "page", script, PAGE, {})


def _data(study: Study, folder: Path) -> str:
    content = {
        **study.to_dict(),
        "header": results.header(study),
        "box": _box(study, folder),
        "least_ms": LEAST_MS,
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
