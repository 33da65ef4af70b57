"""The small airframe passes a manhole and flies with the heaviest lidar."""

import math
from pathlib import Path

import numpy as np
import pytest

from simulation_tools.px4.modes import Mode, Result
from simulation_tools.px4.setpoint import Setpoint
from simulation_tools.sdf.elements import Box
from simulation_tools.sdf.parser import load_model
from simulation_tools.simulation import Simulation, SimulationParameters

PACKAGE = Path(__file__).parents[2]
WITH_MARGIN_M = 0.25
"""A body of this radius passes manholes of 0.6 x 0.8 m (a published tank; 0.30 m does not)."""


def test_all_that_touches_lies_within_a_quarter_of_a_metre_with_5_cm_to_spare():
    quad = load_model("model://small_quad", [PACKAGE / "models"])
    reach_m = [
        math.hypot(*(link.pose @ each.pose).position_m[:2]) + half_width(each.geometry)
        for link in quad.links
        for each in link.collisions
    ]
    assert max(reach_m) == pytest.approx(0.125 + 0.0635, abs=1e-4)  # a motor's distance and a rotor's radius
    assert max(reach_m) + 0.05 < WITH_MARGIN_M


def half_width(geometry):
    return math.hypot(*geometry.size_m[:2]) / 2 if isinstance(geometry, Box) else geometry.radius_m


@pytest.mark.table("lidar", ["ust", "m8"])
def test_it_flies_to_the_side_and_stands_still_there(lidar):
    parameters = SimulationParameters(
        str(PACKAGE / "worlds/empty.world"),
        model="small_quad",
        lidar=lidar,
        model_path=(PACKAGE / "models",),
    )
    simulation = Simulation(parameters)
    flown = [fly(simulation, (0.0, 0.0, 1.5), 12.0), fly(simulation, (0.0, 3.0, 1.5), 10.0)]
    for states, goal in zip(flown, ((0.0, 0.0, 1.5), (0.0, 3.0, 1.5))):
        last = states[-500:]  # 2 s
        places = np.array([state.pose.position_m for state in last]) - (0.0, 0.0, 0.075)
        np.testing.assert_allclose(places, np.tile(goal, (len(places), 1)), atol=0.12)
        rates = np.array([state.angular_velocity_rad_s for state in last])
        assert np.abs(rates).max() < 0.3
    simulation.close()


def fly(simulation, goal, seconds):
    """Fly to a place in ENU, m, and return the true states of each step."""
    px4, states = simulation.px4, []
    for step in range(round(seconds / 0.004)):
        px4.offer_setpoint(Setpoint.hold(goal))
        if step == 250 and px4.armed_since_us is None:
            assert px4.request_mode(Mode.OFFBOARD) is Result.ACCEPTED
            assert px4.request_arm() is Result.ACCEPTED
        simulation.step()
        states.append(simulation.world.get_state(simulation.uav_name))
    return states
