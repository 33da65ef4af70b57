"""Who walks up slowly to a UAV that hovers."""

import math

import numpy as np
import pytest
from flight_beside import NO_WALLS, fly_beside

from cepa.dynamic.obstacle_tracks.tracks import TrackerParameters

WALL = np.array([((0.9, -8.0, 0.0), (1.2, 8.0, 8.0))])
HALF_M = 0.25


def back(position):
    """Return the v_ref that leads back to the origin."""
    return tuple(np.clip(-0.5 * position[:2], -0.7, 0.7).tolist())


@pytest.mark.parametrize("has_puck", [pytest.param(False, marks=pytest.mark.long), True])
@pytest.mark.parametrize(
    ("walls", "speed", "from_m"),
    [
        (NO_WALLS, 0.45, (-3.0, 0.5)),
        pytest.param(WALL, 0.3, (-3.0, 0.0), marks=pytest.mark.long),
        (WALL, 0.5, (-2.0, 2.0)),
    ],
)
def test_who_walks_up_slowly_to_a_uav_that_hovers_touches_nobody(walls, speed, from_m, has_puck):
    """He stops just before the place that the UAV is to keep."""
    away_m = math.hypot(*from_m)

    def comes_at(t):
        share = max(1.0 - speed * t / away_m, 0.2 / away_m)
        x, y = share * from_m[0], share * from_m[1]
        return (x - HALF_M, y - HALF_M, 0.0), (x + HALF_M, y + HALF_M, 1.75)

    nearest = fly_beside(
        comes_at, back, away_m / speed + 3.0, (0.0, 0.0, 1.2), has_puck=has_puck, walls=walls
    )
    assert nearest.box_m > 0.0
    assert nearest.walls_m > 0.0


def test_a_velocity_counts_sooner_while_the_uav_hovers():
    parameters = TrackerParameters(
        speed_min_m_s=0.4, significance=3.0, hovering_m_s=0.6, speed_min_hovering_m_s=0.2
    )
    assert parameters.least(0.59) == (0.2, parameters.significance_hovering)
    assert parameters.least(0.6) == (0.4, 3.0)
    assert parameters.least(math.inf) == (0.4, 3.0)
