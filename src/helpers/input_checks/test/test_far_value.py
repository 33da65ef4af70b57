"""What lidars tell where they meet nothing: in a hall larger than they see, and in rooms that are not."""

import math

import numpy as np
import pytest

from input_checks.far_value import FarValues

BEAMS = 720
ANGLES = math.tau / BEAMS * (np.arange(BEAMS) + 0.25)
RNG = np.random.default_rng(1)


def box_ranges(x, y, half=(20.0, 10.0)):
    """Ranges (n,) from a place in a box about the origin to its walls."""
    along = (np.sign(np.cos(ANGLES)) * half[0] - x) / np.cos(ANGLES)
    across = (np.sign(np.sin(ANGLES)) * half[1] - y) / np.sin(ANGLES)
    return np.minimum(along, across)


def way(scans=40):
    """Scans of a lidar that flies along a wall of the hall, float32, with noise."""
    return [
        (box_ranges(-8.0 + 0.1 * k, 6.0) + RNG.normal(0.0, 0.01, BEAMS)).astype(np.float32)
        for k in range(scans)
    ]


class Lidar:
    def __init__(self, limits=(0.1, 8.0)):
        self.said = []
        self.far, self.limits = FarValues(self.said.append), limits
        self.stamp_s = 100.0

    def nothing(self, ranges):
        """The beams (n,) that met nothing."""
        self.stamp_s += 0.1
        found = self.far.nothing_in("laser", self.stamp_s, ranges, self.limits)
        return np.zeros(len(ranges), bool) if found is None else found[0]


@pytest.mark.table(
    ("fill", "range_max", "from_scan"),
    [
        (8.0, 8.0, 0),
        (8.1, np.float32(8.1), 0),
        (7.99, 8.0, 0),
        (8.0, 8.1, 0),
        (81.83, 81.91, 0),
        (8.0, 100.0, 10),
        (8.0, math.inf, 10),
    ],
)
def test_what_a_driver_tells_for_nothing_is_nothing(fill, range_max, from_scan):
    lidar, reach = Lidar((0.1, range_max)), min(fill, 8.0) - 0.05
    for number, ranges in enumerate(way()):
        beyond = ranges > reach
        told = np.where(beyond, np.float32(fill), ranges)
        found = lidar.nothing(told)
        if number >= from_scan:
            np.testing.assert_array_equal(found, beyond)
        else:
            assert not found.any() or (found == beyond).all()
    assert len(lidar.said) == 1
    assert f"{fill:g} m" in lidar.said[0]


def test_a_scan_close_to_a_wall_does_not_change_what_the_value_means():
    lidar = Lidar()
    for ranges in way(5):
        lidar.nothing(np.where(ranges > 8.0, np.float32(8.0), ranges))
    assert not lidar.nothing(box_ranges(0.0, 0.0, (1.0, 1.0))).any()
    few = np.where(ANGLES < 0.02, 8.0, 1.0)
    np.testing.assert_array_equal(lidar.nothing(few), few == 8.0)
    assert len(lidar.said) == 1


def test_a_few_beams_along_a_corridor_are_seen_in_the_end():
    lidar = Lidar((0.1, 30.0))
    for number in range(20):
        ranges = box_ranges(0.0, 0.01 * number, (500.0, 1.0))
        beyond = ranges > 30.0
        assert 4 <= beyond.sum() < 20
        found = lidar.nothing(np.where(beyond, 30.0, ranges))
    np.testing.assert_array_equal(found, beyond)


@pytest.mark.table("step", [0.0, 0.01])
@pytest.mark.table("range_max", [8.0, math.inf])
def test_walls_stay_walls(step, range_max):
    """Rooms at rest and in flight, with and without noise, told exactly or in whole centimetres."""
    rooms = [
        lambda k: box_ranges(0.0, 0.0, (4.0, 3.0)),
        lambda k: box_ranges(0.01 * k, 0.0, (4.0, 3.0)),
        lambda k: box_ranges(0.0, 0.0, (4.0, 3.0)) + RNG.normal(0.0, 0.01, BEAMS),
        lambda k: np.full(BEAMS, 5.0),  # the middle of a round tank
        lambda k: np.full(BEAMS, 5.0) + RNG.normal(0.0, 0.01, BEAMS),
        lambda k: np.where(np.abs(ANGLES - 2.0) < 0.2, 2.0, 5.0),  # the same with a post
        lambda k: np.where(np.abs(ANGLES - 2.0) < 0.2, 5.0 / np.cos(ANGLES - 2.0), 1.0),  # through a door
    ]
    for room in rooms:
        lidar = Lidar((0.1, range_max))
        for number in range(100):
            ranges = room(number)
            told = np.round(ranges / step) * step if step else ranges
            assert not lidar.nothing(told.astype(np.float32)).any()
        assert lidar.said == []


def test_a_lidar_that_tells_inf_has_no_other_word_for_nothing():
    """A round wall at range_max, noise-free, with a way out."""
    lidar = Lidar()
    for _ in range(30):
        assert not lidar.nothing(np.where(ANGLES < 1.0, np.inf, 8.0)).any()
    assert lidar.said == []


def test_a_range_that_is_exceeded_later_is_real_again():
    lidar = Lidar((0.1, 8.1))
    for ranges in way(5):
        lidar.nothing(np.where(ranges > 8.0, np.float32(8.0), ranges))
    for _ in range(10):
        found = lidar.nothing(np.linspace(7.9, 8.05, BEAMS))
    assert not found.any()
    assert len(lidar.said) == 2


def test_one_stray_reading_changes_nothing():
    for stray_at in (0, 3):
        lidar = Lidar((0.1, 8.1))
        for number, ranges in enumerate(way(5)):
            told = np.where(ranges > 8.0, np.float32(8.0), ranges)
            if number == stray_at:
                told[0] = 8.05
            found = lidar.nothing(told)
        np.testing.assert_array_equal(found, told == 8.0)


def test_covered_by_something_is_not_nothing():
    """Some lidars tell an error's number, below range_min, in each beam."""
    lidar = Lidar((0.1, 8.0))
    for number in range(30):
        assert not lidar.nothing(np.where(np.arange(BEAMS) % 2, 0.019, 0.001 * (number % 7))).any()


def test_another_clock_or_another_range_max_begins_anew():
    lidar = Lidar((0.1, 8.0))
    for ranges in way(5):
        lidar.nothing(np.where(ranges > 8.0, np.float32(8.0), ranges))
    lidar.stamp_s = 10.0
    assert not lidar.nothing(np.where(ANGLES < 0.05, 8.0, 1.0)).any()
    assert lidar.nothing(np.where(ANGLES < 0.5, 8.0, 1.0)).any()
    lidar.limits = (0.1, 30.0)
    assert not lidar.nothing(np.where(ANGLES < 0.5, 8.0, 1.0)).any()


def test_scans_without_any_reading_are_taken():
    lidar = Lidar()
    for ranges in ([], [math.nan] * 5, [math.inf] * 5, [-math.inf] * 5, [0.0] * 5):
        assert not lidar.nothing(np.array(ranges, np.float32)).any()
