"""The shipped models: valid for Gazebo's own checker, and of the masses and angles that the tables say."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from simulation_tools.sdf.elements import ImuSensor, RaySensor
from simulation_tools.sdf.frames import attach
from simulation_tools.sdf.parser import load_model, load_world
from simulation_tools.world.assembly import combined

MODELS = Path(__file__).resolve().parents[2] / "models"
NAMES = sorted(folder.name for folder in MODELS.iterdir() if (folder / "model.config").is_file())

# Thesis, tables 8.2 and D.1: field of view deg, range m, step deg, rate Hz, accuracy m, weight kg.
LIDARS = {
    "urg": (240.0, 0.02, 5.6, 360.0 / 1024.0, 10.0, 0.03, 0.16),
    "ust": (270.0, 0.06, 10.0, 0.25, 40.0, 0.04, 0.13),
    "utm": (270.0, 0.1, 30.0, 0.25, 40.0, 0.03, 0.21),
    "puck": (360.0, 0.5, 100.0, 0.2, 20.0, 0.03, 0.59),
    "tim": (270.0, 0.05, 25.0, 1.0 / 3.0, 15.0, 0.06, 0.25),
    "m8": (360.0, 0.5, 150.0, 0.2, 30.0, 0.05, 0.80),
}


def mass_of(model):
    return combined((link.inertial, link.pose) for link in model.links)


@pytest.mark.table("name", [name for name in NAMES if name != "sun"])
def test_it_loads_without_a_warning(name):
    assert load_model(f"model://{name}", [MODELS]).warnings == ()


def test_the_sun_can_be_included_in_a_world(tmp_path):
    world = tmp_path / "w.world"
    world.write_text(
        '<sdf version="1.6"><world name="w"><include><uri>model://sun</uri></include></world></sdf>'
    )
    parsed = load_world(world, [MODELS])
    assert (parsed.models, parsed.warnings) == ((), ())


@pytest.mark.table(
    ("name", "mass", "inertia"),
    [
        ("iris", 1.5, (0.029125, 0.029125, 0.055225)),
        ("reference_quad", 0.8, (0.005, 0.005, 0.009)),
        ("small_quad", 1.2, (0.009, 0.009, 0.015)),
    ],
)
def test_a_quadrotor_balances_with_the_stated_mass_and_inertia(name, mass, inertia):
    body = mass_of(load_model(f"model://{name}", [MODELS]))
    assert body.mass_kg == pytest.approx(mass, abs=1e-9)
    np.testing.assert_allclose(body.centre_m, 0.0, atol=1e-9)
    np.testing.assert_allclose(body.inertia_kg_m2, np.diag(inertia), atol=1e-9)


def test_the_iris_has_px4s_rotors():
    iris = load_model("model://iris", [MODELS])
    motors = {
        int(plugin.parameters["motorNumber"]): plugin.parameters
        for plugin in iris.plugins
        if plugin.filename == "libgazebo_motor_model.so"
    }
    places = [(0.13, -0.22), (-0.13, 0.20), (0.13, 0.22), (-0.13, -0.20)]
    for number, (place, turning) in enumerate(zip(places, ("ccw", "ccw", "cw", "cw"))):
        parameters = motors[number]
        assert iris.link(parameters["linkName"]).pose.position_m[:2] == place
        assert iris.joint(parameters["jointName"]).child == parameters["linkName"]
        assert parameters["turningDirection"] == turning
        assert float(parameters["motorConstant"]) == 5.84e-6
        assert float(parameters["momentConstant"]) == 0.06
        assert float(parameters["maxRotVelocity"]) == 1100.0
        assert float(parameters["timeConstantUp"]) == 0.0125
        assert float(parameters["timeConstantDown"]) == 0.025
        assert float(parameters["rotorDragCoefficient"]) == 1.75e-4
    assert len(iris.sensors(ImuSensor)) == 1


@pytest.mark.table("key", sorted(LIDARS))
def test_a_lidar_is_as_in_the_thesis(key):
    fov_deg, near, far, step_deg, rate, accuracy, weight = LIDARS[key]
    model = load_model(f"model://lidar_{key}", [MODELS])
    (link, sensor) = model.sensors(RaySensor)[0]
    assert link.name == "hokuyo"
    assert (sensor.range_min_m, sensor.range_max_m, sensor.update_rate_hz) == (near, far, rate)
    assert sensor.noise.stddev == pytest.approx(accuracy / 3.0, abs=1e-9)
    assert mass_of(model).mass_kg == pytest.approx(weight)
    beams = sensor.horizontal
    assert math.degrees(beams.increment_rad) == pytest.approx(step_deg, abs=1e-12)
    # A full circle does not measure its seam twice; the others are symmetric about the front.
    seen_deg = math.degrees(beams.max_angle_rad - beams.min_angle_rad)
    if fov_deg == 360.0:
        assert beams.samples == round(360.0 / step_deg)
        assert seen_deg == pytest.approx(360.0 - step_deg)
    else:
        assert beams.min_angle_rad == -beams.max_angle_rad
        assert fov_deg - step_deg < seen_deg <= fov_deg + 1e-9


@pytest.mark.table("key", sorted(LIDARS))
@pytest.mark.table("carrier", ["iris", "reference_quad", "small_quad"])
def test_a_lidar_on_a_quadrotor_adds_its_mass_and_sees_over_the_rotors(carrier, key):
    bare = load_model(f"model://{carrier}", [MODELS])
    whole = attach(bare, load_model(f"model://lidar_{key}", [MODELS]), "lidar_mount")
    assert mass_of(whole).mass_kg == pytest.approx(mass_of(bare).mass_kg + LIDARS[key][-1])
    np.testing.assert_allclose(mass_of(whole).centre_m[:2], 0.0, atol=1e-9)
    lidar = whole.link("hokuyo").pose
    assert lidar.orientation_xyzw == (0.0, 0.0, 0.0, 1.0)
    assert lidar.position_m[2] > whole.link("rotor_0").pose.position_m[2] + 0.03
