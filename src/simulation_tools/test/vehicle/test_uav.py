"""Putting a UAV together: the six lidars, their frame, weight and range."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from simulation_tools.sdf.document import SdfError
from simulation_tools.vehicle.uav import LIDARS, UavError, load_uav

# Thesis, tables 8.2 and D.1: weight, range, rate.
TABLE = {
    "urg": (0.16, 5.6, 10.0),
    "ust": (0.13, 10.0, 40.0),
    "utm": (0.21, 30.0, 40.0),
    "puck": (0.59, 100.0, 20.0),
    "tim": (0.25, 25.0, 15.0),
    "m8": (0.80, 150.0, 30.0),
}


def mass_kg(uav):
    return sum(link.inertial.mass_kg for link in uav.model.links)


@pytest.mark.parametrize("carrier", ["iris", "reference_quad", "small_quad"])
@pytest.mark.parametrize("lidar", LIDARS)
def test_every_lidar_fits_on_every_carrier_and_flies_along(carrier, lidar):
    weight_kg, range_m, rate_hz = TABLE[lidar]
    bare, uav = load_uav(carrier), load_uav(carrier, lidar)
    assert bare.lidar is None
    assert mass_kg(uav) - mass_kg(bare) == pytest.approx(weight_kg, abs=1e-6)
    assert uav.lidar.frame == "hokuyo"
    assert uav.lidar.sensor.range_max_m == pytest.approx(range_m)
    assert uav.lidar.sensor.update_rate_hz == rate_hz
    assert uav.lidar.pose.position_m[2] > 0.05  # above the propellers
    assert uav.imu is not None


def test_the_range_may_be_replaced_but_not_by_less_than_the_least():
    assert load_uav("iris", "tim", range_max_m=15.0).lidar.sensor.range_max_m == 15.0
    with pytest.raises(UavError, match="range_max"):
        load_uav("iris", "tim", range_max_m=0.01)


def test_a_lidar_that_is_none_of_the_six_is_refused_with_their_names():
    with pytest.raises(UavError, match="urg, ust, utm, puck, tim, m8"):
        load_uav("iris", "velodyne")


def test_a_lidar_of_ones_own_is_a_model_of_the_model_path(tmp_path, monkeypatch):
    shutil.copytree(Path(__file__).parents[2] / "models/lidar_ust", tmp_path / "lidar_mine")
    monkeypatch.setenv("GAZEBO_MODEL_PATH", str(tmp_path))
    assert load_uav("iris", "mine").lidar.frame == "hokuyo"
    with pytest.raises(UavError, match="There is no lidar"):
        load_uav("iris", "mine/..")


def test_a_carrier_without_a_mount_is_refused():
    with pytest.raises(SdfError, match="lidar_mount"):
        load_uav("lidar_ust", "ust")


@pytest.mark.parametrize("model", ["iris", "model://iris"])
def test_a_model_may_be_named_as_in_gazebo(model):
    assert load_uav(model).model.name == "iris"
