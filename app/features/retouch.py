"""Match a retouched copy of the open photo, and keep several matches as a style."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import cv2
import numpy as np

from kogao_core.base.display import rgb8
from kogao_core.photo import Photo, read
from kogao_core.reading.controls import ControlFit, fit_controls, report, style
from kogao_core.reading.displacement import Reading, read_faces
from kogao_core.recipe import presets

from ..document import State
from ..i18n import reason, sentence, tr, translated
from ..render.colour import screen_colours
from ..render.pictures import PicturePyramid
from ..widgets.dialogs import ask_name, ask_path, photo_filter
from ..widgets.messages import BarAction
from .feature import Context, Feature
from .strip import Strip

_WIPE: Final = "compare-wipe"


@dataclass(frozen=True, eq=False)
class Match:
    """What was read from a retouched copy of a photo."""

    photo: Photo
    state: State  # of the document when the search began
    rows: tuple[int, ...]  # indices of the faces that were read
    readings: tuple[tuple[Reading, ControlFit], ...]
    copy: PicturePyramid  # the retouched copy, in the frame of the photo


class MatchRetouch(Feature):
    """Reads a retouched copy, applies it to the open photo, and compares both results."""

    def __init__(self, context: Context, strip: Strip) -> None:
        super().__init__(context)
        self._fits: dict[Path, list[ControlFit]] = {}
        self._lane = self.lane(self._apply, self._refuse)
        strip.film.addAction(self.bind("match-retouch", self._ask))
        self.document.opened.connect(self._forget_copy)
        self.actions[_WIPE].toggled.connect(self._forget_copy)

    def _ask(self) -> None:
        title, formats = tr("Open the retouched copy"), [photo_filter()]
        ask_path(self.window, title, self._read, filters=formats)

    def _read(self, path: Path) -> None:
        photo, state = self.document.photo, self.document.state
        if photo is None:
            return
        self.window.bar.clear()
        self.working.emit(tr("Reading the retouch…"))
        self._lane.submit(lambda: matched(photo, state, path))

    def _refuse(self, problem: Exception) -> None:
        self.working.emit("")
        text = tr("The retouch can't be read: {why}.", why=reason(problem))
        photo = self.document.photo
        self.say(text, applies=lambda: self.document.photo is photo)

    def _apply(self, match: Match) -> None:
        self.working.emit("")
        if match.photo is not self.document.photo or match.state is not self.document.state:
            return
        faces = list(match.state.faces)
        for row, (reading, fit) in zip(match.rows, match.readings, strict=True):
            faces[row] = dataclasses.replace(reading.targets, recipe=fit.recipe)
        state = dataclasses.replace(match.state, faces=tuple(faces))
        self.document.step(state, tr("Match a retouch"))
        self._fits[match.photo.path] = [fit for _, fit in match.readings]
        self.view.retouched = match.copy
        self.actions[_WIPE].setChecked(True)
        self.window.canvas.redraw()
        lines = [
            translated(line)
            for number, both in zip(match.rows, match.readings, strict=True)
            for line in report(number + 1, *both)
        ]
        count = len(self._fits)
        save = BarAction(tr("Save a style from {n} photos…", n=count), self._ask_name)
        self.say("\n".join(map(sentence, lines)), save, wrong=False)

    def _ask_name(self) -> None:
        ask_name(self.window, tr("Save a style"), tr("Name of the preset"), self._save)

    def _save(self, name: str) -> None:
        recipe, _ = style([fit for fits in self._fits.values() for fit in fits])
        try:
            presets.add(self.storage.presets, name, recipe)
        except (OSError, ValueError) as problem:
            self.say(tr("The style can't be saved ({why}).", why=reason(problem)))
            return
        self._fits.clear()
        self.say(tr("Saved the preset {name}.", name=name.strip()), wrong=False)

    def _forget_copy(self, wiped: bool = False) -> None:
        if not wiped:
            self.view.retouched = None


def matched(photo: Photo, state: State, path: Path) -> Match:
    """Read how a file moved the active faces of a photo. Raises NotRead, UnreadablePhoto."""
    copy = read(path)
    rows = tuple(row for row in range(len(state.faces)) if row not in state.off)
    found = read_faces(photo.pixels, copy.pixels, [state.faces[row] for row in rows])
    fits = tuple((one, fit_controls(one, state.image)) for one in found)
    size = photo.width, photo.height
    flags = cv2.INTER_AREA | cv2.WARP_INVERSE_MAP
    shown = cv2.warpAffine(rgb8(copy.pixels), found[0].to_copy.opencv, size, flags=flags)
    pyramid = PicturePyramid(np.asarray(shown, np.uint8), screen_colours(copy).show)
    return Match(photo, state, rows, fits, pyramid)
