"""Faces by the Active Appearance Model, detected by BlazeFace or, without networks, by Haar."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Final

import cv2
import numpy as np

from kogao_core.base import assets
from kogao_core.base.geometry import Affine, Image
from kogao_core.base.threads import one_blas_thread
from kogao_core.faces.face import Face, OnFace, ignored, in_reading_order
from kogao_core.faces.landmarks import locked, search
from kogao_core.faces.landmarks.aam import points
from kogao_core.faces.landmarks.aam.fitting import Fit, fit_both_ways
from kogao_core.faces.landmarks.aam.model import Model, read
from kogao_core.faces.landmarks.blazeface import CLOSE, INPUT_PX, SURE, BlazeFace, Detection, Square
from kogao_core.faces.landmarks.mesh import LEAST_IN_COMPANY, LEAST_SCORE, WIDE_SHARE
from kogao_core.faces.landmarks.pixels import Pyramid

MODEL: Final = "models/aam.npz"
# Exponent of the residual in the trust; larger values separate good and bad fits more sharply.
_STEEP: Final = 4
_MOST_NEAR: Final = 1.25  # limit of a landmark's residual, relative to the face's limit
# Side of the picture that the cascade searches, px. The cascade's smallest face is 20 px.
_LOOK_PX: Final = 512
# Rotations for the cascade, degrees, upright first; the cascade tolerates about 15 degrees of tilt.
_TURNS: Final = (0.0, 30.0, -30.0, 90.0, -90.0, 180.0)
# Side and downward shift of BlazeFace's squares relative to the cascade's, on shared photographs.
_SIDE, _DOWN = 0.89, 0.12


class AamSource:
    """The paper's extractor (section 3.1) with learnt updates.

    Loads the model at first use. Thread-safe.
    """

    name = "aam"

    def __init__(self, model: Path | None = None) -> None:
        self._path = model
        self._lock = threading.Lock()  # a second search at once would need more networks

    @cached_property
    def _model(self) -> Model:
        return read(self._path or assets.path(MODEL))

    @cached_property
    def _detector(self) -> BlazeFace | None:
        try:
            return BlazeFace(locked.network(locked.DETECTOR))
        except assets.AssetMissing:
            return None

    @cached_property
    def _haar(self) -> HaarFaces:
        return HaarFaces()

    def find(self, rgb: Image, on_face: OnFace = ignored) -> list[Face]:
        """Return the faces of an upright image, `in_reading_order`; see `MeshSource.find`.

        `Face.score` is the detector's probability times the trust in the fit. The trust is 0.5 at
        the residual of the worst good fits. A sure detection lowers the least score for a face.
        """
        with self._lock, one_blas_thread():
            photo = _Photo(Pyramid(rgb), self._model)
            detector = self._detector
            if detector is None:
                faces = self._by_haar(photo, on_face)
            else:
                faces = search.faces(
                    photo.picture,
                    detector,
                    lambda box: photo.face_at(detector, box, LEAST_SCORE),
                    lambda box: photo.face_at(detector, box, LEAST_IN_COMPANY),
                    on_face,
                )
        return in_reading_order(faces)

    def _by_haar(self, photo: _Photo, on_face: OnFace) -> list[Face]:
        # The cascade gives no probability, and gives false boxes: accept only good fits.
        for boxes in self._haar.boxes(photo.picture):
            fits = [photo.fit(box) for box in boxes]
            good = [one for one in fits if not photo.doubts(one)]
            if good:
                faces = [photo.face(one, 1.0) for one in good]
                for face in faces:
                    on_face(face)
                return faces
        return []


@dataclass(frozen=True, eq=False)
class _Photo:
    picture: Pyramid
    model: Model

    def face_at(
        self, detector: BlazeFace, proposal: Detection, least: float
    ) -> search.Fitted | None:
        boxes, _ = detector.look_closer(self.picture, proposal)
        if not boxes:
            return None
        box, sure = boxes[0], boxes[0].score
        if sure <= SURE:
            close = detector.sight(self.picture, box, CLOSE)
            sure = WIDE_SHARE * sure + (1.0 - WIDE_SHARE) * close
        if sure <= least:
            return None
        fitted = self.fit(box)
        if self.doubts(fitted):
            # A few percent of faces are first detected upside down, or upright instead.
            upside_down = replace(box, degrees=box.degrees + 180.0, seen_wide=False)
            over, _ = detector.look_closer(self.picture, upside_down)
            if over:
                fitted = min(fitted, self.fit(over[0]), key=lambda one: one.residual)
        face = self.face(fitted, sure)
        # A face with a sure detection may be hard to fit; accept a lower score, as in company.
        least = LEAST_IN_COMPANY if sure > SURE else least
        return search.Fitted(face, box) if face.score > least else None

    def fit(self, box: Detection) -> Fit:
        return fit_both_ways(self.model, self.picture, self.model.start.points(box))

    def doubts(self, fitted: Fit) -> bool:
        return fitted.residual > self.model.most_residual

    def face(self, fitted: Fit, sure: float) -> Face:
        most = self.model.most_residual
        trust = 0.5 ** ((fitted.residual / most) ** _STEEP)
        near = 0.5 ** ((fitted.residuals / (_MOST_NEAR * most)) ** _STEEP)
        return points.face(fitted.points, sure * trust, near, AamSource.name)


class HaarFaces:
    """Face boxes without networks, by OpenCV's Haar cascade; not thread-safe."""

    def __init__(self) -> None:
        folder = Path(cv2.__file__).parent / "data"
        cascade = folder / "haarcascade_frontalface_alt2.xml"
        self._cascade = cv2.CascadeClassifier(str(cascade))

    def boxes(self, picture: Pyramid) -> Iterator[list[Detection]]:
        """Yield boxes without keypoints for one rotation after another, upright first."""
        center = np.array([picture.width - 1.0, picture.height - 1.0]) / 2.0
        side = float(np.hypot(picture.width, picture.height))
        for degrees in _TURNS:
            yield self._boxes(picture, Square(center, side, degrees))

    def _boxes(self, picture: Pyramid, view: Square) -> list[Detection]:
        to_image = view.to_image.after(Affine.resize(INPUT_PX / _LOOK_PX, INPUT_PX / _LOOK_PX))
        grey = cv2.cvtColor(picture.sample(to_image, _LOOK_PX), cv2.COLOR_RGB2GRAY)
        found = self._cascade.detectMultiScale(grey)
        return [
            Detection(
                to_image((x + width / 2.0 - 0.5, y + (0.5 + _DOWN) * width - 0.5)),
                _SIDE * width * to_image.scale,
                view.degrees,
                score=1.0,
            )
            for x, y, width, _ in sorted(map(tuple, found), key=lambda box: -box[2])
        ]
