"""Programs for desktops without Python: made here, not part of the wheel."""
