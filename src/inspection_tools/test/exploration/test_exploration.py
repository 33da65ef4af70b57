"""What leads an exploration, without a flight."""

import numpy as np

from inspection_tools.exploration import Exploration, ExplorationParameters, Explorer
from inspection_tools.planning import PathPlanner

HOVER_M = np.array((1.0, 2.0, 3.0))


def test_without_a_map_it_stays_over_its_home_and_decides_nothing():
    exploration = Exploration(PathPlanner(), Explorer(), ExplorationParameters(first_sink=0.7))
    exploration.begin(0.0, HOVER_M)
    for stamp_s in range(60):
        if exploration.follow(float(stamp_s), HOVER_M):
            exploration.look(float(stamp_s), HOVER_M)
        np.testing.assert_allclose(exploration.setpoint_m, HOVER_M - (0.0, 0.0, 0.7))
    assert exploration.told.views == 0
    assert exploration.told.end is None
    assert not exploration.is_home
