"""The meter of background lines: what it joins, how it measures a turn, and what an eye sees."""

import dataclasses

import numpy as np
import pytest

from kogao_core.background.find import MeasuredLines
from kogao_core.background.lines import SEEN_LENGTH, joined, long_enough, turns
from kogao_core.field.field import Field
from kogao_core.paper.lattice import Grid, Lattice

WIDTH, HEIGHT, FACE_PX = 800, 600, 200.0
LEFT, RIGHT = ((40.0, 300.0), (300.0, 300.0)), ((500.0, 300.0), (760.0, 300.0))
LEDGE = np.array([LEFT, RIGHT])
PLAIN = np.zeros((HEIGHT, WIDTH, 3), np.uint8)


def field_of(displaced):
    """A field with the displacement that `displaced` returns at places (..., 2), if smooth."""
    grid = Grid((-80.0, -80.0), 20.0)
    nodes = np.stack(np.meshgrid(np.arange(-80.0, 900.0, 20.0), np.arange(-80.0, 700.0, 20.0)), -1)
    return Field((Lattice(grid, (0, 0), displaced(nodes)),))


def turned_field(degrees):
    """A field that turns the picture clockwise about the middle of the photo."""
    angle = np.radians(-degrees)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    middle = np.array([400.0, 300.0])
    return field_of(lambda nodes: (nodes - middle) @ (turn - np.eye(2)).T)


def roof_field(slope):
    """A field that lifts every place by a share of its nearness to the middle."""

    def lifted(nodes):
        near = 400.0 - np.abs(nodes[..., 0] - 400.0)
        return np.stack([np.zeros_like(near), slope * near], axis=-1)

    return field_of(lifted)


def test_pieces_on_one_line_are_joined_across_a_person_and_others_are_not():
    lean = ((500.0, 300.0), (760.0, 316.0))
    below = ((500.0, 306.0), (760.0, 306.0))
    numbers = joined(np.array([LEFT, RIGHT, lean, below]), aside_px=3.2)
    assert numbers[0] == numbers[1]
    assert len(set(numbers.tolist())) == 3
    nearly = ((500.0, 302.0), (760.0, 304.0))
    assert set(joined(np.array([LEFT, nearly]), aside_px=3.2).tolist()) == {0}


@pytest.mark.parametrize("degrees", [0.5, 3.0, 8.0])
def test_a_line_turns_by_the_angle_of_the_warp(degrees):
    found = turns(turned_field(degrees), LEDGE, PLAIN, FACE_PX)
    assert [one.turn_degrees for one in found] == pytest.approx([degrees, degrees], abs=0.01)


def test_a_shift_is_no_turn_and_no_rise():
    shift = field_of(lambda nodes: np.broadcast_to((4.0, 9.0), nodes.shape).copy())
    for one in turns(shift, LEDGE, PLAIN, FACE_PX):
        assert (one.turn_degrees, one.rise_permille) == pytest.approx((0.0, 0.0), abs=1e-6)


def test_two_halves_that_stay_straight_but_make_a_roof_turn_and_rise():
    """Each half is perfectly straight: a meter of bends sees nothing."""
    slope = 0.05
    left, right = turns(roof_field(slope), LEDGE, PLAIN, FACE_PX)
    assert left.number == right.number
    for one in (left, right):
        assert one.turn_degrees == pytest.approx(np.degrees(np.arctan(slope)), abs=0.05)
        # Ends lie 40 and 300 px from the photo's side.
        assert one.rise_permille == pytest.approx(1000.0 * slope * 260.0 / FACE_PX, rel=0.02)


def test_a_step_between_halves_that_shift_is_a_rise_without_a_turn():
    step = field_of(lambda nodes: np.stack([0 * nodes[..., 0], 6.0 * (nodes[..., 0] > 400.0)], -1))
    for one in turns(step, LEDGE, PLAIN, FACE_PX):
        assert one.turn_degrees < 0.01
        assert one.rise_permille == pytest.approx(30.0, rel=0.01)


def test_a_bow_turns_at_its_ends_where_the_whole_line_does_not():
    def bowed(nodes):
        return np.stack([0 * nodes[..., 0], 24.0 * ((nodes[..., 0] - 400.0) / 360.0) ** 2], axis=-1)

    (one,) = turns(field_of(bowed), np.array([[LEFT[0], RIGHT[1]]]), PLAIN, FACE_PX)
    # The slope of a chord of 64 px at the end of a parabola.
    assert one.turn_degrees == pytest.approx(np.degrees(48.0 / 360.0 * 328.0 / 360.0), rel=0.05)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
def test_an_edge_is_clear_and_a_line_in_texture_is_not(dtype):
    rng = np.random.default_rng(3)
    photo = rng.uniform(0.2, 0.4, (HEIGHT, WIDTH, 3))
    photo[300:, 500:] += 0.4
    most = 1 if dtype == np.float32 else np.iinfo(dtype).max
    still = turned_field(0.0)
    found = turns(still, LEDGE, (most * photo).astype(dtype), FACE_PX)
    by_start = {one.start_px[0]: one.clearness for one in found}
    assert by_start[500.0] > 0.9
    assert by_start[40.0] < 0.5


def test_short_lines_are_not_measured():
    short = ((100.0, 100.0), (100.0 + 0.079 * WIDTH, 100.0))
    assert len(long_enough(np.array([short, LEFT]), PLAIN)) == 1
    assert long_enough(np.zeros((0, 2, 2)), PLAIN).shape == (0, 2, 2)
    assert turns(turned_field(1.0), np.zeros((0, 2, 2)), PLAIN, FACE_PX) == []


@pytest.mark.parametrize(
    ("length", "clearness", "holding", "seen"),
    [
        (1.1 * SEEN_LENGTH, 1.0, "gave way", True),
        (0.9 * SEEN_LENGTH, 1.0, "gave way", False),
        (1.8 * SEEN_LENGTH, 0.5, "gave way", False),
        (0.5, 1.0, "held", False),
        (0.5, 1.0, "let go", False),
    ],
)
def test_an_eye_sees_turned_lines_that_are_long_and_clear(length, clearness, holding, seen):
    one = turns(turned_field(4.0), LEDGE[:1], PLAIN, FACE_PX)[0]
    share = length / np.sqrt(2.0)
    one = dataclasses.replace(one, length=share, clearness=clearness, holding=holding)
    assert bool(MeasuredLines((one, one)).seen) is seen
