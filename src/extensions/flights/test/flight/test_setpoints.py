"""Setpoints that are set from outside, in a flight without a goal."""

from pathlib import Path

import pytest

from flights.flight.closed_loop import ClosedLoop
from flights.flight.course import Phase
from flights.flight.parameters import ClosedLoopParameters
from simulation_tools.simulation import SimulationParameters

pytestmark = pytest.mark.flight
WORLD = Path(__file__).resolve().parents[2] / "worlds/empty.world"


def test_a_rest_at_a_setpoint_does_not_end_a_flight_without_a_goal():
    with ClosedLoop(ClosedLoopParameters(SimulationParameters(str(WORLD), seed=1), goal_xyz_m=None)) as loop:
        loop.run_to(Phase.FLYING)
        began_s = loop.time_s
        loop.position_controller.set_setpoint((0.0, 0.0, 2.0))
        loop.run(until=lambda loop: loop.time_s > began_s + 10.0)
        assert loop.monitor.course.phase is Phase.FLYING
        assert loop.log.truth.array("z_m")[-1] == pytest.approx(2.0, abs=0.3)
        # When it is told, then the flight ends
        loop.monitor.on_goal_reached(True)
        assert loop.run().landed
