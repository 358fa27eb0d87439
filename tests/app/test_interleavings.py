"""Edits, saves, syncs, full disks and crashes in any order lose no edit."""

import pytest
from few_cases import few_of
from interleaving import Interleaving
from random_user import RandomUser, equals_a_fresh_render


@pytest.mark.parametrize("seed", few_of((5, 12, 1), 1))
def test_no_edit_is_lost_whatever_falls_between(qapp, tmp_path, seed):
    run = Interleaving(qapp, tmp_path, seed)
    run.run(30)
    assert run.counts.total() >= 30
    assert run.counts["crash"] + run.counts["close"] + run.counts["open_another"] > 3


@pytest.mark.slow
def test_five_hundred_orders_lose_no_edit_and_undo_takes_each_sync_back(qapp, tmp_path):
    kinds = ("sync", "undone sync", "crash", "saved", "reset", "restored", "reopened")
    run = Interleaving(qapp, tmp_path, 1)
    run.run(500, dict.fromkeys(kinds, 2))
    assert run.counts.total() >= 500


def test_random_edits_end_where_a_fresh_render_does(opened, source):
    user = RandomUser(opened.editor, source.faces[0], seed=5)
    for number in range(24):
        user.edit()
        opened.qtbot.wait(1)
        if number % 6 == 5:
            opened.settle()
            assert equals_a_fresh_render(opened.editor), user.counts
    assert len(user.counts) >= 7, user.counts
