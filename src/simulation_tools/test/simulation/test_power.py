"""The battery in flight: hover power in closed form, an unchanged flight, PX4's actions, empty, swapped."""

from __future__ import annotations

from pathlib import Path

import pytest

from simulation_tools.px4.mavlink import telemetry
from simulation_tools.px4.modes import Mode, Result
from simulation_tools.px4.setpoint import Setpoint
from simulation_tools.simulation import Simulation, SimulationError, SimulationParameters
from simulation_tools.vehicle.energy.battery import BatteryStart

EMPTY = str(Path(__file__).resolve().parents[2] / "worlds" / "empty.world")
G_M_S2 = 9.8
C_IRIS, C_SMALL = 0.8554 / 0.3051 + 0.3177, 0.8554 / 0.1606 + 0.6036
"""Hover power by thrust to the 1.5, W / N^1.5, from the coefficients in the models."""


@pytest.fixture
def make():
    """Returns a function that makes simulations, and closes them afterwards."""
    made = []

    def build(battery=BatteryStart(), **changes):  # noqa: B008
        made.append(Simulation(SimulationParameters(**{"world": EMPTY, "battery": battery, **changes})))
        return made[-1]

    yield build
    for simulation in made:
        simulation.close()


def fly(simulation, seconds, until=lambda: False):
    """Take off and hold 2 m, for a time or until something is true; return the states flown through."""
    px4, states = simulation.px4, []
    for step in range(round(seconds / simulation.time_step_s)):
        px4.offer_setpoint(Setpoint.hold((0.0, 0.0, 2.0), 0.0))
        if step % 50 == 49 and not px4.status.armed and px4.request_mode(Mode.OFFBOARD) is Result.ACCEPTED:
            px4.request_arm()
        simulation.step()
        states.append(simulation.world.get_state(simulation.uav_name).pose)
        if until():
            break
    return states


@pytest.mark.parametrize(
    ("model", "lidar", "sensors", "mass_kg", "coefficient", "load_w"),
    [
        ("iris", None, (), 1.5, C_IRIS, 10.0),
        ("iris", "puck", (), 2.09, C_IRIS, 18.0),
        ("iris", "puck", ("camera", "lamp"), 2.27, C_IRIS, 40.5),
        ("small_quad", "ust", (), 1.33, C_SMALL, 13.6),
    ],
)
@pytest.mark.flight
def test_hover_draws_what_the_model_says(make, model, lidar, sensors, mass_kg, coefficient, load_w):
    """c (m g)^1.5 and the loads; the charge sinks by this power's share of the battery."""
    simulation = make(model=model, lidar=lidar, sensors=sensors)
    fly(simulation, 14.0)
    powers, before_mah = [], simulation.power.battery.reading.consumed_mah
    fly(simulation, 4.0, until=lambda: powers.append(simulation.power.power_w))
    expected_w = coefficient * (mass_kg * G_M_S2) ** 1.5 + load_w
    assert sum(powers) / len(powers) == pytest.approx(expected_w, rel=0.01)
    reading = simulation.power.battery.reading
    assert reading.voltage_v * reading.current_a == pytest.approx(expected_w, rel=0.02)
    drawn_mah = reading.consumed_mah - before_mah
    assert drawn_mah == pytest.approx(expected_w / reading.voltage_v * 4.0 / 3.6, rel=0.02)


@pytest.mark.flight
def test_the_battery_does_not_change_the_flight(make):
    """Bit for bit, with a battery at a third of its charge as without one."""
    with_battery, without = (make(battery) for battery in (BatteryStart(charge=0.33), None))
    assert without.power is None
    assert fly(with_battery, 8.0) == fly(without, 8.0)
    assert with_battery.power.battery.remaining < 0.33


@pytest.mark.parametrize(
    ("charge", "action", "mode", "text"),
    [
        (0.152, 3, Mode.OFFBOARD, "Low battery level! Return advised"),
        (0.072, 0, Mode.OFFBOARD, "Critical battery level!, landing advised"),
        (0.072, 3, Mode.AUTO_RTL, "Critical battery level!, executing RTL"),
        (0.072, 2, Mode.AUTO_LAND, "Critical battery level!, landing"),
        (0.052, 3, Mode.AUTO_LAND, "Dangerous battery level!, landing"),
    ],
)
@pytest.mark.flight
def test_px4_acts_when_the_charge_passes_its_thresholds(make, charge, action, mode, text):
    simulation = make(
        BatteryStart(charge), px4_parameters={"COM_LOW_BAT_ACT": action, "RTL_FLT_TIME": 1440.0}
    )
    texts = []
    simulation.px4.on_statustext = lambda severity, said: texts.append(said)
    fly(simulation, 12.0, until=lambda: text in texts)
    assert text in texts
    assert simulation.px4.status.mode is mode


@pytest.mark.flight
def test_an_empty_battery_lets_the_uav_fall(make):
    simulation = make(BatteryStart(0.01))
    poses = fly(simulation, 20.0, until=lambda: simulation.power.battery.is_empty)
    assert poses[-1].position_m[2] > 1.0
    fell = fly(simulation, 2.0)
    assert fell[-1].position_m[2] < 0.3
    assert simulation.power.power_w == 0.0


def test_a_battery_is_swapped_on_the_ground_only(make):
    simulation = make(BatteryStart(0.5))
    fly(simulation, 6.0)
    with pytest.raises(
        SimulationError, match=r"cannot be swapped while the rotors turn. Land and disarm first."
    ):
        simulation.swap_battery()
    simulation.reset()
    assert simulation.power.battery.remaining == 0.5
    simulation.swap_battery()
    assert simulation.power.battery.remaining == 1.0


@pytest.mark.flight
def test_the_battery_that_px4_simulates_itself_begins_again(make):
    """SIM_BAT_DRAIN 20 s: a flight of 6 s takes a quarter of it at least."""
    parameters = {"SIM_BAT_DRAIN": 20.0, "SIM_BAT_MIN_PCT": 0.0}
    simulation = make(None, px4_parameters=parameters)
    fly(simulation, 6.0)
    assert simulation.px4.status.battery.remaining < 0.8
    with pytest.raises(SimulationError, match="while the rotors turn"):
        simulation.swap_battery()
    simulation.px4.request_arm(False, force=True)
    for _ in range(500):
        simulation.step()
    simulation.swap_battery()
    assert simulation.px4.status.battery.remaining == 1.0


def test_battery_status_tells_mavlinks_units(make):
    """MAVLink: cA, mAh, mV per cell, s, centidegrees; PX4 tells no energy."""
    simulation = make(BatteryStart(0.486, temperature_c=0.0))
    fly(simulation, 6.0)
    px4, reading = simulation.px4, simulation.power.battery.reading
    told, system = (telemetry.build(name, px4, px4.status) for name in ("BATTERY_STATUS", "SYS_STATUS"))
    assert told.current_battery == pytest.approx(100.0 * reading.current_a, abs=5.0)
    assert told.current_consumed == pytest.approx(reading.consumed_mah, abs=1.0)
    assert told.voltages[:3] == pytest.approx([1000.0 * reading.voltage_v / 3] * 3, abs=2.0)
    assert set(told.voltages[3:]) == {65535}
    assert told.time_remaining == pytest.approx(reading.time_remaining_s, rel=0.01)
    assert (told.battery_remaining, told.temperature, told.energy_consumed, told.charge_state) == (
        48,
        0,
        -1,
        1,
    )
    assert system.current_battery == told.current_battery
    assert system.voltage_battery == pytest.approx(sum(told.voltages[:3]), abs=2.0)
    assert system.battery_remaining == 48
