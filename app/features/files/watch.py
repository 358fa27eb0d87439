"""Notices when another program changes, renames or removes the open photo."""

from __future__ import annotations

import dataclasses
from typing import Final

from PySide6.QtCore import QTimer, Signal

from kogao_core.faces.face import Face
from kogao_core.photo import Photo
from kogao_core.photo.whereabouts import Gone, Replaced, current

from ...document import is_same_place
from ...i18n import tr
from ...widgets.messages import BarAction
from ..faces import Faces
from ..feature import Context, Feature
from . import Files
from .opening import EarlierWork, is_sample, to_keep_beside
from .saver import Saver

EVERY_MS: Final = 700


class Watch(Feature):
    """Compares the open photo with its file, follows a renamed file and asks about another one."""

    # (before: Path, now: Path): the open photo was renamed.
    followed = Signal(object, object)

    def __init__(self, context: Context, files: Files, faces: Faces, saver: Saver) -> None:
        super().__init__(context)
        self._files, self._faces, self._saver = files, faces, saver
        self._photo: Photo | None = None  # last compared
        self._problem = ""  # the last answer about this photo
        self._reloaded: EarlierWork | None = None
        self._looking = self.lane(self._take, lambda _: None)
        self._searching = self.lane(self._name_misfits, lambda _: None)
        self._timer = QTimer(self, interval=EVERY_MS)
        self._timer.timeout.connect(self.look)
        self._timer.start()
        files.stale.connect(lambda: self._tell("replaced"))
        files.restored.connect(self._check)

    def stop(self) -> None:
        self._timer.stop()
        super().stop()

    def look(self) -> None:
        """Compare the photo with its file in a worker: the drive may not answer."""
        photo = self.document.photo
        if photo is not None and self._saver.keeps and not (
            self._looking.busy or self._saver.busy or is_sample(photo.path)
        ):  # fmt: skip
            self._looking.submit(lambda: (photo, _compared(photo)))

    def _take(self, compared: tuple[Photo, Photo | str]) -> None:
        photo, now = compared
        if photo is not self.document.photo or self._saver.busy:
            return
        if isinstance(now, str):
            if (photo, now) != (self._photo, self._problem):
                self._tell(now)
            return
        self._photo, self._problem = now, ""
        if now is not photo:
            self.document.follow(now)
        self.window.bar.refresh()
        if now.path != photo.path:
            self.followed.emit(photo.path, now.path)
            self.did.emit(tr("{name} is {now} now", name=photo.path.name, now=now.path.name))

    def _tell(self, problem: str) -> None:
        photo = self.document.photo
        if photo is None:
            return
        self._photo, self._problem = photo, problem
        name, steps = photo.path.name, tuple[BarAction, ...]()
        if problem == "gone":
            text = tr("{name} is gone: moved, deleted, or its drive is away.", name=name)
        else:
            text = tr("{name} was replaced by another picture.", name=name)
            keep = BarAction(tr("Keep the old picture"), self._keep)
            steps = BarAction(tr("Reload"), self._reload), keep
        self.say(
            text,
            *steps,
            applies=lambda: self.document.photo is photo and self._problem == problem,
        )

    def _keep(self) -> None:
        if self.document.photo is not None:
            # Without a stamp, the photo is never compared again.
            self.document.follow(dataclasses.replace(self.document.photo, stamp=None))
            self.window.bar.refresh()

    def _reload(self) -> None:
        photo = self.document.photo
        if photo is not None:
            self.document.commit()
            self._reloaded = EarlierWork(to_keep_beside(self.document.committed, photo))
            self._files.read(photo.path, self._reloaded)

    def _check(self, work: EarlierWork) -> None:
        photo, search = self.document.photo, self._faces.search()
        if work is self._reloaded and photo is not None:
            self._searching.submit(lambda: search.run(photo))

    def _name_misfits(self, found: list[Face]) -> None:
        faces = self.document.state.faces
        misfits = [
            str(number)
            for number, face in enumerate(faces, 1)
            if not any(is_same_place(face, one) for one in found)
        ]
        if misfits:
            self.say(tr("No face under the outline of: {faces}.", faces=", ".join(misfits)))


def _compared(photo: Photo) -> Photo | str:
    try:
        return current(photo)
    except Gone:
        return "gone"
    except Replaced:
        return "replaced"
