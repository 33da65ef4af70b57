"""What is seen only now and then counts, rain does not: on drawn scans, and in flights of a planar model."""

import math

import numpy as np
import pytest
from planar_flight import Scene, Uav, fly, forest, to_goal

from cepa import Dynamic, Motion, Reason
from cepa.dynamic.remembered.single_beams import SingleBeams
from cepa.scan import Beams, LaserScan2D

BEAMS = 1440
INCREMENT = 2.0 * math.pi / BEAMS
WALL_M, PERIOD_S = 5.0, 0.025


def confirmed(single_beams, ranges, stamp_s=0.0, position_m=(0.0, 0.0), yaw_rad=0.0, seen=None):
    seen = np.ones(BEAMS, bool) if seen is None else seen
    beams = Beams(np.array(ranges), seen, -math.pi, INCREMENT, float(np.min(ranges)))
    level = 0.0, 0.0, math.sin(0.5 * yaw_rad), math.cos(0.5 * yaw_rad)
    motion = Motion(stamp_s, (*position_m, 2.0), level, (0.0, 0.0, 0.0))
    return single_beams.confirmed(beams, motion, PERIOD_S)


def wall_with(beam=None, range_m=1.0, width=1):
    ranges = np.full(BEAMS, WALL_M)
    if beam is not None:
        ranges[np.arange(beam, beam + width) % BEAMS] = range_m
    return ranges


@pytest.mark.table("beam", [0, 700, BEAMS - 1])
def test_a_single_beam_is_put_back_until_earlier_scans_confirm_it(beam):
    single_beams = SingleBeams()
    found = [confirmed(single_beams, wall_with(beam)).ranges[beam] for _ in range(8)]
    assert found[0] == WALL_M
    assert found[-1] == 1.0
    assert sorted(found, reverse=True) == found


def test_the_nearest_range_is_that_of_the_beams_that_are_left():
    assert confirmed(SingleBeams(), wall_with(700)).nearest == WALL_M
    assert confirmed(SingleBeams(), wall_with(700, width=3)).nearest == 1.0


def test_what_is_three_beams_wide_counts_at_once():
    found = confirmed(SingleBeams(), wall_with(700, width=3)).ranges
    assert (found[700:703] == 1.0).all()


def test_a_near_beam_at_the_edge_of_something_is_no_beam_alone():
    ranges = wall_with()
    ranges[700:] = 2.0
    ranges[699] = 1.8
    assert np.array_equal(confirmed(SingleBeams(), ranges).ranges, ranges)


def test_beams_side_by_side_that_end_at_different_ranges_stand_out_each():
    ranges = wall_with()
    ranges[700:703] = 0.5, 3.0, 1.5
    assert (confirmed(SingleBeams(), ranges).ranges == WALL_M).all()


def test_a_wire_is_confirmed_by_its_place_while_the_uav_turns_and_moves():
    """A wire at (2, 0) that every other scan sees; the UAV flies at 2 m/s towards it and yaws by 1 rad/s."""
    single_beams, counts = SingleBeams(), []
    for scan in range(16):
        x_m, yaw_rad = 2.0 * PERIOD_S * scan, PERIOD_S * scan
        beam = round((math.pi - yaw_rad) / INCREMENT)
        ranges = wall_with(beam if scan % 2 else None, 2.0 - x_m)
        found = confirmed(single_beams, ranges, PERIOD_S * scan, (x_m, 0.0), yaw_rad).ranges
        counts.append(found[beam] < WALL_M)
    assert counts[-5::2] == [True] * 3


def test_hardly_a_beam_of_rain_is_left():
    """5 % of the beams are short. By chance two of them are near each other; in scans after scans hardly."""
    rng, single_beams, left, wet = np.random.default_rng(1), SingleBeams(), 0, 0
    for scan in range(200):
        ranges = wall_with()
        short = rng.random(BEAMS) < 0.05
        ranges[short] = rng.uniform(0.06, WALL_M, short.sum())
        found = confirmed(single_beams, ranges, PERIOD_S * scan).ranges
        wet += short.sum()
        left += (found < WALL_M - 0.3).sum()
    assert left < 0.02 * wet  # 1.2 %; most of it are two beams side by side, of one length


def test_a_beam_beside_what_nobody_sees_stays_if_both_sides_are_unseen():
    seen = np.ones(BEAMS, bool)
    seen[[699, 701]] = False
    ranges = wall_with(700)
    ranges[[699, 701]] = np.inf
    assert confirmed(SingleBeams(), ranges, seen=seen).ranges[700] == 1.0


# -- flights ------------------------------------------------------------------------------------------------


class Spoiled:
    """Steers as `Dynamic`, by scans that are spoiled."""

    def __init__(self, spoil):
        self.inner, self.spoil, self.scans = Dynamic(), spoil, 0

    def steer(self, scan, v_ref, v_uav, motion):
        ranges = self.spoil(self.scans, scan.ranges.copy())
        self.scans += 1
        geometry = scan.angle_min, scan.angle_increment, scan.range_min, scan.range_max
        return self.inner.steer(LaserScan2D(ranges, *geometry), v_ref, v_uav, motion)


def test_it_does_not_fly_to_an_obstacle_out_of_view_for_half_a_second():
    """A trunk 2 m ahead is seen for half a second. Then 55 degrees ahead of the UAV nothing returns."""
    steering, trunk = Dynamic(), Scene(circles=np.array([(2.0, 0.0, 0.25)]))
    angles = -math.pi + INCREMENT * np.arange(BEAMS)
    seen = trunk.ranges(np.zeros(2), np.stack((np.cos(angles), np.sin(angles)), axis=1))
    lost = np.where(np.abs(angles) < math.radians(27.5), np.inf, seen)
    for scan in range(40):
        ranges = LaserScan2D(seen if scan < 20 else lost, -math.pi, INCREMENT, 0.06, 10.0)
        motion = Motion(PERIOD_S * scan, (0.0, 0.0, 2.0), (0.0, 0.0, 0.0, 1.0), (0.0, 0.0, 0.0))
        answer = steering.steer(ranges, (2.0, 0.0), (0.0, 0.0), motion)
        assert answer.reason is Reason.STEERED
        assert abs(answer.velocity_xy[1]) > 0.1


def test_rain_in_a_forest_starts_hardly_an_emergency():
    rng = np.random.default_rng(2)

    def rain(_scan, ranges):
        short = rng.random(len(ranges)) < 0.02
        ranges[short] = rng.uniform(0.06, np.clip(ranges[short], 0.06, 10.0))
        return ranges

    flight = fly(Spoiled(rain), forest(rng, 14.0), to_goal((14.0, 0.0)), Uav(), rng, time_limit_s=20.0)
    assert flight.reached
    assert sum(decision.emergency for decision in flight.decisions) <= 4
