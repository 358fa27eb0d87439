"""The editor: creates, mounts and stops all features."""

from __future__ import annotations

import gc

from pyqtgraph.util.garbage_collector import GarbageCollector
from PySide6.QtCore import QObject, Qt, QThreadPool
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QApplication

from kogao_core.base.installed import has_laboratory
from kogao_core.faces.face import LandmarkSource

from . import theme
from .document import Document
from .features.batch import Batch
from .features.both import BothModes
from .features.clipboard import Clipboard
from .features.commands import Commands
from .features.disclosure import SaveOptions
from .features.errand import Errand
from .features.export import Exporting
from .features.faces import Faces
from .features.feature import Context
from .features.files import Files
from .features.files.saver import Saver
from .features.files.watch import Watch
from .features.groups import Groups
from .features.help import Documentation
from .features.history import History
from .features.kept import KeptFeature
from .features.landmarks import LandmarkSources
from .features.manual import Manual
from .features.overlays import Marks, Overlays, Surroundings
from .features.points import Points, SoftSelection
from .features.preferences import Preferences
from .features.presets import Presets
from .features.projects import Projects
from .features.protect import Protect
from .features.push import Push
from .features.readings import Figure, Readings
from .features.recent import Recent
from .features.recipe import RecipeEditing
from .features.recovery import Recovery
from .features.retouch import MatchRetouch
from .features.screen import Compare, Hints, Screen
from .features.speech import Speech
from .features.strip import Strip
from .features.sync import Sync
from .features.together import Together
from .features.workspaces import Workspaces
from .i18n import reason, tr
from .render.live import Live
from .storage import Storage
from .view_state import ViewState
from .widgets.messages import BarAction, Message
from .window import Window


