"""Kogao for Krita: sends the picture to Kogao and adds the result as a new layer.

Krita's Python has none of Kogao's libraries, so Kogao runs as a separate program.
"""

import tempfile
from functools import partial
from pathlib import Path

from krita import Extension, InfoObject, Krita

try:  # Krita 6
    from PyQt6.QtCore import QEventLoop, QProcess, QProcessEnvironment
    from PyQt6.QtGui import QImage
    from PyQt6.QtWidgets import QInputDialog, QMessageBox
except ImportError:  # Krita 5
    from PyQt5.QtCore import QEventLoop, QProcess, QProcessEnvironment
    from PyQt5.QtGui import QImage
    from PyQt5.QtWidgets import QInputDialog, QMessageBox

from .kogao_outside import (
    AMOUNT,
    AMOUNT_LABEL,
    CANCELLED,
    CLOSED,
    EDIT_TITLE,
    EDITOR,
    HOST_VARIABLES,
    LARGEST,
    SMALLER,
    SMALLER_TITLE,
    TEMPORARY,
    cannot_start,
    is_result,
    layer_name,
    problem,
)

MASK_OPTIONS = "--protect", "--mask"  # of the command line and of the editor
ACTIONS = {
    "kogao_edit": (EDIT_TITLE, EDITOR),
    "kogao_smaller": (SMALLER_TITLE, SMALLER),
}


class Scripts(Extension):
    """Two actions under Tools > Scripts."""

    def setup(self):
        """Do nothing; Krita requires this method."""

    def createActions(self, window):  # noqa: N802
        """Add the actions to the menu of a window."""
        for name, (title, command) in ACTIONS.items():
            action = window.createAction(name, title, "tools/scripts")
            action.triggered.connect(partial(self._send, command))

    def _send(self, command, *_):
        document = Krita.instance().activeDocument()
        if document is None:
            return
        if command is SMALLER:
            amount = _ask_amount()
            if amount is None:
                return
            command = [*command, "--amount", f"{amount:g}"]
        with tempfile.TemporaryDirectory(prefix="kogao-", dir=TEMPORARY) as folder:
            path, mask = str(Path(folder, "picture.png")), str(Path(folder, "mask.png"))
            if _save_selection(document, mask):
                command = [*command, MASK_OPTIONS["--edit" in command], mask]
            code, message, output = self._run(document, command, path)
            if code == 0:
                message = _add_layer(document, path, layer_name(output))
        if message and code != CANCELLED:
            QMessageBox.warning(None, "Kogao", message)

    def _run(self, document, command, path):
        """Run Kogao on the visible picture. Return exit code, error message and output."""
        options = InfoObject()
        options.setProperty("alpha", True)
        options.setProperty("saveSRGBProfile", True)  # otherwise Krita asks for a profile
        document.waitForDone()
        source = _without_results(document)
        source.setBatchmode(True)
        is_written = source.exportImage(path, options)
        source.close()
        if not is_written:
            return 1, "The picture can't be written as a PNG file.", ""
        process, loop = QProcess(), QEventLoop()
        variables = QProcessEnvironment.systemEnvironment()
        for name in (*HOST_VARIABLES, "QT_PLUGIN_PATH"):
            variables.remove(name)
        process.setProcessEnvironment(variables)
        process.finished.connect(loop.quit)
        process.errorOccurred.connect(loop.quit)
        process.start(command[0], [*command[1:], path])
        if process.state() != QProcess.ProcessState.NotRunning:
            loop.exec()  # keeps Krita's windows alive
        if process.error() == QProcess.ProcessError.FailedToStart:
            return 1, cannot_start(command[0], "krita"), ""
        errors, output = (
            bytes(stream).decode(errors="replace")
            for stream in (process.readAllStandardError(), process.readAllStandardOutput())
        )
        code, picture = process.exitCode(), Path(document.fileName() or "picture").name
        return code, problem(code, errors, path, picture), output


def _ask_amount():
    """Ask for the Amount, %, and store the answer. Return None if the user cancels."""
    stored = float(Krita.instance().readSetting("kogao", "amount", str(AMOUNT)))
    amount, is_accepted = QInputDialog.getDouble(
        None, SMALLER_TITLE.replace("&", ""), AMOUNT_LABEL, stored, 0, LARGEST, 1
    )
    if not is_accepted:
        return None
    Krita.instance().writeSetting("kogao", "amount", str(amount))
    return amount


def _without_results(document):
    """Return a copy of a picture; hide Kogao's results unless all visible layers are results."""
    copy = document.clone()
    visible = [node for node in copy.topLevelNodes() if node.visible()]
    results = [node for node in visible if is_result(node.name())]
    for node in results if len(results) < len(visible) else ():
        node.setVisible(False)
    copy.refreshProjection()
    copy.waitForDone()
    return copy


def _save_selection(document, path):
    """Write the selection, white on black; return False without one."""
    selection = document.selection()
    if selection is None:
        return False
    width, height = document.width(), document.height()
    shares = bytes(selection.pixelData(0, 0, width, height))
    kind = QImage.Format.Format_Grayscale8
    return QImage(shares, width, height, width, kind).save(path)


def _add_layer(document, path, title):
    """Add a file as the top layer. Return an error message or None."""
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
