"""One editor window with everything behind it: the only place where all classes meet."""

from __future__ import annotations

from PySide6.QtCore import QObject, Qt, QThreadPool
from PySide6.QtWidgets import QApplication

from kogao_core.face import LandmarkSource

from . import actions, menus, theme
from .controllers.choices import Choices
from .controllers.dialogs import Dialogs
from .controllers.editing import Editing
from .controllers.files import Files
from .controllers.live import Live
from .controllers.recovery import Recovery
from .controllers.saver import Saver
from .document import Document
from .garbage import Collector
from .i18n import reason, tr
from .layers import ON_AT_FIRST, layers
from .parts.batch import BatchPart
from .parts.canvas import CanvasPart
from .parts.desk import Desk
from .parts.display import DisplayPart
from .parts.experiments import ExperimentsPart
from .parts.interchange import InterchangePart
from .parts.landmarks import LandmarksPart
from .parts.manual import ManualPart
from .parts.presets import PresetsPart
from .parts.projects import ProjectsPart
from .parts.rating import RatingPart
from .parts.saving import SavingPart
from .scene import Scene
from .storage import Storage
from .views.about import about_box
from .views.bar import Message, Step
from .views.window import Window


class Editor(QObject):
    """Builds the parts and joins signals to slots.

    Parameters
    ----------
    app : QApplication
        The application, for its theme.
    source : LandmarkSource
        What finds the faces.
    storage : Storage
        Where settings and recovery files lie.
    choice : {"system", "light", "dark"}
        Colours of the window.
    """

    def __init__(
        self,
        app: QApplication,
        source: LandmarkSource,
        storage: Storage,
        choice: theme.Choice = "system",
    ) -> None:
        super().__init__()
        self._garbage = Collector(self)
        self._app, self._choice, self._log = app, choice, storage.log
        self._pool = QThreadPool(self)
        self._pool.setMaxThreadCount(4)
        # A thread for each of its lanes: whatever else takes minutes, the picture doesn't wait.
        self._rendering = QThreadPool(self)
        self._rendering.setMaxThreadCount(3)
        self.scene = Scene(visible=set(ON_AT_FIRST))
        self.document = Document(self)
        self.window = Window(self.scene)
        self.editing = Editing(self.document, self.scene, self)
        self.choices = Choices(self.document, self.scene, self.editing, self)
        self.live = Live(self.document, self.scene, self.window.canvas, self._rendering, self)
        self.saver = Saver(self.document, self.editing, self)
        self.files = Files(self.document, self.editing, self.saver, source, self._pool, self)
        self.dialogs = Dialogs(self.document, self.files, self.saver, self.window)
        self.recovery = Recovery(
            self.document, self.files, self.dialogs, storage.recovery, self._pool, self
        )
        self.projects = ProjectsPart(
            self.document, self.saver, self.files, self.dialogs, self.window, self._pool, self
        )
        self._join_actions()
        self._join_canvas()
        self.on_canvas = CanvasPart(
            self.document, self.scene, self.editing, self.live, self.window, self._pool, self
        )
        settings = storage.settings()
        self.desk = Desk(self.document, self.dialogs, self.window, settings, self._pool, self)
        self.presets = PresetsPart(
            self.document, self.scene, self.choices, self.window, settings, self
        )
        self.by_hand = ManualPart(
            self.document, self.scene, self.editing, self.files, self.window, self._pool, self
        )
        self.by_hand.take_brush(self.on_canvas.protecting)
        self.landmarks = LandmarksPart(source, self.files, self.window, self)
        self.saving = SavingPart(self.files, self.window, settings, self)
        self.batch = BatchPart(self.document, self.landmarks, self.window, settings, self)
        self.interchange = InterchangePart(self.document, self.editing, self.window, self)
        self.experiments = ExperimentsPart(
            self.document,
            self.landmarks,
            self.by_hand.manual,
            storage.data,
            self.window,
            self._pool,
            self,
        )
        self.rating = RatingPart(self.window, self)
        self._join_panels()
        self._join_messages()
        self._following = False
        self._follows_system(True)
        self._dress()
        self.display = DisplayPart(
            self.document,
            self.scene,
            self.choices,
            self.live,
            self.window,
            (self.on_canvas.protecting.changed, self.by_hand.manual.changed, self.editing.restyled),
            self,
        )

    @property
    def busy(self) -> bool:
        """True while anything is under way."""
        parts = (
            *(self.files, self.live, self.on_canvas, self.by_hand, self.recovery, self.desk),
            *(self.saver, self.projects, self.batch, self.experiments),
        )
        return any(part.busy for part in parts)

    def admit(self, why: str) -> None:
        """Say that something has failed that nobody expected."""
        text = tr(
            "Something went wrong in Kogao itself ({why}). Your work is still here: save it, then "
            "start the program again. {file} tells more.",
            why=why,
            file=self._log,
        )
        save = Step(tr("Save the project"), self.projects.projects.save)
        self.window.bar.say(Message(text, () if self.document.photo is None else (save,)))

    def close(self) -> None:
        """Close the window without a question and wait for the workers."""
        self._follows_system(False)
        self.files.stop()
        self.live.stop()
        self.on_canvas.stop()
        self.by_hand.stop()
        self.recovery.stop()
        self.projects.stop()
        self.batch.stop()
        self.experiments.stop()
        self.desk.stop()
        self.rating.stop()
        self.display.stop()
        self.window.really_close()
        self.saver.stop()
        for pool in (self._rendering, self._pool):
            pool.waitForDone()
        self._garbage.stop()
        self.recovery.clear()

    def _join_actions(self) -> None:
        canvas = self.window.canvas
        actions.connect(
            self.window.actions_by_name,
            {
                "open": self.dialogs.ask_open,
                "sample": self.dialogs.open_sample,
                "save": self.dialogs.ask_save,
                "quit": self.window.close,
                "undo": self.editing.undo,
                "redo": self.editing.redo,
                "abort": self.editing.abort,
                "fit": canvas.fit,
                "actual": lambda: canvas.zoom_to(1.0),
                "closer": lambda: canvas.zoom_to(canvas.zoom * 1.5),
                "farther": lambda: canvas.zoom_to(canvas.zoom / 1.5),
                "find": self.files.find,
                "next-point": lambda: self._select_next(1),
                "previous-point": lambda: self._select_next(-1),
                "place": self.files.place,
                "copy-settings": self.choices.copy,
                "paste-settings": self.choices.paste,
                "follow-photo": self.choices.follow_photo,
                "about": lambda: about_box(self.window).open(),
            },
        )
        self.window.actions_by_name["hide-overlays"].toggled.connect(self.window.overlays.hide_all)
        for layer in layers():
            action = self.window.actions_by_name[menus.overlay_action(layer.name)]
            action.toggled.connect(lambda on, name=layer.name: canvas.show_overlay(name, on))

    def _select_next(self, step: int) -> None:
        # Wherever the keys went before, the arrows move the point now.
        self.window.canvas.setFocus(Qt.FocusReason.ShortcutFocusReason)
        self.editing.select_next(step)

    def _join_canvas(self) -> None:
        canvas, window = self.window.canvas, self.window
        canvas.picked.connect(self.choices.choose)
        canvas.grabbed.connect(self.editing.grab)
        canvas.dragged.connect(self.editing.drag)
        canvas.released.connect(self.editing.release)
        canvas.nudged.connect(self.editing.nudge)
        canvas.nudge_ended.connect(self.editing.commit)
        canvas.hovered.connect(self.editing.hover)
        canvas.hovered.connect(lambda _, x, y: window.status.show_cursor(x, y))
        canvas.dragged.connect(window.status.show_cursor)
        canvas.stroked.connect(lambda x, y, _: window.status.show_cursor(x, y))
        window.original_held.connect(canvas.show_original)
        window.asked_to_close.connect(
            lambda: self.batch.guard(lambda: self.dialogs.guard(self.close))
        )
        self.editing.aborted.connect(canvas.let_go)
        self.editing.restyled.connect(canvas.redraw)

    def _join_panels(self) -> None:
        window = self.window
        window.recipe.edited.connect(self.choices.set_field)
        window.recipe.follow.connect(self.choices.follow_photo)
        window.faces.chosen.connect(self.choices.choose)
        self.choices.chosen.connect(window.canvas.redraw)
        window.recipe.rested.connect(self.editing.commit)
        window.faces.switched.connect(self.editing.switch_face)
        self.editing.aborted.connect(window.recipe.abort)
        self.live.drawn.connect(self.by_hand.manual.clock.show_photo)

    def _join_messages(self) -> None:
        window = self.window
        self.files.said.connect(window.bar.say)
        self.recovery.said.connect(window.bar.say)
        self.desk.said.connect(window.bar.say)
        self.recovery.answered.connect(window.bar.refresh)
        window.bar.dismissed.connect(self.recovery.offer)
        self.files.quiet.connect(window.bar.clear)
        self.document.undo.indexChanged.connect(window.bar.move_on)
        self.document.opened.connect(window.bar.move_on)
        self.files.quiet.connect(window.empty.hide)
        self.files.unreadable.connect(lambda _: self.desk.pass_over())
        self.files.working.connect(window.status.hint)
        self.saver.working.connect(window.status.hint)
        self.editing.named.connect(window.status.name_point)
        self.choices.said.connect(window.bar.say)
        self.landmarks.said.connect(window.bar.say)
        self.experiments.said.connect(window.bar.say)
        self.rating.said.connect(window.bar.say)
        self.interchange.said.connect(window.bar.say)
        self.live.failed.connect(self._say_not_drawn)

    def _say_not_drawn(self, problem: Exception) -> None:
        text = tr(
            "The picture can't be redrawn ({why}); the next change tries again.",
            why=reason(problem),
        )
        self.window.bar.say(Message(text))

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
        self.window.dress(theme.apply(self._app, self._choice))
