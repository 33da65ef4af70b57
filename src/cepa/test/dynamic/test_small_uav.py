"""Small things that fly above or below the level beams of a lidar with several channels are tracked."""

import math

import numpy as np
import pytest
from spatial_flight import HEIGHT_M, Boxes, fly_along_x

from cepa import Cloud, Dynamic, Motion
from cepa.dynamic.free_space.slab import Slab
from cepa.parameters import CepaParameters
from cepa.scan import Beams

HALF_M, HALF_HEIGHT_M = 0.2, 0.1


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


@pytest.mark.parametrize("above_m", [-0.3, -0.15, 0.2])
@pytest.mark.parametrize("velocity", [(-3.0, 0.0), (3.0, 0.0), (0.0, 2.0), (1.5, -1.5)])
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
