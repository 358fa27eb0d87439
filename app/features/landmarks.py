"""Where landmarks come from, with what each source was measured to do; and files of them."""

from __future__ import annotations

import dataclasses
from functools import partial
from itertools import chain, repeat
from pathlib import Path
from typing import Final

from kogao_core.base.language import Text
from kogao_core.base.strict import BadFile
from kogao_core.faces.face import LandmarkSource
from kogao_core.faces.landmarks import (
    CHOICES,
    Measured,
    ModelRefused,
    networks_are_here,
    source,
)
from kogao_core.projects import interchange

from ..i18n import lettered, sentence, tr, translated, unwritten
from ..widgets.dialogs import ask_path
from .faces import Faces
from .feature import Context, Feature

_KEYS: Final = ("F5", "F6", "F7", "Shift+F7")  # of the landmark sources, in turn


class LandmarkSources(Feature):
    """Joins the actions of the Face menu to the source that `Faces` asks."""

    def __init__(self, context: Context, faces: Faces, first: LandmarkSource) -> None:
        super().__init__(context)
        self._faces = faces
        choice = next((choice for choice in CHOICES if choice.name == first.name), None)
        # As `source` takes it; None for what it gives by itself.
        self.wanted = None if choice is None else choice.name
        if choice is not None and not choice.needs_networks and not networks_are_here():
            faces.found.connect(self._tell_of_fallback)
        for one, key in zip(CHOICES, chain(_KEYS, repeat("")), strict=False):
            self.add_action(
                f"landmarks-{one.name}",
                # Alt leads to it by the letter that its name begins with.
                tr("Landmarks by the {title}", title=lettered(translated(one.title), one.title[0])),
                key,
                translated(one.help) if one.help else _figures(one.measured),
                partial(self.use, one.name),
                checked=False,
            )
        self.add_action(
            "landmarks-file",
            tr("Landmarks by a model of &yours…"),
            "Shift+F6",
            tr("An LBF or Kazemi model of 68 points, as cv2.face reads them"),
            self._ask_for_file,
            checked=False,
        )
        names = [f"landmarks-{one.name}" for one in CHOICES]
        self._group = self.one_of(*names, "landmarks-file")
        self._now = self.actions.get(f"landmarks-{first.name}", self.actions[names[0]])
        self._now.setChecked(True)

    def use(self, wanted: str) -> None:
        """Find the faces again by a source: its name or a model file; a bad one changes nothing."""
        try:
            chosen = source(wanted)
        except ModelRefused as refusal:
            self._now.setChecked(True)
            self.say(str(refusal))
            return
        self.wanted = wanted
        self._now = self._group.checkedAction()
        self._faces.use(chosen)

    def _ask_for_file(self) -> None:
        dialog = ask_path(
            self.window,
            tr("A landmark model for cv2.face"),
            lambda path: self.use(str(path)),
            filters=[tr("Models (*.yaml *.dat)")],
        )
        dialog.rejected.connect(lambda: self._now.setChecked(True))

    def _tell_of_fallback(self) -> None:
        self._faces.found.disconnect(self._tell_of_fallback)
        self.say(
            tr(
                "The networks are missing, so landmarks come from the AAM, which is less "
                "exact. kogao-cli doctor says how to get them."
            )
        )


class Exchange(Feature):
    """Asks for files and passes points between them and the document."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self.add_action(
            "import-landmarks",
            tr("I&mport landmarks…"),
            "Ctrl+Shift+I",
            tr("Points from WebMorph, iBUG or a table in place of those found"),
            self._ask_import,
            needs_photo=True,
        )
        self.add_action(
            "export-landmarks",
            tr("&Export landmarks…"),
            "Ctrl+Shift+E",
            tr("The points for WebMorph, iBUG or a table"),
            self.ask_export,
        )
        self.watch(lambda: bool(self.document.state.faces), self._show)

    def _ask_import(self) -> None:
        endings = " ".join(f"*{form.suffix}" for form in interchange.FORMATS.values())
        filters = [tr("Landmarks ({endings})", endings=endings)]
        ask_path(self.window, tr("Import landmarks"), self.import_file, filters=filters)

    def import_file(self, path: Path) -> None:
        """Take a file's faces in place of the present ones, as one undo step."""
        self.window.bar.clear()
        try:
            faces = interchange.read(path)
            interchange.check_inside(faces, self.document.image)
        except BadFile as problem:
            self.say(sentence(problem))
            return
        # Into the mode at work: points by hand may come from a file as well.
        state = dataclasses.replace(self.document.state, faces=tuple(faces), off=frozenset())
        self.document.step(state, tr("Import landmarks"))
        self.did.emit(tr("Landmarks from {name}", name=path.name))

    def ask_export(self) -> None:
        """Ask where to write the points; the chosen kind tells the format."""
        forms = interchange.FORMATS.values()
        path = self.document.path
        ask_path(
            self.window,
            tr("Export landmarks"),
            self.export_file,
            "new",
            filters=[f"{translated(form.title)} (*{form.suffix})" for form in forms],
            endings=[f".{form.name}" for form in forms],
            at=None if path is None else path.with_name(path.stem),
        )

    def export_file(self, path: Path) -> None:
        """Write the faces' points; several faces take a file each where the format holds one."""
        self.window.bar.clear()
        faces = self.document.state.faces
        try:
            # The dialog has asked about the first file only.
            there = [file for file in interchange.files(path, faces)[1:] if file.exists()]
            if there:
                raise BadFile(Text("{name} is there already", name=there[0].name))
            written = interchange.write(faces, path)
        except BadFile as problem:
            self.say(sentence(problem))
        except OSError as problem:
            self.say(unwritten(path, problem))
        else:
            notes = {translated(one.note) for one in written if one.note}
            text = tr("Landmarks written to {name}", name=path.name)
            self.did.emit("; ".join([text, *sorted(notes)]))

    def _show(self) -> None:
        self.actions["export-landmarks"].setEnabled(bool(self.document.state.faces))


def _figures(measured: Measured | None) -> str:
    if measured is None:
        return tr("How exact it is wasn't measured")
    return tr(
        "Outline within {studio:g} % of the eyes' distance on studio portraits, "
        "{wild:g} % elsewhere; about {ms:.0f} ms",
        studio=measured.studio_jaw,
        wild=measured.wild_jaw,
        ms=measured.typical_ms,
    )
