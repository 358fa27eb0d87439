"""What Kogao has made is shown as such, and nobody is retouched twice unawares."""

from __future__ import annotations

import cv2
import numpy as np
from kogao_app.features.batch.dialog import BatchDialog
from kogao_app.features.batch.order import Order, carry_out
from test_saver import step

from kogao_core.recipe.recipe import Recipe


def copied(driver, path, percent=8.0):
    step(driver, percent)
    driver.editor.files.save(path)
    driver.settle()
    return path


def test_a_result_starts_untouched_and_leads_to_its_photo(opened, start, photo, tmp_path):
    copy = copied(opened, tmp_path / "anything.png")
    other = start(copy)
    assert other.say() == "anything.png is Kogao's own result of portrait.png: it starts at 0 %."
    assert other.state.recipe.percent == 0.0
    np.testing.assert_array_equal(other.shown, cv2.imread(str(copy))[..., ::-1])
    other.take_step("Open portrait.png")
    other.settle()
    assert other.editor.document.path == photo
    assert other.state.recipe.percent == 8.0


def test_work_on_a_result_that_was_wanted_is_there_again(opened, start, tmp_path):
    copy = copied(opened, tmp_path / "copy.png")
    other = start(copy)
    step(other, 3.0)
    other.settle()
    again = start(copy)
    assert again.state.recipe.percent == 3.0
    assert "own result" not in again.say()


def test_a_batch_of_a_folder_leaves_results_alone_and_says_so(opened, photo, storage, tmp_path):
    copied(opened, tmp_path / "copy.png")
    folder, went = tmp_path / "out", []
    order = Order((photo, tmp_path / "copy.png"), folder, Recipe(), projects=True)
    carry_out(order, storage, lambda: False, lambda _: None, went.append)
    assert [one.status for one in went] == ["done", "result"]
    assert "own result of portrait.png" in went[1].reason
    assert not (folder / "copy.png").exists()
    assert went[0].edit, "it did what the photo's own edits say"
    assert [one.result for one in storage.results.of(photo)][-1] == str(folder / "portrait.png")
    opened.editor.batch.show()
    dialog = opened.dialog(BatchDialog)
    opened.editor.batch.dialog.show_bad(went[1])
    assert dialog.bad.item(0).text().endswith("own result of portrait.png")
