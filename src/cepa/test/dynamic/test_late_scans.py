"""What moves, when odometry comes 150 ms late and the UAV yaws and leans."""

from __future__ import annotations

import math

import numpy as np
import pytest
from planar_flight import Lidar, Scene

from cepa import CepaParameters
from cepa.dynamic.dynamic import Dynamic
from cepa.dynamic.free_space.free_ranges import BeamEnds
from cepa.dynamic.obstacle_tracks.late_scans import LateScans
from cepa.dynamic.obstacle_tracks.moving_obstacles import MovingObstacles
from cepa.dynamic.obstacle_tracks.tracker import ObstacleTracker
from cepa.motion import Motion
from cepa.scan import Beams, LaserScan2D

SCAN_S, LATE_S, SPEED_M_S = 0.025, 0.15, 2.0
BEAMS, INCREMENT_RAD, RANGE_MAX_M = 540, math.radians(0.5), 10.0
FIRST_RAD = -0.25 * BEAMS * math.radians(1.0)
TRUNKS = np.array([(3.0, 4.0, 0.2), (6.0, -5.0, 0.3), (8.0, 3.5, 0.25), (2.0, -4.0, 0.2), (9.5, -1.5, 0.3)])
START, VELOCITY, RADIUS_M = np.array([8.0, -3.0]), np.array([-0.9, 1.2]), 0.3
PARAMETERS = CepaParameters()


def yaw_at(t):
    return 0.5 * math.sin(3.0 * t)


def motion_at(t, age_s=0.0):
    """Return what odometry of ``age_s`` ago tells at a scan: the UAV yaws, and leans by up to 14 degrees."""
    then = t - age_s
    yaw, pitch = 0.5 * yaw_at(then), 0.125 * math.sin(5.0 * then)
    c, s, c_pitch, s_pitch = math.cos(yaw), math.sin(yaw), math.cos(pitch), math.sin(pitch)
    orientation = (-s * s_pitch, c * s_pitch, s * c_pitch, c * c_pitch)
    return Motion(t, (SPEED_M_S * then, 0.0, 2.0), orientation, (SPEED_M_S, 0.0, 0.0), age_s=age_s)


def beams_at(t, rng, moves):
    circles = [*TRUNKS, (*(START + VELOCITY * t), RADIUS_M)] if moves else TRUNKS
    angles = FIRST_RAD + np.arange(BEAMS) * INCREMENT_RAD
    level = np.stack([np.cos(angles), np.sin(angles), np.zeros(BEAMS)], axis=1)
    along = (level @ motion_at(t).rotation().T)[:, :2]
    share = np.hypot(*along.T)  # of a beam's length in the plane
    ranges = Scene(circles=np.array(circles)).ranges(np.array([SPEED_M_S * t, 0.0]), along / share[:, None])
    ranges = ranges / share + rng.normal(0.0, Lidar.sigma, BEAMS)
    return Beams(ranges, np.ones(BEAMS, bool), FIRST_RAD, INCREMENT_RAD, ranges.min())


def watch(seconds, moves, age_of=lambda t: LATE_S, takes_as_fresh=False, arrives=lambda k: True):
    """Yield (t, what moves) of each scan; ``takes_as_fresh``: nobody tells that odometry is late."""
    rng = np.random.default_rng(1)
    obstacles = MovingObstacles(PARAMETERS)
    for k in range(round(seconds / SCAN_S)):
        t = k * SCAN_S
        beams = beams_at(t, rng, moves)
        if not arrives(k):
            continue
        told = motion_at(t, age_of(t))
        turn_rad = obstacles.tell(told)
        here = told.moved(np.array([SPEED_M_S * told.age_s, 0.0, 0.0]), turn_rad)
        age_s = told.age_s
        if takes_as_fresh:
            here, age_s = told.moved(np.array([SPEED_M_S * told.age_s, 0.0, 0.0])), 0.0
        yield t, obstacles.take_in(beams, here, age_s, RANGE_MAX_M)


def test_nothing_moves_where_all_stands():
    assert all(len(segmented.movers) == 0 for _, segmented in watch(3.0, moves=False))
    # With the same odometry taken as fresh, trunks seem to move
    assert any(len(segmented.movers) for _, segmented in watch(3.0, moves=False, takes_as_fresh=True))


@pytest.mark.parametrize("arrives", [lambda k: True, lambda k: k % 5 != 2], ids=["all", "some_are_lost"])
def test_what_moves_is_where_it_will_be_when_an_answer_shows_its_effect(arrives):
    ahead_s = PARAMETERS.response.delay_s
    for t, segmented in watch(2.3, moves=True, arrives=arrives):
        if t < 0.8:
            continue
        ((x, y, vx, vy, radius, _),) = segmented.movers
        place = START + VELOCITY * (t + ahead_s) - (SPEED_M_S * t, 0.0)
        assert (x, y) == pytest.approx(place, abs=0.25)
        assert (vx, vy) == pytest.approx(VELOCITY, abs=0.4)
        assert np.hypot(x - place[0], y - place[1]) + RADIUS_M < radius + 0.1
        # Its points in the newest scan are told from the trunks
        apart_m = np.hypot(*(segmented.points[:, :2] - START - VELOCITY * t + (SPEED_M_S * t, 0.0)).T)
        assert segmented.is_moving[apart_m < RADIUS_M + 0.1].all()
        assert not segmented.is_moving[apart_m > 1.5].any()


