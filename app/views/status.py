"""The line below: hints, the cursor, the photo, and how fast it was drawn."""

from __future__ import annotations

from PySide6.QtWidgets import QLabel, QStatusBar

from kogao_core.photo import Photo, formats

from ..colour import way_of
from ..i18n import tr


class StatusLine(QStatusBar):
    """Facts on the right, hints on the left."""

    def __init__(self) -> None:
        super().__init__()
        self.setSizeGripEnabled(False)
        self._hint, self._cursor, self._photo, self._speed = (QLabel() for _ in range(4))
        self._zoom = QLabel()
        self._tool = self._standing = ""
        self._hint.setContentsMargins(8, 0, 0, 0)
        self.addWidget(self._hint, 1)
        for label in (self._cursor, self._photo, self._speed, self._zoom):
            label.setProperty("muted", "true")
            label.setContentsMargins(8, 4, 8, 4)
            self.addPermanentWidget(label)

    def show_tool(self, text: str) -> None:
        """Say what the tool in hand does, once it is another one."""
        if text != self._tool:
            self._tool = text
            self.hint("")

    def hint(self, text: str) -> None:
        """Say what is under way or has just been done; an empty text brings the tool back."""
        self._standing = text or self._tool
        self._hint.setText(self._standing)

    def name_point(self, text: str) -> None:
        """Name the point in question; an empty name brings the hint back."""
        self._hint.setText(text or self._standing)

    @property
    def hint_text(self) -> str:
        """What the hint says."""
        return self._hint.text()

    def show_cursor(self, x: float, y: float) -> None:
        """Show the pixel under the cursor; negative ones are none."""
        inside = x >= -0.5 and y >= -0.5
        self._cursor.setText(tr("x {x:.0f}  y {y:.0f}", x=x, y=y) if inside else "")

    def show_photo(self, photo: Photo) -> None:
        """Show size, depth, colour space, what reading changed and what a copy won't keep."""
        size = f"{photo.width} × {photo.height}"  # noqa: RUF001
        parts = [size, tr("{n}-bit", n=photo.bits)]
        way = way_of(photo)
        if photo.icc_profile is not None:
            unusable = tr("colour profile can't be used")
            parts.append((way.name or tr("colour profile")) if way.usable else unusable)
        notes = [*photo.notes, *filter(None, [_copied_as(photo).not_kept(photo.extras)])]
        if notes:
            parts.append(tr("notes: {n}", n=len(notes)))
        self._photo.setText(" · ".join(parts))
        self._photo.setToolTip("\n".join(notes))

    def show_speed(self, took_ms: float) -> None:
        """Show how long the newest picture took."""
        self._speed.setText(tr("drawn in {ms:.0f} ms", ms=took_ms))

    def show_zoom(self, zoom: float) -> None:
        """Show the zoom in %."""
        self._zoom.setText(f"{zoom * 100:.0f} %")


def _copied_as(photo: Photo) -> formats.FileFormat:
    """Return the format of a copy like the photo, or the one that holds most."""
    return next((form for form in formats.WRITTEN if form.name == photo.format), formats.TIFF)
