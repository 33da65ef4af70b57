"""The normal form of scans: REP-117, dropouts, what is unseen, order and coverage of the beams."""

import math

import numpy as np
import pytest

from cepa import LaserScan2D, ScanError
from cepa.scan import Grid

INF, NAN = math.inf, math.nan
TURN = 2.0 * math.pi


def scan(ranges, angle_min=0.0, beams_per_turn=8, seen=None, sign=1):
    return LaserScan2D(ranges, angle_min, sign * TURN / beams_per_turn, 0.1, 10.0, seen)


def test_ranges_mean_what_rep_117_says():
    beams = scan([1.0, INF, -INF, 10.0, 10.5, 0.1, 3.0, 4.0]).full_turn(dropout_beams=2)
    assert beams.ranges.tolist() == [1.0, INF, 0.1, 10.0, INF, 0.1, 3.0, 4.0]
    assert beams.seen.all()


@pytest.mark.table("near", [-INF, 0.05, 0.0999])
def test_what_is_too_close_is_at_range_min_or_nearer_if_so_told(near):
    too_close = scan([1.0, near, 3.0, 2.0, 3.0, 4.0, 5.0, 6.0])
    assert too_close.full_turn(dropout_beams=2).ranges[:3].tolist() == [1.0, 0.1, 3.0]
    assert too_close.full_turn(2, too_close_m=0.07).ranges[:3].tolist() == [1.0, 0.07, 3.0]
    assert too_close.full_turn(2, too_close_m=0.3).ranges[:3].tolist() == [1.0, 0.1, 3.0]


