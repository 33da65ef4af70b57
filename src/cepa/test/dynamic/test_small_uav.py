"""Small things that fly above or below the level beams of a lidar with several channels are tracked."""

import math

import numpy as np
import pytest
from spatial_flight import HEIGHT_M, PERIOD_S, Boxes, fly_along_x, motion_at

from cepa import Cloud, Dynamic, Motion
from cepa.dynamic.free_space.slab import Slab
from cepa.parameters import CepaParameters
from cepa.scan import Beams

HALF_M, HALF_HEIGHT_M = 0.2, 0.1
NOTHING = np.empty((0, 2, 3))


class SmallUav(Boxes):
    """0.4 m wide and 0.2 m high; it meets a UAV that is at x = 6 m after 6.6 s, or overtakes it there."""

    def __init__(self, velocity, above_m):
        super().__init__(np.empty((0, 2, 3)))
        self._velocity, self._above_m = np.array(velocity), above_m

    def at(self, t_s, position):
        middle = np.array([6.0, 0.0, HEIGHT_M + self._above_m])
        middle[:2] += self._velocity * (t_s - 6.6)
        half = np.array([HALF_M, HALF_M, HALF_HEIGHT_M])
        return Boxes(np.array([[middle - half, middle + half]]))


@pytest.mark.parametrize(
    "above_m", [-0.15, pytest.param(-0.3, marks=pytest.mark.long), pytest.param(0.2, marks=pytest.mark.long)]
)
@pytest.mark.table("velocity", [(-3.0, 0.0), (3.0, 0.0), (0.0, 2.0), (1.5, -1.5)])
def test_a_small_uav_above_or_below_the_level_beams_is_evaded_from_each_quarter(velocity, above_m):
    flight = fly_along_x(Dynamic(), SmallUav(velocity, above_m), 2.0, 12.0, 12.0)
    assert min(flight.clearances_m) > 0.0


def test_the_slab_holds_the_nearest_point_of_each_direction_without_floor_and_ceiling():
    # Given a UAV at 1 m over the floor, under a ceiling at 2 m
    parameters = CepaParameters(ceiling_height=2.0)
    rows = [(3.0, 0.0, 0.3), (4.0, 0.0, 0.0), (0.0, 5.0, -0.5), (0.0, -5.0, -0.8), (-4.0, 0.0, 0.8)]
    cloud = Cloud(np.array(rows), (-0.3, 0.3), 0.5, 100.0)
    motion = Motion(0.0, (0.0, 0.0, 1.0), (0.0, 0.0, 0.0, 1.0), (0.0, 0.0, 0.0))
    nothing = Beams(np.full(4, math.inf), np.ones(4, bool), -math.pi, 0.5 * math.pi, math.inf)
    beams = Slab(parameters).beams(cloud, nothing, motion)
    # Then two directions are met
    assert beams.nearest == pytest.approx(3.0)
    met = np.isfinite(beams.ranges)
    np.testing.assert_allclose(np.sort(beams.ranges[met]), (3.0, 5.0))
    angles = np.sort(np.remainder(beams.angles[met], 2.0 * math.pi))
    np.testing.assert_allclose(angles, (0.0, 0.5 * math.pi), atol=2.0 * beams.increment)


@pytest.mark.table(
    ("stands", "person_m", "sees_m"),
    [(True, 4.0, 4.0), (False, 4.0, 2.0), (True, 2.2, 2.0), (True, None, 2.0)],
)
def test_a_sill_that_stands_does_not_hide_what_is_behind_it_at_the_bodys_heights(stands, person_m, sees_m):
    # Given a sill below the body, and perhaps a person behind it, in the same direction
    rows = [(2.0, 0.01, -0.45)] + ([] if person_m is None else [(person_m, 0.01, 0.0)])
    cloud = Cloud(np.array(rows), (-0.3, 0.3), 0.5, 100.0)
    motion = Motion(0.0, (0.0, 0.0, 2.0), (0.0, 0.0, 0.0, 1.0), (0.0, 0.0, 0.0))
    nothing = Beams(np.full(4, math.inf), np.ones(4, bool), -math.pi, 0.5 * math.pi, math.inf)
    # When the memory tells whether the sill has stood
    asked = []

    def have_stood(points):
        asked.append(points)
        return np.full(len(points), stands)

    beams = Slab(CepaParameters()).beams(cloud, nothing, motion, have_stood)
    # Then only one that stands is looked past
    assert beams.nearest == pytest.approx(sees_m, abs=1e-3)
    for points in asked:
        np.testing.assert_allclose(points, [(2.0, 0.01, 0.0)], atol=0.02)


