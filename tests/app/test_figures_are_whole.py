"""Figures are never cut: labels are elided first, and a panel without room scrolls."""

from __future__ import annotations

from functools import partial

import pytest
from PySide6.QtWidgets import QLabel, QWidget

from kogao_core.base.language import use_language

COUNTS = {"image": 12_166_656, "control-points": 1_168_992, "threshold": 917_844}


def cut_figures(window):
    """Return labels that contain a digit and are narrower than their text."""
    return [
        (label.text(), label.width())
        for label in window.findChildren(QLabel)
        if label.isVisible()
        and any(letter.isdigit() for letter in label.text())
        and not label.wordWrap()
        and max(map(label.fontMetrics().horizontalAdvance, label.text().splitlines()))
        > label.contentsRect().width()
    ]


def none_is_cut(window, panel, size):
    assert window.size().toTuple() == size
    assert cut_figures(window) == []
    cells = [one for one in panel.timings.children() if isinstance(one, QWidget)]
    for place, cell in enumerate(cells):
        assert not [one for one in cells[:place] if one.geometry().intersects(cell.geometry())]


@pytest.mark.parametrize("language", ["en", "ja"])
def test_no_figure_is_cut_at_any_supported_size(start, photo, language, request):
    if language == "ja":
        request.getfixturevalue("spoken")
        use_language("ja")
    driver = start(photo)
    for size in ((1600, 1000), (1024, 700), (1093, 580)):
        driver.window.resize(*size)
        panel = driver.panel("readings")
        panel.forget()
        driver.qtbot.waitUntil(partial(none_is_cut, driver.window, panel, size))
        panel.domains.show_counts(COUNTS)
        panel.timings.show_laps(dict.fromkeys(panel.timings.rows, 12345.6))
        driver.qtbot.waitUntil(partial(none_is_cut, driver.window, panel, size))
