"""Evidence is written by a key and shown with values under linked cursors."""

import numpy as np
import pytest
from kogao_app.features.experiments import evidence
from kogao_app.features.experiments.evidence import EvidenceDialog
from PySide6.QtCore import Qt

import kogao_core as kogao

CONTROL, SHIFT, ALT = (
    Qt.KeyboardModifier.ControlModifier,
    Qt.KeyboardModifier.ShiftModifier,
    Qt.KeyboardModifier.AltModifier,
)


@pytest.fixture
def asked(monkeypatch):
    """Record what the key asks for."""
    calls = []
    monkeypatch.setattr(
        evidence, "ask_path", lambda _w, title, taken, *_a, **_b: calls.append((title, taken))
    )
    return calls


def test_the_key_writes_the_numbers_of_the_result(opened, asked, tmp_path):
    opened.settle()
    opened.key(Qt.Key.Key_N, CONTROL, SHIFT)
    ((title, write),) = asked
    assert title == "Write evidence"
    write(tmp_path / "e.npz")
    opened.settle()
    found = kogao.load_evidence(tmp_path / "e.npz")
    image = opened.editor.document.image
    assert found.size == (image.width, image.height)
    assert found.recipe == opened.state.recipe
    assert len(found.made["photo_sha256"]) == 64
    write(tmp_path / "none" / "e.npz")
    opened.settle()
    assert "can't be written" in opened.window.bar.text.text()


def test_two_files_are_shown_with_their_difference_and_values(opened, tmp_path):
    photo = opened.editor.document.photo
    files = []
    for percent in (3.0, 6.0):
        recipe = kogao.Recipe(percent=percent)
        rendering = kogao.render(photo.pixels, opened.state.active, recipe)
        files.append(tmp_path / f"{percent:g}.npz")
        rendering.save_evidence(files[-1])
    feature = opened.editor.evidence
    feature.compare(*files)
    dialog = next(d for d in opened.window.findChildren(EvidenceDialog) if d.isVisible())
    for image in dialog.images:
        (left, right), (top, bottom) = image.getViewBox().viewRange()
        size = opened.editor.document.image
        assert max(left, top) <= 1.0, "the whole picture is shown at first"
        assert (right >= size.width - 1.0, bottom >= size.height - 1.0) == (True, True)
    a, b = (kogao.load_evidence(file) for file in files)
    lengths = [np.hypot(*np.moveaxis(one.displacement_px, 2, 0)) for one in (a, b)]
    np.testing.assert_allclose(dialog.images[2].image, lengths[0] - lengths[1], atol=1e-5)
    row, column = np.unravel_index(lengths[1].argmax(), lengths[1].shape)
    dialog.point_at(float(column), float(row))
    dx = b.displacement_px[row, column, 0]
    assert f"displacement {dx:.3f}" in dialog.values.text().splitlines()[1]
    assert "cell of lattice 1: (" in dialog.values.text()
    assert all(lines[0].value() == column for lines in dialog._cursors)
    dialog.layers.setCurrentIndex(1)
    np.testing.assert_allclose(dialog.images[0].image, a.det_j, atol=1e-6)
    first, second = (image.getViewBox() for image in dialog.images[:2])
    first.setRange(xRange=(10, 40), yRange=(10, 40))
    assert second.viewRange()[0] == pytest.approx(first.viewRange()[0], abs=20.0)
    dialog.close()
    (tmp_path / "no.npz").write_bytes(b"none")
    feature.compare(tmp_path / "no.npz")
    assert "is not an evidence file" in opened.window.bar.text.text()