@pytest.mark.table("invalid", [NAN, 0.0, -3.0])
def test_a_dropout_takes_its_neighbours_smaller_range(invalid):
    beams = scan([1.0, invalid, invalid, 2.0, 3.0, 4.0, 5.0, 6.0]).full_turn(dropout_beams=2)
    assert beams.ranges.tolist() == [1.0, 1.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
    assert beams.seen.all()


def test_a_dropout_across_the_first_beam_is_one_gap():
    beams = scan([NAN, 2.0, 3.0, 3.0, 3.0, 3.0, 1.5, NAN]).full_turn(dropout_beams=2)
    assert beams.ranges.tolist() == [1.5, 2.0, 3.0, 3.0, 3.0, 3.0, 1.5, 1.5]
    assert scan([NAN, 2.0, 3.0, 3.0, 3.0, 3.0, 1.5, NAN]).full_turn(1).seen.tolist() == [
        False,
        *[True] * 6,
        False,
    ]


def test_a_wide_dropout_is_unseen():
    beams = scan([1.0, NAN, NAN, NAN, 3.0, 4.0, 5.0, 6.0]).full_turn(dropout_beams=2)
    assert beams.seen.tolist() == [True, False, False, False, True, True, True, True]
    assert np.isinf(beams.ranges[1:4]).all()


def test_a_dropout_beside_the_unseen_takes_its_one_neighbour():
    beams = scan([NAN, 2.0, 3.0]).full_turn(dropout_beams=2)
    assert beams.ranges.tolist() == [2.0, 2.0, 3.0] + [INF] * 5
    assert beams.seen.tolist() == [True] * 3 + [False] * 5


def test_nothing_but_dropouts_is_nothing_seen():
    beams = scan([NAN] * 8).full_turn(dropout_beams=8)
    assert not beams.seen.any()
    assert np.isinf(beams.ranges).all()


def test_marked_beams_are_unseen_whatever_they_hold():
    beams = scan([1.0, 0.3, NAN, 2.0, 3.0, 4.0, 5.0, 6.0], seen=[True, False, False] + [True] * 5).full_turn(
        4
    )
    assert beams.seen.tolist() == [True, False, False, True, True, True, True, True]
    assert np.isinf(beams.ranges[1:3]).all()


def test_padding_changes_nothing():
    bare = scan([1.0, 2.0, 3.0], angle_min=-1.0).full_turn(2)
    padded = scan([1.0, 2.0, 3.0] + [INF] * 5, angle_min=-1.0, seen=[True] * 3 + [False] * 5).full_turn(2)
    assert bare.ranges.tolist() == padded.ranges.tolist()
    assert bare.seen.tolist() == padded.seen.tolist()


def test_descending_beams_are_put_in_order():
    up = scan([1.0, 2.0, 3.0], angle_min=0.5).full_turn(2)
    down = scan([3.0, 2.0, 1.0], angle_min=0.5 + 2 * TURN / 8, sign=-1).full_turn(2)
    assert down.ranges.tolist() == up.ranges.tolist()
    assert down.angle_0 == pytest.approx(up.angle_0)
    assert down.increment == up.increment


def test_the_nearest_is_the_least_range_that_counts():
    assert scan([5.0, NAN, 4.0, INF, 8.0, 3.0, 0.0, 9.0]).full_turn(2).nearest == 3.0
    assert scan([5.0, 4.0, 3.0], seen=[True, True, False]).full_turn(2).nearest == 4.0
    assert scan([NAN] * 8).full_turn(8).nearest == INF


def test_a_beam_more_than_a_turn_is_folded_onto_the_first():
    beams = scan([3.0, 2.0, 3.0, 3.0, 3.0, 3.0, 3.0, 3.0, 1.0]).full_turn(2)
    assert beams.ranges.tolist() == [1.0, 2.0, 3.0, 3.0, 3.0, 3.0, 3.0, 3.0]
    beams = scan([NAN, 2.0, 3.0, 3.0, 3.0, 3.0, 3.0, 3.0, 1.0]).full_turn(0)
    assert beams.ranges[0] == 1.0


@pytest.mark.table(
    ("arguments", "sentence"),
    [
        (([], 0.0, 0.1, 0.1, 10.0), "holds no beams"),
        (([1.0], 0.0, 0.0, 0.1, 10.0), "angle_increment must be between"),
        (([1.0], 0.0, NAN, 0.1, 10.0), "angle_increment must be between"),
        (([1.0], NAN, 0.1, 0.1, 10.0), "angle_min must be finite"),
        (([1.0], 0.0, 0.1, 0.1, -10.0), "range limits must fulfil"),
        (([1.0], 0.0, 0.1, NAN, 10.0), "range limits must fulfil"),
        (([1.0] * 70, 0.0, 0.1, 0.1, 10.0), "more than a full turn"),
        (([1.0, 2.0], 0.0, 0.1, 0.1, 10.0, [True]), "2 ranges but 1 marks"),
        (([[1.0, 2.0]], 0.0, 0.1, 0.1, 10.0), "must be one row"),
        ((["near"], 0.0, 0.1, 0.1, 10.0), "must be numbers"),
        ((None, 0.0, 0.1, 0.1, 10.0), "must be one row"),
        (([1.0], None, 0.1, 0.1, 10.0), "angle_min must be a number, not None"),
        (([1.0], 0.0, "0.1", 0.1, 10.0), "angle_increment must be a number, not '0.1'"),
        (([1.0], 0.0, 0.1, "a", 10.0), "range_min must be a number, not 'a'"),
        (([1.0], 0.0, 0.1, 0.1, [10.0]), "range_max must be a number"),
    ],
)
def test_a_scan_that_makes_no_sense_is_refused_in_a_sentence(arguments, sentence):
    with pytest.raises(ScanError, match=sentence) as refusal:
        LaserScan2D(*arguments)
    assert "\n" not in str(refusal.value)


def test_the_grid_finds_the_nearest_beam_if_beams_do_not_divide_the_turn():
    grid = Grid(6, 1.0)  # beams at 0 .. 5 rad, and 1.28 rad between the last and the first
    assert [grid.index(angle) for angle in (0.4, 0.6, 4.9, 5.6, 5.7, -0.5, -0.7)] == [0, 1, 5, 5, 0, 0, 5]
    assert grid.offset_angles[5] == 0.0
    assert grid.offset_angles[0] == pytest.approx(TURN - 5.0)
