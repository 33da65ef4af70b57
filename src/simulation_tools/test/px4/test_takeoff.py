"""Take-offs against those of real PX4 SITL (July 2021) on `reference_quad` in the same simulator."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from flight import NO_NOISE, Flight

from simulation_tools.px4.modes import LandedState, Mode, Result
from simulation_tools.px4.setpoint import Setpoint
from simulation_tools.simulation import Simulation, SimulationParameters

pytestmark = pytest.mark.flight

PACKAGE = Path(__file__).parents[2]
NAV_TAKEOFF = 22
TO_M = 3.0


def take_off(flight):
    altitude_m = flight.px4.origin.altitude_m + TO_M
    return flight.px4.command(NAV_TAKEOFF, (0.0, 0.0, 0.0, math.nan, math.nan, math.nan, altitude_m))


def climb(flight, heights_m):
    """Fly until LOITER; return when it took off, when it passed the heights, and the time and height then."""
    start_s, passed, detected_s = flight.time_s, {}, None
    while flight.px4.status.mode is not Mode.AUTO_LOITER or detected_s is None:
        flight.step()
        after_s, height_m = flight.time_s - start_s, flight.body.position[2]
        if detected_s is None and flight.px4.status.landed_state is not LandedState.ON_GROUND:
            detected_s = after_s
        for height in heights_m:
            if height_m > height:
                passed.setdefault(height, after_s)
        assert after_s < 15.0, "it never gets there"
    return detected_s, passed, after_s, height_m


@pytest.fixture
def flight():
    flight = Flight.of_reference_quad(seed=1)
    flight.run(3.0)
    return flight


def test_asked_for_before_arming_an_automatic_take_off_takes_px4s_time(flight):
    assert take_off(flight) is Result.ACCEPTED
    flight.run(0.5)
    assert flight.px4.request_arm() is Result.ACCEPTED
    detected_s, passed, loiter_s, loiter_m = climb(flight, (0.05, 1.0, 2.0))
    assert detected_s == pytest.approx(1.0, rel=0.1)
    assert loiter_s == pytest.approx(6.8, rel=0.1)
    assert loiter_m == pytest.approx(2.2, rel=0.1)
    assert passed == pytest.approx({0.05: 4.16, 1.0: 5.37, 2.0: 6.42}, rel=0.02)
    assert "Takeoff detected" in flight.texts
    flight.run(6.0)
    assert flight.body.position[2] == pytest.approx(TO_M, abs=0.05)


def test_asked_for_while_armed_an_automatic_take_off_takes_px4s_time(flight):
    assert flight.px4.request_arm() is Result.ACCEPTED
    flight.run(3.0)
    assert take_off(flight) is Result.ACCEPTED
    detected_s, passed, loiter_s, loiter_m = climb(flight, (0.05, 1.0, 2.0))
    assert detected_s == pytest.approx(0.84, rel=0.1)
    assert loiter_s == pytest.approx(5.79, rel=0.02)
    assert loiter_m == pytest.approx(2.2, rel=0.05)
    assert passed == pytest.approx({0.05: 3.18, 1.0: 4.40, 2.0: 5.46}, rel=0.02)


def test_the_cycle_without_a_setpoint_moves_nothing():
    """PX4 asks for hover thrust for one cycle when the spool-up ends; motors and body hardly notice."""
    flight = Flight.of_reference_quad(noise=NO_NOISE)
    flight.run(1.0)
    take_off(flight)
    flight.px4.request_arm()
    thrusts = []
    for _ in range(round(1.2 / 0.004)):
        flight.step()
        thrusts.append(flight.px4.commands.mean())
        assert flight.body.position == (0.0, 0.0, 0.0)
    assert sum(thrust > 0.3 for thrust in thrusts) == 2  # steps of 4 ms


def test_higher_than_ten_metres_it_goes_on_at_full_speed():
    flight = Flight.of_iris(noise=NO_NOISE)
    flight.run(1.0)
    flight.px4.command(NAV_TAKEOFF, (0.0,) * 3 + (math.nan,) * 3 + (flight.px4.origin.altitude_m + 20.0,))
    flight.px4.request_arm()
    fastest = {"low": 0.0, "high": 0.0}
    for _ in range(round(25.0 / 0.004)):
        flight.step()
        part = "low" if flight.body.position[2] < 9.0 else "high"
        fastest[part] = max(fastest[part], flight.body.velocity[2])
    assert fastest["low"] == pytest.approx(1.5, rel=0.1)  # MPC_TKO_SPEED
    assert 2.0 < fastest["high"] < 3.3  # MPC_Z_VEL_MAX_UP
    assert flight.body.position[2] == pytest.approx(20.0, abs=0.1)


@pytest.mark.table(
    ("model", "stands_m", "rises_s"),
    [("reference_quad", 0.08, 6.80), ("iris", 0.12, None), ("small_quad", 0.075, None)],
)
def test_local_height_is_zero_on_the_ground_and_offboard_rises_as_px4(model, stands_m, rises_s):
    """Asked for z = -2 m, it passes 1.8 m over where it stood 6.80 s after arming."""
    world, models = str(PACKAGE / "worlds/empty.world"), (PACKAGE / "models",)
    simulation = Simulation(SimulationParameters(world, model=model, lidar=None, model_path=models))

    def height_m():
        return simulation.world.get_state(simulation.uav_name).pose.position_m[2] - stands_m

    px4 = simulation.px4
    for _ in range(250):
        px4.offer_setpoint(Setpoint.hold((0.0, 0.0, 2.0)))
        simulation.step()
    assert px4.estimate["position"][0, 2] == pytest.approx(0.0, abs=0.01)
    assert px4.home[2] == pytest.approx(0.0, abs=0.01)
    assert px4.origin.altitude_m == pytest.approx(488.0 + stands_m, abs=0.01)
    assert px4.request_mode(Mode.OFFBOARD) is Result.ACCEPTED
    assert px4.request_arm() is Result.ACCEPTED
    armed_us = simulation.time_us
    while height_m() < 1.8 and simulation.time_us - armed_us < 10_000_000:
        px4.offer_setpoint(Setpoint.hold((0.0, 0.0, 2.0)))
        simulation.step()
    if rises_s is not None:
        assert 1e-6 * (simulation.time_us - armed_us) == pytest.approx(rises_s, rel=0.02)
    for _ in range(1500):
        px4.offer_setpoint(Setpoint.hold((0.0, 0.0, 2.0)))
        simulation.step()
    assert height_m() == pytest.approx(2.0, abs=0.05)
    assert px4.estimate["position"][0, 2] == pytest.approx(-2.0, abs=0.05)
    simulation.close()