@pytest.mark.table(("column_deg", "is_whole"), [(1.0, True), (2.0, True), (5.0, False)])
def test_between_the_columns_of_a_cloud_a_scan_does_not_look_past_a_thing(column_deg, is_whole):
    # Given a thing 2 m ahead, below the scan's plane and 20 degrees wide, and a scan of a wall 7 m away
    azimuths = np.radians(np.arange(-10.0, 10.1, column_deg))
    rows = np.column_stack((2.0 * np.cos(azimuths), 2.0 * np.sin(azimuths), np.full(len(azimuths), -0.3)))
    cloud = Cloud(rows, (-0.3, 0.3), 0.5, 100.0)
    motion = Motion(0.0, (0.0, 0.0, 2.0), (0.0, 0.0, 0.0, 1.0), (0.0, 0.0, 0.0))
    wall = Beams(
        np.full(720, 7.0), np.ones(720, bool), math.radians(0.25) - math.pi, math.radians(0.5), 7.0
    )  # none is on the border of a bin
    beams = Slab(CepaParameters()).beams(cloud, wall, motion)
    # Then the thing is whole, if its columns are not too far apart, and no wider than it is
    angles_deg = np.degrees(np.remainder(beams.angles + math.pi, 2.0 * math.pi) - math.pi)
    assert (beams.ranges[np.abs(angles_deg) < 9.5] < 3.0).all() == is_whole
    np.testing.assert_allclose(beams.ranges[np.abs(angles_deg) > 10.8], 7.0, atol=1e-3)


AZIMUTHS_RAD = np.radians(np.arange(-29.9, 30.0, 0.6))


class BehindASill(Boxes):
    """A room with a low wall across the way, 3 m ahead; a person comes from 7 m behind that at 1 m/s."""

    def __init__(self, corners=NOTHING):
        super().__init__(corners)

    def cloud(self, position):
        """Return what a QT64 sees ahead, 0.6 degrees from beam to beam; none is on the border of a bin."""
        up, azimuth = (axis.ravel() for axis in np.meshgrid(np.radians(np.arange(-40, 53)), AZIMUTHS_RAD))
        beams = np.column_stack((np.cos(up) * np.cos(azimuth), np.cos(up) * np.sin(azimuth), np.sin(up)))
        ranges = self.ranges(position, beams)
        met = ranges < 20.0
        return Cloud(beams[met] * ranges[met, None], (-0.7, 0.92), 0.05, 20.0)

    def at(self, t_s, position):
        wall = np.array([(3.0, -3.0, 0.0), (3.1, 3.0, 1.55)])
        x = 10.0 - t_s
        person = np.array([(x - 0.25, -0.25, 0.0), (x + 0.25, 0.25, 4.0)])
        end = np.array([(12.0, -9.0, 0.0), (12.1, 9.0, 4.0)])
        return BehindASill(np.array([wall, person, end]))


def test_who_comes_towards_a_sill_is_known_before_the_uav_is_over_it():
    # Given a UAV that hovers before the sill
    steering, boxes, position = Dynamic(), BehindASill(), np.array([0.0, 0.0, HEIGHT_M])
    for number in range(40):
        motion = motion_at(number * PERIOD_S, position)
        scan, cloud = boxes.at(number * PERIOD_S, position).senses(position)
        steering.steer(scan, (0.5, 0.0), (0.0, 0.0), motion, cloud)
    # Then it knows where the person is, and how fast
    movers = steering.view().movers
    assert len(movers) > 0
    for mover in movers:
        assert mover[:2] == pytest.approx((6.0, 0.0), abs=0.4)
        assert mover[2:4] == pytest.approx((-1.0, 0.0), abs=0.3)