class Editor(QObject):
    """Creates the features and mounts the widgets in the window."""

    def __init__(
        self,
        app: QApplication,
        source: LandmarkSource,
        storage: Storage,
        choice: theme.Choice | None = None,
        workspace: str | None = None,
    ) -> None:
        super().__init__()
        # Collect cyclic garbage on this thread: widgets must be deleted here.
        self._garbage = GarbageCollector()
        # Exclude the loaded modules from garbage collection: scanning takes time.
        gc.freeze()
        self._app, self._wanted, self._log = app, choice, storage.log
        pool, rendering = QThreadPool(self), QThreadPool(self)
        pool.setMaxThreadCount(4)
        # One thread per rendering lane, so that other long jobs don't delay the picture.
        rendering.setMaxThreadCount(3)
        self._pools = (rendering, pool)
        self.document = Document(self)
        self.view = ViewState(document=self.document)
        self.window = window = Window(self.view)
        self.live = Live(self.view, window.canvas.visible_part, rendering, self)
        self.live.failed.connect(self._say_not_drawn)
        context = Context(
            self.document, self.view, self.live, window, pool, storage, storage.settings()
        )
        self.features = context.features
        self._build(context, source)
        self._mount()
        self.workspaces.begin(workspace)
        window.asked_to_close.connect(
            lambda: self.batch.guard(lambda: self.saver.guard(self.close))
        )
        self._worn: theme.Theme | None = None
        self._following = False
        self._follows_system(True)
        self._portal = None
        hints, unknown = app.styleHints(), Qt.ColorScheme.Unknown
        if hints.colorScheme() == unknown and app.platformName() in ("xcb", "wayland"):
            from .portal import Portal  # QtDBus isn't on every system

            self._portal = Portal(self)
            self._portal.changed.connect(self._dress)
        self.preferences.changed.connect(self._dress)
        self._dress()

    def _build(self, context: Context, source: LandmarkSource) -> None:
        self.points = Points(context)
        self.soft = SoftSelection(context)
        self.recipe = RecipeEditing(context, self.points)
        self.overlays = Overlays(context)
        self.protect = Protect(context)
        self.push = Push(context, self.protect)
        self.compare = Compare(context)
        self.surroundings = Surroundings(context, self.overlays)
        self.faces = Faces(context, self.recipe, source)
        self.groups = Groups(context, self.recipe, self.faces)
        self.landmarks = LandmarkSources(context, self.faces, source)
        self.save_options = SaveOptions(context)
        self.saver = Saver(context)
        self.preferences = Preferences(context, self.recipe, self.save_options)
        self.files = Files(context, self.saver, self.faces, self.save_options)
        self.clipboard = Clipboard(context, self.save_options)
        self.projects = Projects(context, self.saver, self.files, self.faces)
        self.recovery = Recovery(context, self.saver, self.files)
        self.strip = Strip(context, self.files, self.projects, self.faces)
        self.watch = Watch(context, self.files, self.faces, self.saver)
        for feature in (self.projects, self.strip):
            self.watch.followed.connect(feature.follow)
        self.sync = Sync(context, self.strip, self.faces, self.projects, self.saver)
        self.together = Together(context, self.strip)
        self.errand = Errand(context, self.files, self.strip, self.faces, self.protect)
        self.recent = Recent(context, self.files, self.strip)
        self.presets = Presets(context, self.recipe)
        self.match = MatchRetouch(context, self.strip, self.presets)
        self.manual = Manual(context, self.points)
        self.files.settle = self.manual.settle
        self.batch = Batch(context, self.landmarks, self.save_options, self.strip, self.saver)
        self.exporting = Exporting(context, self.files, self.strip, self.batch, self.save_options)
        methods = self._add_experiments(context) if has_laboratory() else None
        self.both = BothModes(context, self.faces, self.manual, methods)
        self.readings = Readings(context)
        self.figure = Figure(context, self.readings)
        self.hints = Hints(context)
        self.screen = Screen(context)
        self.screen.screen_changed.connect(self.strip.draw_again)
        self.workspaces = Workspaces(context)
        self.marks = Marks(context, self.recipe, self.files, self.points, self.overlays)
        self.history = History(context, self.saver)
        self.commands = Commands(context)
        self.kept = KeptFeature(context, self.strip)
        self.documentation = Documentation(context)
        self.speech = Speech(context, self.points, self.recipe, self.faces, self.history)

    def _add_experiments(self, context: Context) -> QAction:
        """Add the lab's features; return the action that compares methods."""
        # Import the lab package here: the folder may be missing.
        from .features.experiments import Experiments, evidence, trials

        self.experiments = Experiments(context, self.landmarks)
        trials.Trials(context, self.faces, self.manual)
        evidence.EvidenceFiles(context)
        return self.experiments.starts["methods"]

    def _mount(self) -> None:
        """Connect the signals of all features and lay out the panels."""
        window = self.window
        for feature in self.features:
            feature.message.connect(window.bar.say)
            feature.working.connect(window.status.hint)
            feature.did.connect(window.status.tell)
        shown = (
            *(self.manual, self.push, self.recipe, self.protect, self.overlays),
            *(self.faces, self.readings, self.both, self.history, self.strip),
        )
        self.document.watch(window.bar.refresh)
        self.view.watch(window.bar.refresh, "face", "also", "frame")
        window.arranged.connect(window.bar.refresh)
        self.faces.found.connect(lambda _: window.stage.place_bar())
        window.lay_out({it.name: (it.panel, it.dock) for it in shown if it.panel is not None})
        self.speech.listen()
        self.screen.restore()

    @property
    def busy(self) -> bool:
        """True while any job runs."""
        return self.live.busy or any(feature.busy for feature in self.features)

    def close(self) -> None:
        """Close the window without a question and wait for the workers."""
        self._follows_system(False)
        self.live.stop()
        for feature in self.features:
            feature.stop()
        self.window.really_close()
        for pool in self._pools:
            pool.waitForDone()
        for feature in self.features:
            feature.finish()
        self.document.close()
        # All workers have ended: restore automatic garbage collection.
        self._garbage.timer.stop()
        gc.unfreeze()
        gc.enable()

    def admit(self, why: str) -> None:
        """Show a message about an unexpected error."""
        text = tr(
            "Something went wrong in Kogao itself ({why}). Your work is still here: save it, then "
            "start the program again. {file} tells more.",
            why=why,
            file=self._log,
        )
        save = BarAction(tr("Save the project"), self.projects.save)
        self.window.bar.say(Message(text, () if self.document.photo is None else (save,)))

    def _say_not_drawn(self, problem: Exception) -> None:
        text = tr(
            "The picture can't be redrawn ({why}); the next change tries again.",
            why=reason(problem),
        )
        # The message applies until the next frame.
        frame = self.view.frame
        self.window.bar.say(Message(text, applies=lambda: self.view.frame is frame))

    def _follows_system(self, wanted: bool) -> None:
        if wanted == self._following:
            return
        changed = self._app.styleHints().colorSchemeChanged
        if wanted:
            changed.connect(self._dress)
        else:
            changed.disconnect(self._dress)
        self._following = wanted

    def _dress(self) -> None:
        choice = self._wanted or self.preferences.theme
        if choice == "system" and self._portal is not None and self._portal.is_light:
            choice = "light"
        worn = theme.apply(self._app, choice)
        # Skip other preferences, which may change with each typed letter.
        if worn != self._worn:
            self._worn = worn
            self.window.dress(worn)
