"""How far a command is, off a terminal: a few lines, and none for what is quickly done."""

import pytest

from kogao_core.cli.common import CALM_S, ProgressLine


class Clock:
    now = 0.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock() -> Clock:
    return Clock()


def said(capsys: pytest.CaptureFixture[str]) -> list[str]:
    out, err = capsys.readouterr()
    assert out == "", "results alone go to standard output"
    return err.splitlines()


def test_what_is_quickly_done_says_nothing(capsys, clock):
    line = ProgressLine(clock)
    line.begin("1 of 1: photo.jpg")
    line.step(1, 1)
    line.end()
    assert said(capsys) == []


def test_lines_come_at_a_calm_rate(capsys, clock):
    line = ProgressLine(clock)
    line.begin("1 of 1: photo.jpg")
    for done in range(1, 13):
        clock.now += CALM_S / 4
        line.step(done, 12)
    line.end()
    assert said(capsys) == [f"1 of 1: photo.jpg, {done} of 12 steps" for done in (4, 8, 12)]
