"""How long faces take to be found, beside what the networks alone take."""

from __future__ import annotations

import time
from functools import partial
from unittest.mock import patch

import cv2
import numpy as np
import photographs
from paired import Case, timed

from kogao_core.base.geometry import Image
from kogao_core.faces.landmarks import MeshSource, locked
from kogao_core.faces.landmarks.blazeface import BlazeFace, Square
from kogao_core.faces.landmarks.pixels import Pyramid

ONE_FACE = (1000, 1000)
GROUP, CROWD = 18, 30
# Overlapping squares of the whole, a half and a quarter of the long side, and one from afar.
SCALES = ((1.0, 0.0), (0.5, 0.5), (0.25, 0.3), (2.0, 0.0))


class Networks:
    """Clocks the forward passes of networks that are read meanwhile."""

    def __init__(self) -> None:
        self.taken_s = 0.0
        self._read = cv2.dnn.readNetFromTFLite

    def clocked(self) -> object:
        """Return a context in which networks are read so that their passes count."""
        return patch.object(cv2.dnn, "readNetFromTFLite", self._clocked)

    def _clocked(self, *given: object) -> Clocked:
        return Clocked(self._read(*given), self)


class Clocked:
    """A network and its clock."""

    def __init__(self, net: object, clock: Networks) -> None:
        self._net, self._clock = net, clock

    def __getattr__(self, name: str) -> object:
        return getattr(self._net, name)

    def forward(self, *given: object) -> object:
        start = time.perf_counter()
        try:
            return self._net.forward(*given)
        finally:
            self._clock.taken_s += time.perf_counter() - start


def cases(width: int, height: int) -> dict[str, Case]:
    """Return what is timed, ms, on photos of this size: searches, and what they are held against.

    Everything is warm: networks are read and every kind of photo has been searched once.
    """
    source, clock, clocked = MeshSource(), Networks(), MeshSource()
    one = photographs.portraits(1)[0][: ONE_FACE[1], : ONE_FACE[0]]
    photos = {
        "one face": one,
        "group": photographs.group(width, height),
        "crowd": photographs.crowd(CROWD, width, height),
        "nobody": photographs.empty(width, height),
    }
    with clock.clocked():
        clocked.find(one)
    detector = BlazeFace(locked.network(locked.DETECTOR))

    def networks() -> float:
        clock.taken_s = 0.0
        clocked.find(one)
        return clock.taken_s * 1e3

    def first() -> float:
        heard: list[float] = []
        start = time.perf_counter()
        source.find(photos["crowd"], lambda _: heard.append(time.perf_counter()))
        return (heard[0] - start) * 1e3

    searches = {name: timed(partial(source.find, photo)) for name, photo in photos.items()}
    looks = timed(lambda: _looks(detector, photos["nobody"]))
    return {
        **searches,
        "again": searches["one face"],
        "first": first,
        "networks of one face": networks,
        "two looks": looks,
    }


def _looks(detector: BlazeFace, photo: Image) -> None:
    image, (height, width) = Pyramid(photo), photo.shape[:2]
    for share, overlap in SCALES:
        side = share * max(width, height)
        for y in _middles(height, side, overlap):
            for x in _middles(width, side, overlap):
                for _ in range(2):
                    detector.look(image, Square(np.array([x, y]), side), 0.5)


def _middles(length: int, side: float, overlap: float) -> np.ndarray:
    if length <= side:
        return np.array([(length - 1.0) / 2.0])
    count = int(np.ceil((length - side) / (side * (1.0 - overlap)))) + 1
    return np.linspace(side / 2.0, length - side / 2.0, count) - 0.5
