"""Match a retouched copy of the open photo, and keep several matches as a style."""

from __future__ import annotations

import dataclasses
from functools import partial
from pathlib import Path
from typing import Final

import cv2
import numpy as np

from kogao_core.base.display import rgb8
from kogao_core.photo import Photo, read
from kogao_core.reading.controls import Match, match, style
from kogao_core.recipe.recipe import Recipe

from ..document import State
from ..i18n import reason, sentence, tr, tr_count, translated
from ..pyramid import PicturePyramid
from ..render.colour import screen_colours
from ..view_state import RetouchedCopy
from ..widgets.dialogs import ask_path, photo_filter
from ..widgets.messages import BarAction
from .feature import Context, Feature
from .presets import Presets
from .strip import Strip

_WIPE: Final = "compare-wipe"


class MatchRetouch(Feature):
    """Reads a retouched copy, applies it to the open photo, and compares both results."""

    def __init__(self, context: Context, strip: Strip, presets: Presets) -> None:
        super().__init__(context)
        self._presets = presets
        self._recipes: dict[Path, list[Recipe]] = {}  # nearest settings of each matched photo
        self._lane = self.lane(self._apply, self._refuse)
        strip.film.addAction(self.bind("match-retouch", self._ask))
        self.document.opened.connect(self._forget_copy)
        self.actions[_WIPE].toggled.connect(self._forget_copy)

    def _ask(self) -> None:
        title, formats = tr("Open the retouched copy"), [photo_filter()]
        ask_path(self.window, title, self._read, filters=formats)

    def _read(self, path: Path) -> None:
        photo, state = self.document.photo, self.document.state
        if photo is not None:
            self.window.bar.clear()
            self.working.emit(tr("Reading the retouch…"))
            self._lane.submit(lambda: (photo, state, *matched(photo, state, path)))

    def _refuse(self, problem: Exception) -> None:
        self.working.emit("")
        text = tr("The retouch can't be read: {why}.", why=reason(problem))
        photo = self.document.photo
        self.say(text, applies=lambda: self.document.photo is photo)

    def _apply(self, found: tuple[Photo, State, dict[int, Match], RetouchedCopy]) -> None:
        self.working.emit("")
        photo, state, matches, copy = found
        if photo is not self.document.photo or state is not self.document.state:
            return
        faces = [
            matches[row].face if row in matches else face for row, face in enumerate(state.faces)
        ]
        self.document.step(dataclasses.replace(state, faces=tuple(faces)), tr("Match a retouch"))
        self._recipes[photo.path] = [one.recipe for one in matches.values()]
        self.view.set(retouched=copy)
        self.actions[_WIPE].setChecked(True)
        lines = [translated(line) for row, one in matches.items() for line in one.report(row + 1)]
        recipe, _ = style([one for recipes in self._recipes.values() for one in recipes])
        count = len(self._recipes)
        text = tr_count(count, "Save a style from {n} photo…", "Save a style from {n} photos…")
        save = BarAction(text, partial(self._presets.ask_name, recipe, self._recipes.clear))
        self.say("\n".join(map(sentence, lines)), save, wrong=False)

    def _forget_copy(self, wiped: bool = False) -> None:
        if not wiped:
            self.view.set(retouched=None)


def matched(photo: Photo, state: State, path: Path) -> tuple[dict[int, Match], RetouchedCopy]:
    """Return the match of each active face by its index, and the retouched copy.

    Raises NotRead, UnreadablePhoto.
    """
    copy = read(path)
    faces = {row: face for row, face in enumerate(state.faces) if row not in state.off}
    found = match(photo.pixels, copy.pixels, list(faces.values()))
    flags = cv2.INTER_AREA | cv2.WARP_INVERSE_MAP
    to_copy, size = found[0].reading.to_copy, (photo.width, photo.height)
    shown = cv2.warpAffine(rgb8(copy.pixels), to_copy.opencv, size, flags=flags)
    picture = PicturePyramid(np.asarray(shown, np.uint8), screen_colours(copy).show)
    outlines = tuple(one.reading.outline for one in found)
    return dict(zip(faces, found, strict=True)), RetouchedCopy(picture, outlines)
