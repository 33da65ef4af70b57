"""The publisher's state machine and the PX4 stand-in together: what one does after the other's failsafe."""

import pytest

from master_thesis.flight.publisher_link import PublisherLink
from simulation_tools.publisher import PublisherParameters
from simulation_tools.px4.modes import LandedState, Mode
from simulation_tools.simulation import Simulation, SimulationParameters

pytestmark = pytest.mark.flight


@pytest.fixture
def run(worlds_folder):
    """Return (simulation, link, run(seconds, until)) of a UAV with its publisher over a plain."""
    simulation = Simulation(SimulationParameters(world=str(worlds_folder / "empty.world"), lidar=None))
    link = PublisherLink(simulation.px4, PublisherParameters())

    def run(seconds, until=lambda: False):
        end_us = simulation.time_us + round(1e6 * seconds)
        while simulation.time_us < end_us and not until():
            simulation.step()
            link.on_time(simulation.time_us)
        return until()

    yield simulation, link, run
    simulation.close()


def test_after_a_failsafe_landing_the_publisher_takes_off_again(run, monkeypatch):
    simulation, link, run = run
    px4 = simulation.px4
    assert run(20.0, until=lambda: link.ready)

    # When setpoints no longer get through, PX4 lands, disarms, and stays in AUTO.LAND
    monkeypatch.setattr(px4, "offer_setpoint", lambda setpoint: False)
    assert run(15.0, until=lambda: not px4.status.armed)
    assert not link.ready
    run(0.5)
    assert (px4.status.mode, px4.status.landed_state) == (Mode.AUTO_LAND, LandedState.ON_GROUND)

    # When they do again, the publisher asks for OFFBOARD and arms, as for the first take-off
    monkeypatch.undo()
    assert run(20.0, until=lambda: link.ready)
    assert (px4.status.mode, px4.status.armed) == (Mode.OFFBOARD, True)