def test_the_response_is_not_worked_out_again_at_each_scan(monkeypatch):
    asked, response = [], CepaParameters.response.fget
    monkeypatch.setattr(CepaParameters, "response", property(lambda p: asked.append(p) or response(p)))
    assert sum(len(segmented.movers) for _, segmented in watch(1.2, moves=True)) > 5
    assert len(asked) == 1


@pytest.mark.table("age_s", [0.0, 0.02])
def test_odometry_in_time_changes_nothing(age_s):
    tracker, beam_ends = ObstacleTracker(), BeamEnds()
    rng = np.random.default_rng(1)
    for t, segmented in watch(1.5, moves=True, age_of=lambda t: age_s):
        motion = motion_at(t, age_s).moved(np.array([SPEED_M_S * age_s, 0.0, 0.0]))
        points, free = beam_ends.of(beams_at(t, rng, True), motion, RANGE_MAX_M)
        here = np.array(motion.position_m[:2])
        is_level = tracker.clear_of_floor(
            points, PARAMETERS.floor_height - 2.0, PARAMETERS.ceiling_height - 2.0
        )
        expected = tracker.update(t, points, here, free, is_level)
        assert np.array_equal(segmented.points, points)
        assert np.array_equal(segmented.is_moving, expected.is_moving)
        if len(expected.positions):
            assert np.array_equal(segmented.movers[:, 2:4], expected.velocities)


def test_what_moves_goes_on_for_a_second_when_odometry_stops():
    stops_s = 1.5
    for t, segmented in watch(3.0, moves=True, age_of=lambda t: LATE_S + max(0.0, t - stops_s)):
        if stops_s < t < stops_s - LATE_S + 0.9:
            ((x, y, *_, radius, _),) = segmented.movers
            place = START + VELOCITY * (t + PARAMETERS.response.delay_s) - (SPEED_M_S * t, 0.0)
            assert np.hypot(x - place[0], y - place[1]) < radius
        elif t > stops_s - LATE_S + 1.1:
            assert len(segmented.movers) == 0
            assert not segmented.is_moving.any()


def test_a_pose_is_interpolated_to_the_scans_own_time():
    late, told = LateScans(), [motion_at(t, LATE_S) for t in (0.15, 0.25, 0.35)]
    beams = Beams(np.ones(4), np.ones(4, bool), 0.0, 0.5 * math.pi, 1.0)
    late.tell(told[0])
    for stamp_s in (0.0, 0.04, 0.13):
        late.hold(beams, stamp_s)
    late.tell(told[1])
    (ready,) = late.ready()[-1:]
    assert ready[1].stamp_s == 0.04
    assert ready[1].age_s == 0.0
    assert ready[1].position_m == pytest.approx((SPEED_M_S * 0.04, 0.0, 2.0))
    assert ready[1].yaw_rad == pytest.approx(yaw_at(0.04), abs=0.002)
    late.tell(told[2])
    assert [motion.stamp_s for _, motion in late.ready()] == [0.13]


def test_a_scan_between_poses_far_apart_is_dropped():
    late = LateScans()
    beams = Beams(np.ones(4), np.ones(4, bool), 0.0, 0.5 * math.pi, 1.0)
    late.tell(motion_at(0.15, LATE_S))
    late.hold(beams, 0.15)
    late.tell(motion_at(0.15 + 0.4, LATE_S))
    assert late.ready() == []


def test_a_uav_turns_on_as_it_turned():
    late = LateScans()
    for t in np.arange(0.2, 0.4, SCAN_S):
        turn_rad = late.tell(motion_at(t, LATE_S))
    greatest_change = 4.5 * (0.5 * LATE_S**2 + 0.5 * LATE_S * 3 * SCAN_S)  # at 4.5 rad/s2
    assert turn_rad == pytest.approx(yaw_at(t) - yaw_at(t - LATE_S), abs=greatest_change)
    moved = motion_at(t, LATE_S).moved(np.zeros(3), turn_rad)
    assert moved.yaw_rad == pytest.approx(yaw_at(t - LATE_S) + turn_rad)
    assert late.tell(motion_at(0.4, 0.02)) == 0.0


def test_a_clock_that_goes_back_is_no_harm():
    dynamic = Dynamic(PARAMETERS)
    scan = LaserScan2D(np.full(BEAMS, np.inf), FIRST_RAD, INCREMENT_RAD, 0.1, RANGE_MAX_M)
    for stamp_s in (5.0, 5.025, 5.2, 5.225, 1.0, 1.025, 1.2, 1.225):
        decision = dynamic.steer(scan, (1.0, 0.0), (1.0, 0.0), motion_at(stamp_s, LATE_S))
        assert decision.velocity_xy[0] >= 0.0
    assert dynamic.report().movers in (None, 0)
