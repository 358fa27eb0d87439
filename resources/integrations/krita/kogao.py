"""Kogao for Krita: the picture goes to Kogao, and comes back as a new layer.

Krita's Python has none of Kogao's libraries, so that Kogao runs as a program of its own.
"""

import tempfile
from functools import partial
from pathlib import Path

from krita import Extension, InfoObject, Krita
from PyQt5.QtCore import QEventLoop, QProcess, QProcessEnvironment
from PyQt5.QtWidgets import QMessageBox

from .kogao_outside import BY_ITSELF, CANCELLED, EDITOR, SHARED, THEIRS

ACTIONS = {
    "kogao_edit": ("Kogao: edit…", EDITOR),
    "kogao_by_itself": ("Kogao: smaller faces", BY_ITSELF),
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
        with tempfile.TemporaryDirectory(prefix="kogao-", dir=SHARED) as folder:
            path = str(Path(folder, "picture.png"))
            code, problem = self._work_on(document, command, path)
            if code == 0:
                problem = _bring_back(document, path)
        if problem and code != CANCELLED:
            QMessageBox.warning(None, "Kogao", problem)

    def _work_on(self, document, command, path):
        """Write what is visible, let Kogao write over it, and return its code and its complaint."""
        options = InfoObject()
        options.setProperty("alpha", True)
        options.setProperty("saveSRGBProfile", True)  # without one Krita would ask for it again
        document.waitForDone()
        document.setBatchmode(True)
        is_written = document.exportImage(path, options)
        document.setBatchmode(False)
        if not is_written:
            return 1, "The picture can't be written as a PNG file."
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
            return 1, f"{command[0]} can't be started; run kogao-cli integrate krita again."
        said = bytes(process.readAllStandardError()).decode(errors="replace").strip()
        return process.exitCode(), said or f"Kogao ended with {process.exitCode()}."


def _bring_back(document, path):
    """Lay a file over all other layers, or return why not."""
    if document not in Krita.instance().documents():
        return "The picture was closed meanwhile."
    result = Krita.instance().openDocument(path)
    if result is None:
        return "The result can't be read."
    try:
        if (result.width(), result.height()) != (document.width(), document.height()):
            return "The picture has got another size meanwhile."
        result.setColorSpace(document.colorModel(), document.colorDepth(), document.colorProfile())
        result.waitForDone()
        place = 0, 0, result.width(), result.height()
        layer = document.createNode("Kogao", "paintlayer")
        layer.setPixelData(result.pixelData(*place), *place)
        document.rootNode().addChildNode(layer, None)
        document.refreshProjection()
    finally:
        result.close()
    return ""


Krita.instance().addExtension(Scripts(Krita.instance()))
