"""Menu of landmark sources; import and export of landmark files."""

from __future__ import annotations

import dataclasses
from functools import partial
from itertools import chain, repeat
from pathlib import Path
from typing import Final

from kogao_core.base.json_reader import BadFile
from kogao_core.base.language import Text
from kogao_core.faces.face import LandmarkSource
from kogao_core.faces.landmarks import (
    CHOICES,
    Measured,
    networks_are_here,
    source,
)
from kogao_core.projects import interchange

from ..actions import Item
from ..i18n import sentence, tr, translated, unwritten
from ..widgets.dialogs import ask_path
from .faces import Faces
from .feature import Context, Feature

_KEYS: Final = ("F5", "F6", "F7", "Shift+F7")  # keys of the landmark sources


class LandmarkSources(Feature):
    """Actions of the Experiments menu that select the landmark source of `Faces`."""

    def __init__(self, context: Context, faces: Faces, first: LandmarkSource) -> None:
        super().__init__(context)
        self._faces = faces
        choice = next((choice for choice in CHOICES if choice.name == first.name), None)
        # Name of the source; None: the default.
        self.wanted = None if choice is None else choice.name
        if choice is not None and not choice.needs_networks and not networks_are_here():
            faces.found.connect(self._tell_of_fallback)
        for one, key in zip(CHOICES, chain(_KEYS, repeat("")), strict=False):
            text = tr("Landmarks by the {title}", title=translated(one.title))
            tip = translated(one.help) if one.help else _figures(one.measured)
            command = Item(f"landmarks-{one.name}", text, key, tip)
            self.bind(command, partial(self.use, one.name), checked=False)
        names = [f"landmarks-{one.name}" for one in CHOICES]
        self.one_of(*names)
        self.actions.get(f"landmarks-{first.name}", self.actions[names[0]]).setChecked(True)

    def use(self, name: str) -> None:
        """Search for faces again with the landmark source of this name."""
        self.wanted = name
        self._faces.use(source(name))

    def _tell_of_fallback(self) -> None:
        self._faces.found.disconnect(self._tell_of_fallback)
        self.say(
            tr(
                "The networks are missing, so landmarks come from the AAM, which is less "
                "exact. kogao-cli doctor says how to get them."
            )
        )


class Exchange(Feature):
    """Imports and exports landmark files."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self.bind("import-landmarks", self._ask_import)
        self.bind("export-landmarks", self.ask_export)
        self.document.watch(self._show, "faces", value=lambda: bool(self.document.state.faces))

    def _ask_import(self) -> None:
        endings = " ".join(f"*{form.suffix}" for form in interchange.FORMATS.values())
        filters = [tr("Landmarks ({endings})", endings=endings)]
        ask_path(self.window, tr("Import landmarks"), self.import_file, filters=filters)

    def import_file(self, path: Path) -> None:
        """Replace all faces by the faces of a file, as one undo step."""
        self.window.bar.clear()
        try:
            faces = interchange.read(path)
            interchange.check_inside(faces, self.document.image)
        except BadFile as problem:
            self.say(sentence(problem))
            return
        # Import into the current mode: manual points may come from a file, too.
        state = dataclasses.replace(self.document.state, faces=tuple(faces), off=frozenset())
        self.document.step(state, tr("Import landmarks"))
        self.did.emit(tr("Landmarks from {name}", name=path.name))

    def ask_export(self) -> None:
        """Request a file; the chosen file type selects the format."""
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
        """Export the points; formats for one face get a file for each face."""
        self.window.bar.clear()
        faces = self.document.state.faces
        try:
            # The dialog has confirmed overwriting only the first file.
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
        return tr("Accuracy not measured")
    return tr(
        "Outline within {studio:g} % of the eyes' distance on studio portraits, "
        "{wild:g} % elsewhere; about {ms:.0f} ms",
        studio=measured.studio_jaw,
        wild=measured.wild_jaw,
        ms=measured.typical_ms,
    )
