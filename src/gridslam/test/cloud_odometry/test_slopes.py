"""The height over a floor that slopes: the range finder alone takes a ramp for a climb or a descent."""

import itertools
import math

import numpy as np
import pytest
from puck_in_a_corridor import Corridor
from puck_in_a_room import errors, fly

from gridslam.cloud_odometry import CloudOdometry, CloudOdometryParameters
from gridslam.cloud_odometry.plane_map import PlaneMap
from gridslam.cloud_odometry.rotations import matrix_of

BACK_AT_THE_START_S = 34.0
DEAR = pytest.mark.long


@pytest.mark.parametrize("slope_deg", [8.0, *(pytest.param(deg, marks=DEAR) for deg in (4.0, 20.0))])
def test_the_height_holds_up_a_ramp_and_down_again(slope_deg):
    corridor = Corridor(math.radians(slope_deg))
    odometry, rng = CloudOdometry(), np.random.default_rng(1)
    flown = fly(odometry, BACK_AT_THE_START_S, rng, at=corridor.place_at, seen_m=corridor.ranges_m)
    assert max(place[0] for _, _, place in flown) > 17.0
    off_m = np.abs(errors(flown)[:, 2])
    assert off_m.max() < 0.1
    assert off_m[-20:].max() < 0.05
    assert odometry.height.wrong_m == 0.0


@pytest.mark.parametrize("pitch_rad", [0.008, pytest.param(-0.008, marks=DEAR)])
def test_a_long_level_floor_is_no_slope_and_no_step_whatever_the_imu_and_the_map_drift_by(pitch_rad):
    """A bias of the accelerometer leans the map by degrees: over 60 m it rises or sinks by 0.5 m."""
    corridor = Corridor(0.0, length_m=66.0)
    flown = fly(
        CloudOdometry(),
        corridor.back_s,
        np.random.default_rng(1),
        at=corridor.place_at,
        seen_m=corridor.ranges_m,
        pitch_told=lambda time_s: pitch_rad * min(max((time_s - 6.0) / 20.0, 0.0), 1.0),
    )
    assert max(place[0] for _, _, place in flown) > 59.0
    assert np.abs(errors(flown)[:, 2]).max() < 0.05


@pytest.mark.long
@pytest.mark.table("slope_deg", [8.0, 20.0])
def test_behind_a_ramp_the_height_is_told_as_uncertain_as_it_is_until_the_floor_of_before_is_back(slope_deg):
    corridor, sigmas_m, off_m = Corridor(math.radians(slope_deg)), [], []
    for seed in range(3):
        rng = np.random.default_rng(seed)
        flown = fly(CloudOdometry(), BACK_AT_THE_START_S, rng, at=corridor.place_at, seen_m=corridor.ranges_m)
        sigmas_m.append([estimate.height_uncertain_m for _, estimate, _ in flown])
        off_m.append(np.abs(errors(flown)[:, 2]))
    on_top = int(10 * corridor.back_s)
    assert (np.array(off_m)[:, 20:] < 3.0 * np.array(sigmas_m)[:, 20:]).mean() > 0.99
    assert min(each[on_top] for each in sigmas_m) > 0.05
    assert max(each[-1] for each in sigmas_m) < 0.03


@pytest.mark.table("slope_deg", [0.0, 8.0, 30.0])
def test_the_map_tells_the_slope_of_the_floor_where_a_place_lies_on_it(slope_deg):
    """A floor that rises along x + y by the tangent of the slope, seen from 3 m above."""
    planes, rise = PlaneMap(CloudOdometryParameters()), math.tan(math.radians(slope_deg))
    x, y = (each.ravel() for each in np.meshgrid(np.arange(0.0, 4.0, 0.1), np.arange(0.0, 4.0, 0.1)))
    planes.add(np.column_stack((x, y, rise * (x + y) / math.sqrt(2.0))), np.array((2.0, 2.0, 6.0)))
    on_it = np.array((1.3, 2.6, rise * 3.9 / math.sqrt(2.0)))
    eye = np.array((2.0, 2.0, 6.0))
    assert planes.slope_at(on_it, eye) == pytest.approx(np.full(2, rise / math.sqrt(2.0)), abs=0.01)
    assert planes.slope_at(on_it + np.array((0.0, 0.0, 0.5)), eye) is None
    assert planes.slope_at(on_it + np.array((20.0, 0.0, 0.0)), eye) is None


@pytest.mark.table("slope_deg", [8.0, 20.0])
def test_a_ramp_that_was_first_seen_from_below_its_top_is_a_floor(slope_deg):
    """It rises by 12 m times the tangent. The eye is lower than its upper end, but on its upper side."""
    planes, rise = PlaneMap(CloudOdometryParameters()), math.tan(math.radians(slope_deg))
    x, y = (each.ravel() for each in np.meshgrid(np.arange(0.0, 12.0, 0.1), np.arange(0.0, 2.0, 0.1)))
    planes.add(np.column_stack((x, y, rise * x)), np.array((-3.0, 1.0, 1.5)))
    upper = np.array((11.3, 1.3, rise * 11.3))
    up = np.array((0.0, 0.0, 1.5))
    assert planes.slope_at(upper, upper + up) == pytest.approx((rise, 0.0), abs=0.01)
    assert planes.slope_at(upper, upper - up) is None


def test_a_plane_through_single_rings_on_floor_and_wall_is_no_slope():
    """Two lines in a voxel of 1 m, on the floor and 0.3 m up the wall, are coplanar. Its halves are lines."""
    planes, y = PlaneMap(CloudOdometryParameters()), np.arange(0.02, 1.0, 0.02)
    rings = (0.2, 0.1), (0.8, 0.4)
    on_floor, on_wall = (np.column_stack((0 * y + at, y, 0 * y + up)) for at, up in rings)
    planes.add(np.vstack((on_floor, on_wall)), np.array((0.3, 0.5, 3.0)))
    assert planes.slope_at(np.array((0.4, 0.5, 0.2)), np.array((0.4, 0.5, 3.0))) is None


def deck_with_rim(turn_rad):
    """Points of a level deck from x = 0.01 on, at z = 8.2, and of the upper 0.1 m of its rim."""
    y, z = (each.ravel() for each in np.meshgrid(np.arange(-1.5, 1.5, 0.2), np.arange(8.1, 8.2, 0.03)))
    rim = np.column_stack((0.01 + 0.0 * y, y, z))
    x, y = (each.ravel() for each in np.meshgrid(np.arange(0.06, 1.5, 0.08), np.arange(-1.5, 1.5, 0.08)))
    deck = np.column_stack((x, y, 8.2 + 0.0 * x))
    return np.vstack((rim, deck)) @ matrix_of((0.0, 0.0, turn_rad)).T


@pytest.mark.table("turn_deg", [0.0, 90.0, 180.0, 270.0])
def test_the_rim_of_a_level_deck_is_no_slope(turn_deg):
    """A plane through deck and rim leans by some degrees. It goes on to neither side."""
    planes, turn = PlaneMap(CloudOdometryParameters()), matrix_of((0.0, 0.0, math.radians(turn_deg)))
    planes.add(deck_with_rim(math.radians(turn_deg)), turn @ (-0.3, 0.0, 10.0))
    for x, y, z in itertools.product(np.arange(0.01, 1.2, 0.06), np.arange(-1.0, 1.0, 0.2), (8.14, 8.2)):
        slope = planes.slope_at(turn @ (x, y, z), turn @ (x, y, z + 2.0))
        assert slope is None or np.linalg.norm(slope) < 0.05
