"""The small UAV of the ballast tank flies through a manhole and back, past CEPA with cushions that fit it."""

from dataclasses import replace

import pytest

from inspection_tools import PositionControllerParameters, Waypoint
from master_thesis.flight.closed_loop import ClosedLoop
from master_thesis.flight.course import Phase
from master_thesis.flight.parameters import LED_CEPA, ClosedLoopParameters
from master_thesis.worlds.ballast_tank import BallastTankParameters
from simulation_tools.geometry import Pose
from simulation_tools.simulation import SimulationParameters

pytestmark = pytest.mark.flight

RADIUS_M = 0.2
CUSHIONS = {"body_radius": RADIUS_M, "r_lb": 0.22, "r_ub": 0.4, "emergency_lookahead": 0.4}
"""As exploring.launch has them for this radius."""


@pytest.mark.parametrize("lidar", ["near_puck", "qt64"])
def test_the_small_uav_passes_a_manhole_both_ways(lidar, worlds_folder):
    tank = BallastTankParameters()
    manhole = tank.manhole(2)
    bulkhead_x, y, z = tank.bulkheads_x_m[2], sum(manhole.across_m) / 2, sum(manhole.height_m) / 2
    ways = [bulkhead_x - 1.0, bulkhead_x + 1.0, bulkhead_x - 1.0]
    simulation = SimulationParameters(
        str(worlds_folder / "ballast_tank.world"),
        model="small_quad",
        lidar=lidar,
        spawn_pose=Pose((0.0, 0.375, 0.0)),
    )
    parameters = ClosedLoopParameters(
        simulation,
        goal_xyz_m=None,
        mission=tuple(Waypoint((x, y, z)) for x in ways),
        cepa=replace(LED_CEPA, **CUSHIONS),
        position_controller=PositionControllerParameters(max_speed=0.8),
    )
    with ClosedLoop(parameters) as loop:
        outcome = loop.run_to(Phase.HOVERING)
        x_m = loop.log.truth.array("x_m")[:, 0]
    assert outcome.reached_goal
    assert not outcome.collision
    assert x_m.max() > bulkhead_x + 0.6
    assert x_m[-1] < bulkhead_x - 0.6
