"""The small UAV of the ballast tank flies through a manhole and back, past CEPA with cushions that fit it."""

import numpy as np
import pytest

from flights.exploring.places import TANK_CEPA
from flights.flight.closed_loop import ClosedLoop
from flights.flight.course import Phase
from flights.flight.parameters import ClosedLoopParameters
from flights.worlds.ballast_tank import BallastTankParameters
from inspection_tools import PositionControllerParameters, Waypoint
from simulation_tools.geometry import Pose
from simulation_tools.simulation import SimulationParameters

pytestmark = pytest.mark.flight

ROOM_M = 0.1
"""Between a manhole's rim and the radius of a UAV that is in its middle."""


@pytest.mark.parametrize(
    ("algorithm", "lidar"),
    [
        ("dynamic", "qt64"),
        pytest.param("dynamic", "near_puck", marks=pytest.mark.long),
        pytest.param("improved", "near_puck", marks=pytest.mark.long),
        pytest.param("improved", "qt64", marks=pytest.mark.long),
    ],
)
def test_the_small_uav_passes_a_manhole_both_ways(algorithm, lidar, worlds_folder):
    tank = BallastTankParameters()
    manhole = tank.manhole(2)
    bulkhead_x, y, z = tank.bulkheads_x_m[2], sum(manhole.across_m) / 2, sum(manhole.height_m) / 2
    ways = [bulkhead_x - 1.0, bulkhead_x + 1.0, bulkhead_x - 1.0]
    simulation = SimulationParameters(
        str(worlds_folder / "ballast_tank.world"),
        model="small_quad",
        lidar=lidar,
        sensors=("range_finder", "range_finder_up"),
        spawn_pose=Pose((0.0, 0.375, 0.0)),
    )
    parameters = ClosedLoopParameters(
        simulation,
        goal_xyz_m=None,
        algorithm=algorithm,
        range_finders=True,
        mission=tuple(Waypoint((x, y, z)) for x in ways),
        cepa=TANK_CEPA,
        position_controller=PositionControllerParameters(max_speed=0.8),
    )
    with ClosedLoop(parameters) as loop:
        outcome = loop.run_to(Phase.HOVERING)
        x_m, y_m = loop.log.truth.array("x_m", "y_m").T
    assert outcome.reached_goal
    assert not outcome.collision
    in_manhole = np.abs(x_m - bulkhead_x) < 0.05
    assert np.abs(y_m[in_manhole] - y).max() < 0.7 * ROOM_M
    assert x_m.max() > bulkhead_x + 0.6
    assert x_m[-1] < bulkhead_x - 0.6
