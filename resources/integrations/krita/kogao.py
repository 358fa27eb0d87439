"""Kogao for Krita: the picture goes to Kogao, and comes back as a new layer.

Krita's Python has none of Kogao's libraries, so that Kogao runs as a program of its own.
"""

import tempfile
from functools import partial
from pathlib import Path

from krita import Extension, InfoObject, Krita
from PyQt5.QtCore import QEventLoop, QProcess, QProcessEnvironment
from PyQt5.QtWidgets import QInputDialog, QMessageBox

from .kogao_outside import (
    AMOUNT,
    BY_ITSELF,
    CANCELLED,
    CLOSED,
    EDIT_TITLE,
    EDITOR,
    LARGEST,
    PERCENT,
    SHARED,
    SMALLER_TITLE,
    THEIRS,
    cannot_start,
    is_ours,
    layer_name,
)

ACTIONS = {
    "kogao_edit": (EDIT_TITLE, EDITOR),
    "kogao_by_itself": (SMALLER_TITLE, BY_ITSELF),
}


class Scripts(Extension):
    """Two actions under Tools > Scripts."""

    def setup(self):
        """Do nothing: Krita asks for this."""

    def createActions(self, window):  # noqa: N802
        """Put the actions into a window's menu."""
        for name, (title, command) in ACTIONS.items():
            action = window.createAction(name, title, "tools/scripts")
            action.triggered.connect(partial(self._send, command))

    def _send(self, command, *_):
        document = Krita.instance().activeDocument()
        if document is None:
            return
        if command is BY_ITSELF:
            percent = _asked()
            if percent is None:
                return
            command = [*command, "--percent", f"{percent:g}"]
        with tempfile.TemporaryDirectory(prefix="kogao-", dir=SHARED) as folder:
            path = str(Path(folder, "picture.png"))
            code, problem, said = self._work_on(document, command, path)
            if code == 0:
                problem = _bring_back(document, path, layer_name(said))
        if problem and code != CANCELLED:
            QMessageBox.warning(None, "Kogao", problem)

    def _work_on(self, document, command, path):
        """Write what is visible, let Kogao write over it; its code, its complaint, what it says."""
        options = InfoObject()
        options.setProperty("alpha", True)
        options.setProperty("saveSRGBProfile", True)  # without one Krita would ask for it again
        document.waitForDone()
        source = _without_ours(document)
        source.setBatchmode(True)
        is_written = source.exportImage(path, options)
        source.close()
        if not is_written:
            return 1, "The picture can't be written as a PNG file.", ""
        process, done = QProcess(), QEventLoop()
        surroundings = QProcessEnvironment.systemEnvironment()
        for name in (*THEIRS, "QT_PLUGIN_PATH"):
            surroundings.remove(name)
        process.setProcessEnvironment(surroundings)
        process.finished.connect(done.quit)
        process.errorOccurred.connect(done.quit)
        process.start(command[0], [*command[1:], path])
        if process.state() != QProcess.NotRunning:
            done.exec_()  # Krita goes on meanwhile
        if process.error() == QProcess.FailedToStart:
            return 1, cannot_start(command[0], "krita"), ""
        error, said = (
            bytes(stream).decode(errors="replace").strip()
            for stream in (process.readAllStandardError(), process.readAllStandardOutput())
        )
        return process.exitCode(), error or f"Kogao ended with {process.exitCode()}.", said


def _asked():
    """Return the percentage to go by, and keep it; None for none."""
    kept = float(Krita.instance().readSetting("kogao", "percent", str(PERCENT)))
    percent, wanted = QInputDialog.getDouble(
        None, SMALLER_TITLE.replace("&", ""), AMOUNT, kept, 0, LARGEST, 1
    )
    if not wanted:
        return None
    Krita.instance().writeSetting("kogao", "percent", str(percent))
    return percent


def _without_ours(document):
    """Return a copy of a picture without Kogao's layers, unless nothing else is seen there."""
    copy = document.clone()
    shown = [node for node in copy.topLevelNodes() if node.visible()]
    ours = [node for node in shown if is_ours(node.name())]
    for node in ours if len(ours) < len(shown) else ():
        node.setVisible(False)
    copy.refreshProjection()
    copy.waitForDone()
    return copy


def _bring_back(document, path, title):
    """Lay a file over all other layers, or return why not."""
    if document not in Krita.instance().documents():
        return CLOSED
    result = Krita.instance().openDocument(path)
    if result is None:
        return "The result can't be read."
    try:
        if (result.width(), result.height()) != (document.width(), document.height()):
            return "The picture has got another size meanwhile."
        result.setColorSpace(document.colorModel(), document.colorDepth(), document.colorProfile())
        result.waitForDone()
        place = 0, 0, result.width(), result.height()
        layer = document.createNode(title, "paintlayer")
        layer.setPixelData(result.pixelData(*place), *place)
        document.rootNode().addChildNode(layer, None)
        document.refreshProjection()
    finally:
        result.close()
    return ""


Krita.instance().addExtension(Scripts(Krita.instance()))
