"""``kogao --edit``: edit photos in place for another program, with an exit code."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final

from kogao_core.photo import CannotWrite, check_in_place
from kogao_core.photo.originals import Originals

from ..ahead import Ahead
from ..i18n import sentence, tr
from ..widgets.messages import BarAction
from .faces import Faces
from .feature import Context, Feature
from .files import Files
from .protect import Protect
from .strip import Strip

CANCELLED: Final = 6


class Errand(Feature):
    """Saves photos in place and returns to the calling program."""

    def __init__(
        self, context: Context, files: Files, strip: Strip, faces: Faces, protect: Protect
    ) -> None:
        super().__init__(context)
        self._files, self._strip, self._faces, self._protect = files, strip, faces, protect
        self._mask: Path | None = None
        self._asked, self._saved, self._waits = False, False, False
        self.bind("done", self.finish_photo)
        self.bind("cancel-edit", self.cancel)
        for name in ("done", "cancel-edit"):
            self.actions[name].setVisible(False)
        files.saved_over.connect(self._remember)
        faces.found.connect(self._go_on)
        self.document.opened.connect(self._check)

    @property
    def code(self) -> int:
        """Exit code: 0 if a photo was saved, otherwise `CANCELLED`."""
        return 0 if self._saved else CANCELLED

    def begin(
        self,
        photos: Sequence[Path],
        ahead: Ahead | None = None,
        originals: Originals | None = None,
        mask: Path | None = None,
    ) -> None:
        """Open the photos of another program; several photos open as a film strip."""
        self._asked, self._mask = True, mask
        for name in ("done", "cancel-edit"):
            self.actions[name].setVisible(True)
        # The other program does not expect a project file in its folder.
        self.actions["save-project"].setVisible(False)
        self._files.save_over(originals or Originals(self.storage.originals))
        if ahead is not None:
            self._files.open(photos[0], ahead)
        else:
            self._strip.show_places(list(photos))

    def finish_photo(self) -> None:
        """Save and close, after the face detection has finished."""
        self._waits = self._faces.busy
        if not self._waits:
            self._files.keep(self.window.close)

    def cancel(self) -> None:
        """Close and leave the photo unchanged."""
        self.document.begin_with(self.document.base)
        self.window.close()

    def _go_on(self) -> None:
        if self._waits:
            self._waits = False
            self._files.keep(self.window.close)

    def _remember(self) -> None:
        self._saved = True

    def _check(self) -> None:
        """Show that saving overwrites the photo, or why the photo can't be overwritten."""
        photo, self._waits = self.document.photo, False
        if not self._asked or photo is None:
            return
        try:
            check_in_place(photo)
        except CannotWrite as problem:
            self.say(sentence(problem), applies=lambda: self.document.photo is photo)
            return
        if self._mask is not None:
            self._protect.open_mask(self._mask)
        text = tr("Opened by another program: saving overwrites the photo.")
        done = BarAction(tr("Done"), self.actions["done"].trigger)
        cancel = BarAction(tr("Cancel"), self.actions["cancel-edit"].trigger)
        self.say(text, done, cancel, wrong=False, applies=lambda: self.document.photo is photo)
