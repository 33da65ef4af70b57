"""The battery of a SDF model, named as in Gazebo's LinearBatteryPlugin, and the loads of its devices."""

from __future__ import annotations

from pathlib import Path

import pytest

from simulation_tools.sdf.parser import load_model, parse_model
from simulation_tools.vehicle.energy.battery import BatteryError
from simulation_tools.vehicle.energy.battery_plugins import power_load_w, read_energy
from simulation_tools.vehicle.energy.rotor_power import RotorPower
from simulation_tools.vehicle.uav import load_uav

MODELS = Path(__file__).parents[3] / "models"
TABLE_D1_W = {"urg": 2.5, "ust": 3.6, "utm": 8.0, "puck": 8.0, "tim": 4.0, "m8": 15.0}
"""Thesis, table D.1."""


def model(parameters, filename="libLinearBatteryPlugin.so", more=""):
    return parse_model(
        f"""<sdf version="1.6"><model name="m"><link name="l"/>
        <plugin name="battery" filename="{filename}">{parameters}</plugin>{more}</model></sdf>""",
        "m.sdf",
    )


def test_a_gazebo_models_battery_is_read_with_its_straight_line():
    """The example of LinearBatteryPlugin's documentation."""
    supply = read_energy(
        model(
            "<battery_name>linear_battery</battery_name><voltage>12.592</voltage>"
            "<open_circuit_voltage_constant_coef>12.694</open_circuit_voltage_constant_coef>"
            "<open_circuit_voltage_linear_coef>-3.1424</open_circuit_voltage_linear_coef>"
            "<initial_charge>1.1665</initial_charge><capacity>1.2009</capacity>"
            "<resistance>0.061523</resistance><smooth_current_tau>1.9499</smooth_current_tau>"
            "<power_load>6.5</power_load>",
            "ignition-gazebo-linearbatteryplugin-system",
        )
    )
    battery = supply.battery
    assert (battery.capacity_ah, battery.initial_charge_ah, battery.resistance_ohm) == (
        1.2009,
        1.1665,
        0.061523,
    )
    assert (battery.cells, battery.smooth_current_tau_s, battery.power_load_w) == (3, 1.9499, 6.5)
    assert battery.open_circuit_voltage_v(1.0) == 12.694
    assert battery.open_circuit_voltage_v(0.5) == pytest.approx(12.694 - 0.5 * 3.1424)
    assert supply.rotors == RotorPower()


def test_without_a_line_it_is_a_full_lipo_of_as_many_cells_as_the_voltage_says():
    battery = read_energy(model("<voltage>16.8</voltage><capacity>4</capacity>")).battery
    assert (battery.cells, battery.initial_charge_ah, battery.linear_voltage_v) == (4, 4.0, None)


@pytest.mark.table("lidar", TABLE_D1_W)
def test_a_lidar_draws_what_the_thesis_says(lidar):
    carried, bare = (load_uav("iris", name, [MODELS]).model for name in (lidar, None))
    assert power_load_w(carried) - power_load_w(bare) == pytest.approx(TABLE_D1_W[lidar])


@pytest.mark.table(("name", "watt_hours"), [("iris", 58.0), ("small_quad", 61.0)])
def test_the_shipped_quadrotors_have_a_full_battery(name, watt_hours):
    battery = read_energy(load_model(f"model://{name}", [MODELS])).battery
    assert battery.initial_charge_ah == battery.capacity_ah
    mean_v = sum(battery.open_circuit_voltage_v(0.005 + 0.01 * i) for i in range(100)) / 100
    assert mean_v * battery.capacity_ah == pytest.approx(watt_hours, abs=1.0)


def test_a_model_without_a_battery_has_none():
    assert read_energy(load_model("model://reference_quad", [MODELS])) is None


@pytest.mark.table(
    ("parameters", "more", "sentence"),
    [
        ("<voltage>12</voltage>", "", "m.sdf:2: plugin 'battery': <capacity> is missing"),
        ("<voltage>12</voltage><capacity>-1</capacity>", "", "capacity_ah must be greater than 0, not -1.0."),
        (
            "<voltage>12</voltage><capacity>5</capacity><rotor_k2>0</rotor_k2>",
            "",
            "m.sdf:2: plugin 'battery'",
        ),
        (
            "<voltage>12</voltage><capacity>5</capacity><power_load>-2</power_load>",
            "",
            "must not be negative",
        ),
        (
            "<voltage>12</voltage><capacity>5</capacity>",
            '<plugin name="other" filename="libLinearBatteryPlugin.so"/>',
            "A UAV can have one battery only.",
        ),
        (
            "<voltage>12</voltage><capacity>5</capacity>",
            '<plugin name="lamp" filename="libsimulation_tools_power_load.so"/>',
            "plugin 'lamp': <power_load> is missing",
        ),
    ],
)
def test_a_plugin_that_is_wrong_is_named_with_its_line(parameters, more, sentence):
    with pytest.raises(BatteryError) as refused:
        read_energy(model(parameters, more=more))
    assert sentence in str(refused.value)
    assert str(refused.value).startswith("m.sdf:2:")
