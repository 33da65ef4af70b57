"""Putting a UAV together: the six lidars, their frame, weight and range."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from simulation_tools.sdf.document import SdfError
from simulation_tools.vehicle.airframe import Airframe
from simulation_tools.vehicle.gimbal import Gimbal
from simulation_tools.vehicle.uav import LIDARS, UavError, load_uav, remarks_on

MODELS = Path(__file__).resolve().parents[2] / "models"

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


@pytest.mark.table("carrier", ["iris", "reference_quad", "small_quad"])
@pytest.mark.table("lidar", LIDARS)
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


@pytest.mark.table("model", ["iris", "model://iris"])
def test_a_model_may_be_named_as_in_gazebo(model):
    assert load_uav(model).model.name == "iris"


def put_model(folder, name, body):
    home = folder / name
    home.mkdir()
    (home / "model.config").write_text('<model><sdf version="1.6">model.sdf</sdf></model>')
    (home / "model.sdf").write_text(f'<sdf version="1.6"><model name="{name}">{body}</model></sdf>')
    return home


def test_px4s_models_on_the_path_do_not_replace_the_packages_own(tmp_path, monkeypatch):
    for name in ("iris", "lidar_ust", "camera"):
        put_model(tmp_path, name, '<link name="other"/>')
    monkeypatch.setenv("GAZEBO_MODEL_PATH", str(tmp_path))
    uav = load_uav("iris", "ust", sensors=("camera",)).model
    assert uav == load_uav("iris", "ust", [MODELS], sensors=("camera",)).model
    (said,) = remarks_on("iris", uav)
    assert str(tmp_path / "iris") in said
    assert load_uav("model://iris").model.links[0].name == "other"
    assert load_uav("iris", model_path=[tmp_path]).model.links[0].name == "other"


def test_a_link_without_inertia_is_said(tmp_path, monkeypatch):
    put_model(
        tmp_path,
        "lidar_mine",
        '<link name="hokuyo"><inertial><mass>0.1</mass></inertial><sensor name="s" type="ray"><ray><scan>'
        "<horizontal><samples>3</samples><min_angle>-1</min_angle><max_angle>1</max_angle></horizontal></scan>"
        "<range><min>.1</min><max>5</max></range></ray></sensor></link>",
    )
    monkeypatch.setenv("GAZEBO_MODEL_PATH", str(tmp_path))
    (said,) = remarks_on("iris", load_uav("iris", "mine").model)
    assert 'The link "hokuyo" has no <inertia>' in said
    assert remarks_on("iris", load_uav("iris", "ust").model) == ()


def test_a_uav_that_includes_a_uav_carries_lidar_and_sensors(tmp_path, monkeypatch):
    """A payload of 50 g under PX4's Iris, which comes by <include> under a name of its own."""
    put_model(
        tmp_path,
        "mine",
        "<include><uri>model://iris</uri><name>body</name></include>"
        '<link name="payload"><inertial><mass>0.05</mass><inertia><ixx>1e-5</ixx><iyy>1e-5</iyy>'
        "<izz>1e-5</izz>"
        '</inertia></inertial></link><joint name="j" type="fixed"><parent>body::base_link</parent>'
        "<child>payload</child></joint>",
    )
    monkeypatch.setenv("GAZEBO_MODEL_PATH", f"{tmp_path}:{MODELS}")
    uav, alone = (load_uav(name, "ust", sensors=("range_finder",)) for name in ("mine", "iris"))
    assert mass_kg(uav) == pytest.approx(mass_kg(alone) + 0.05)
    assert uav.lidar.pose == alone.lidar.pose
    assert Airframe.from_sdf(uav.model).rotor_joints == {f"body::rotor_{number}_joint" for number in range(4)}
    gimbal, own = Gimbal.from_sdf(uav.model), Gimbal.from_sdf(alone.model)
    assert gimbal.joint_names == tuple(f"body::{name}" for name in own.joint_names)
