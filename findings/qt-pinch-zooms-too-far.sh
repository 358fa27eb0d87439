#!/bin/bash
# One would guess: Qt's pinch gesture tells how far two fingers have moved apart; from 100 to 200 px
# `totalScaleFactor` is 2, and the product of `scaleFactor` too.
# What happens: with ten moves of both fingers it is 3.6, and 7.2 if the fingers move in turn, as on
# X11, where each finger's way is an event of its own. Each step is compared with the places two
# events before. A real touch screen of Xorg shows the same steps.
# Why a portrait editor cares: a photo zoomed by Qt's factor runs away below the fingers. The right
# distance is in the gesture: the hot spot is one finger, `centerPoint` is the middle of both.
# Versions: PySide6-Essentials 6.11.3. 2026-11-28.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install -q PySide6-Essentials==6.11.3
QT_QPA_PLATFORM=offscreen "$folder/env/bin/python" - <<'PY'
from PySide6.QtCore import QLineF, QPoint, Qt, qVersion
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QGestureEvent, QWidget


class Pad(QWidget):
    def __init__(self):
        super().__init__()
        self.grabGesture(Qt.GestureType.PinchGesture)

    def event(self, event):
        if isinstance(event, QGestureEvent):
            pinch = event.gesture(Qt.GestureType.PinchGesture)
            apart = 2 * QLineF(pinch.hotSpot(), pinch.centerPoint()).length()
            self.told.append((pinch.totalScaleFactor(), apart))
            return True
        return super().event(event)


app = QApplication([])
device = QTest.createTouchDevice()
pad = Pad()
pad.resize(400, 400)
pad.show()
assert QTest.qWaitForWindowExposed(pad)


def spread(in_turn):
    """Move two fingers from 100 to 200 px apart, in ten parts."""
    pad.told = []
    fingers = QTest.touchEvent(pad, device, False)
    at = {0: QPoint(150, 200), 1: QPoint(250, 200)}
    fingers.press(0, at[0], pad).commit()
    fingers.stationary(0).press(1, at[1], pad).commit()
    for _ in range(10):
        at = {0: at[0] - QPoint(5, 0), 1: at[1] + QPoint(5, 0)}
        if in_turn:
            fingers.move(0, at[0], pad).stationary(1).commit()
            fingers.stationary(0).move(1, at[1], pad).commit()
        else:
            fingers.move(0, at[0], pad).move(1, at[1], pad).commit()
    factor, apart = pad.told[-1]
    fingers.release(0, at[0], pad).release(1, at[1], pad).commit()
    return factor, apart


together, in_turn = spread(False), spread(True)
for name, (factor, apart) in (("together", together), ("in turn", in_turn)):
    print(f"Qt {qVersion()}, {name}: 100 to {apart:.0f} px apart, factor {factor:.2f}")
assert together[1] == in_turn[1] == 200.0
assert together[0] > 3.0, "it has changed"
assert in_turn[0] > 6.0, "it has changed"
PY
