"""Write the evidence of the current result."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from kogao_core.photo.picture import sha256_of
from kogao_core.pipeline import Rendering

from ...actions import Item
from ...i18n import sentence, tr, unwritten
from ...widgets.dialogs import ask_path
from ..feature import Context, Feature


class EvidenceFiles(Feature):
    """Writes an evidence file of the current result."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._writing = self.lane(self._show_written, self._fail)
        item = Item(
            "experiment-evidence",
            "&Write evidence…",
            "Ctrl+Shift+N",
            "Save displacement, lattice and domains",
            photo=True,
        )
        self.bind(item, self._ask_where)

    @property
    def _rendering(self) -> Rendering | None:
        """The full result of the newest state, or None."""
        frame = self.view.frame
        return frame.rendering if frame is not None and self.live.is_final(frame) else None

    def _ask_where(self) -> None:
        path, rendering = self.document.path, self._rendering
        if rendering is None or path is None:
            text = tr("The result is not complete yet. Try again in a moment.")
            self.say(text, applies=lambda: self._rendering is None)
            return
        ask_path(
            self.window,
            tr("Write evidence"),
            partial(self._write, rendering, path),
            "new",
            filters=[tr("Evidence (*.npz)")],
            endings=[".npz"],
            at=path.with_name(f"{path.stem}-evidence.npz"),
        )

    def _write(self, rendering: Rendering, photo: Path, path: Path) -> None:
        self.window.bar.clear()

        def work() -> Path:
            rendering.save_evidence(path, sha256_of(photo))
            return path

        self._writing.submit(work)

    def _show_written(self, path: Path) -> None:
        self.did.emit(tr("Evidence written to {name}", name=path.name))

    def _fail(self, problem: Exception) -> None:
        where = getattr(problem, "filename", None) or tr("The file")
        self.say(unwritten(where, problem) if isinstance(problem, OSError) else sentence(problem))
