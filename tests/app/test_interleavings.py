"""Edits, saves, syncs, full disks and crashes in any order lose no edit."""

import pytest
from few_cases import few_of
from interleaving import Interleaving


@pytest.mark.parametrize("seed", few_of((5, 12, 1), 1))
def test_no_edit_is_lost_whatever_falls_between(qapp, tmp_path, seed):
    run = Interleaving(qapp, tmp_path, seed)
    run.run(40)
    assert run.counts.total() >= 40
    assert run.counts["crash"] + run.counts["close"] + run.counts["open_another"] > 3


@pytest.mark.slow
def test_five_hundred_orders_lose_no_edit_and_undo_takes_each_sync_back(qapp, tmp_path):
    kinds = ("sync", "undone sync", "crash", "saved", "reset", "restored", "reopened")
    run = Interleaving(qapp, tmp_path, 1)
    run.run(500, dict.fromkeys(kinds, 2))
    assert run.counts.total() >= 500
