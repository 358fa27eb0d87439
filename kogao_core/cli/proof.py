"""``kogao-cli proof``: a page on which the person in a photo chooses how much is changed."""

from __future__ import annotations

import dataclasses
import html
import json
from pathlib import Path
from types import SimpleNamespace
from typing import Final

from kogao_core.background.find import BackgroundFinder
from kogao_core.base.atomic import atomic_write
from kogao_core.base.display import data_uri, rgb8
from kogao_core.base.language import Text, tr, translated
from kogao_core.base.web_page import filled, part
from kogao_core.cli import common, ending, options, reading
from kogao_core.faces.doubt import Chosen
from kogao_core.field.protection import NOTHING
from kogao_core.photo import Photo, RefusedOutput
from kogao_core.photo.export import Export
from kogao_core.projects.sidecar import Applied
from kogao_core.recipe.recipe import VERSION, Recipe
from kogao_core.retouch import RetouchJob, draw

_SHARES: Final = (0.0, 1 / 3, 2 / 3, 1.0)  # of the Amount
_EXPORT: Final = Export(longest_px=1200, srgb=True)
_TEXTS: Final = {
    "title": Text("How shall your face look?"),
    "told": Text(
        "The first picture shows you as you were photographed. In the others, a program made the "
        "face smaller. Only you decide; the answer may be none."
    ),
    "ask": Text("Which picture shall be used?"),
    "send": Text("Copy the line below, and send it to the person who gave you this page."),
    "answer": Text("Your answer"),
    "copy": Text("Copy the answer"),
    "copied": Text("Copied"),
}


def run(args: SimpleNamespace) -> None:
    """Run the command."""
    path = common.input_path(args.source, args.sample)
    output = args.output or Path(f"{path.stem}-proof.html")
    common.check_report(output, args.force)
    recipe = options.recipe_of(args.recipe_file, vars(args))
    if not recipe.percent:
        raise ending.Stop("proof needs an Amount other than 0, the largest to offer")
    photo = reading.read_photo(path, args.max_megapixels, 8)
    faces = reading.find_faces(photo, args.landmarks)
    chosen = reading.chosen(photo, faces, RetouchJob(recipe, args.which, args.doubtful))
    page = _page(photo, chosen, recipe)
    with ending.writing(output):
        atomic_write(page.encode(), output)
    ending.print_text(tr("{file}: send it to the person in the photo", file=output))


def _page(photo: Photo, chosen: Chosen, recipe: Recipe) -> str:
    finder, doses = BackgroundFinder(), list[str]()
    for share in _SHARES:
        percent = round(share * recipe.percent, 1)
        one = dataclasses.replace(recipe, percent=percent) if percent else Recipe(percent=0.0)
        faces = chosen.faces if percent else []
        drawn = draw(photo, Applied(faces, one, NOTHING, others=chosen.others), finder, _EXPORT)
        with ending.stopping(RefusedOutput, ending.USAGE):
            _, pixels = _EXPORT.applied(photo, drawn.pixels)
        label = Text("{n:g} % smaller", n=percent) if percent else Text("None: leave it as it is")
        checked = "" if percent else " checked"
        doses.append(
            f'<label class="dose"><img alt="" src="{data_uri(rgb8(pixels))}"><input type="radio" '
            f'name="dose" value="{html.escape(_line(one))}"{checked}> '
            f"{html.escape(translated(label))}</label>"
        )
    script = part(__package__, "proof.js")
    return filled(__package__, "proof", script, _TEXTS, {"DOSES": "".join(doses)})


def _line(recipe: Recipe) -> str:
    """Return a recipe as one line of JSON, without defaults."""
    defaults, values = Recipe().to_dict(), recipe.to_dict()
    kept = {name: value for name, value in values.items() if value != defaults[name]}
    return json.dumps({"version": VERSION, "percent": recipe.percent, **kept})
