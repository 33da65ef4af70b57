"""Reading SDF: what a good file becomes, and what is said about elements that nothing here acts on."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from simulation_tools.geometry import Pose
from simulation_tools.sdf.elements import (
    AirPressureSensor,
    Box,
    CameraSensor,
    Cylinder,
    ImuSensor,
    Mesh,
    Noise,
    Plane,
    RaySensor,
    Sphere,
)
from simulation_tools.sdf.parser import load_model, load_world, parse_model

BOX = "<geometry><box><size>1 2 3</size></box></geometry>"
TRIANGLE = (
    "solid t\nfacet normal 0 0 1\nouter loop\n"
    "vertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid t\n"
)


def model(body: str, name: str = "m"):
    return parse_model(f'<sdf version="1.6"><model name="{name}">{body}</model></sdf>', "text", [])


def link(body: str):
    return model(f'<link name="a">{body}</link>').links[0]


def put_model(folder: Path, name: str, body: str) -> Path:
    """Write a model folder and return it."""
    home = folder / name
    home.mkdir(parents=True)
    (home / "model.config").write_text('<model><name>x</name><sdf version="1.6">model.sdf</sdf></model>')
    (home / "model.sdf").write_text(f'<sdf version="1.6"><model name="{name}">{body}</model></sdf>')
    return home


def test_a_minimal_model_gets_the_defaults_of_the_specification():
    parsed = model('<link name="a"/>')
    assert parsed.name == "m"
    assert not parsed.static
    assert parsed.pose == Pose()
    assert parsed.links[0].inertial.mass_kg == 1.0
    assert parsed.links[0].inertial.moments_kg_m2 == (1.0, 1.0, 1.0, 0.0, 0.0, 0.0)
    assert parsed.warnings == ()


@pytest.mark.table(
    ("xml", "expected"),
    [
        ("<box><size>1 2 3</size></box>", Box((1.0, 2.0, 3.0))),
        ("<cylinder><radius>.5</radius><length>2</length></cylinder>", Cylinder(0.5, 2.0)),
        ("<sphere><radius>2</radius></sphere>", Sphere(2.0)),
        ("<plane><normal>0 0 2</normal><size>3 4</size></plane>", Plane((0.0, 0.0, 1.0), (3.0, 4.0))),
    ],
)
def test_shapes(xml, expected):
    collision = link(f'<collision name="c"><geometry>{xml}</geometry></collision>').collisions[0]
    assert collision.geometry == expected


def test_surface_and_material():
    parsed = link(
        f'<collision name="c">{BOX}<surface><friction><ode><mu>.4</mu><mu2>.4</mu2></ode></friction>'
        "<bounce><restitution_coefficient>.3</restitution_coefficient></bounce></surface></collision>"
        f'<visual name="v">{BOX}<transparency>.25</transparency>'
        "<material><diffuse>.1 .2 .3 1</diffuse></material></visual>"
    )
    assert parsed.collisions[0].surface.friction == 0.4
    assert parsed.collisions[0].surface.restitution == 0.3
    assert parsed.visuals[0].rgba == (0.1, 0.2, 0.3, 0.75)


def test_a_gazebo_material_script_gives_its_colour():
    script = "<material><script><uri>file://media/x</uri><name>Gazebo/Red</name></script></material>"
    assert link(f'<visual name="v">{BOX}{script}</visual>').visuals[0].rgba == (1.0, 0.0, 0.0, 1.0)


def test_a_lidar():
    sensor = link(
        '<sensor name="s" type="gpu_ray"><pose>0 0 .1 0 0 0</pose><update_rate>40</update_rate><ray><scan>'
        "<horizontal><samples>5</samples><min_angle>-1</min_angle><max_angle>1</max_angle></horizontal></scan>"
        "<range><min>.1</min><max>10</max><resolution>.01</resolution></range>"
        "<noise><type>gaussian</type><mean>.5</mean><stddev>.02</stddev></noise></ray></sensor>"
    ).sensors[0]
    assert isinstance(sensor, RaySensor)
    assert sensor.pose.position_m == (0.0, 0.0, 0.1)
    assert sensor.horizontal.increment_rad == 0.5
    assert (sensor.range_min_m, sensor.range_max_m, sensor.range_resolution_m) == (0.1, 10.0, 0.01)
    assert sensor.noise == Noise(0.5, 0.02)
    assert sensor.update_rate_hz == 40.0


def test_other_sensors():
    noise = '<noise type="gaussian"><mean>0</mean><stddev>{}</stddev></noise>'
    imu, camera, depth, pressure = link(
        '<sensor name="imu" type="imu"><imu><angular_velocity>'
        f"<x>{noise.format(0.1)}</x><z>{noise.format(0.3)}</z></angular_velocity></imu></sensor>"
        '<sensor name="eye" type="camera"><camera><horizontal_fov>1.2</horizontal_fov>'
        "<image><width>64</width><height>48</height></image>"
        "<clip><near>.2</near><far>9</far></clip></camera></sensor>"
        '<sensor name="deep" type="depth"><camera><image/></camera></sensor>'
        '<sensor name="baro" type="air_pressure"><air_pressure><reference_altitude>12</reference_altitude>'
        "</air_pressure></sensor>"
    ).sensors
    assert isinstance(imu, ImuSensor)
    assert [axis.stddev for axis in imu.gyroscope_noise] == [0.1, 0.0, 0.3]
    assert isinstance(camera, CameraSensor)
    assert (camera.width, camera.height, camera.depth, camera.near_m, camera.far_m) == (
        64,
        48,
        False,
        0.2,
        9.0,
    )
    assert isinstance(depth, CameraSensor)
    assert depth.depth
    assert isinstance(pressure, AirPressureSensor)
    assert pressure.reference_altitude_m == 12.0


def test_a_plugin_is_kept_as_it_is_and_a_known_one_gives_no_warning():
    plugin = (
        '<plugin name="p" filename="libgazebo_imu_plugin.so">\n'
        "<motorNumber> 3 </motorNumber><control><kp>1</kp></control>"
        "</plugin>"
    )
    parsed = model('<link name="a"/>' + plugin)
    assert parsed.plugins[0].parameters == {"motorNumber": "3", "control/kp": "1"}
    assert parsed.warnings == ()


def test_everything_unsupported_is_named_once_in_one_sentence_per_file():
    parsed = model(
        '<link name="a">\n<audio_sink/>\n<kinematic>true</kinematic>\n'
        '<sensor name="s" type="sonar"><sonar/></sensor></link>\n'
        '<link name="b">\n<audio_sink/></link>'
        '<link name="c"><audio_sink/></link><link name="d"><audio_sink/></link>'
    )
    assert parsed.warnings == (
        "text: Not supported and therefore without effect: "
        "<model/link/audio_sink> (lines 2, 6, 6 and 1 more), "
        "<model/link/kinematic> (line 3), <model/link/sensor> (line 4).",
    )


def test_a_shape_of_an_unsupported_kind_is_left_out_and_named():
    parsed = model(
        f'<link name="a"><collision name="c">{BOX}</collision>\n'
        '<collision name="h"><geometry><capsule><length>1</length></capsule></geometry></collision>'
        '<visual name="v"><geometry><empty/></geometry></visual></link>'
    )
    assert [collision.name for collision in parsed.links[0].collisions] == ["c"]
    assert parsed.links[0].visuals == ()
    assert parsed.warnings == (
        "text: Not supported and therefore without effect: <model/link/collision/geometry/capsule> (line 2).",
    )


def test_joints_with_axis_limits_and_pose():
    parsed = model(
        '<link name="a"/><link name="b"><pose>1 0 0 0 0 1.5707963267948966</pose></link>'
        '<joint name="j" type="revolute"><pose>0 0 .5 0 0 0</pose><parent>a</parent><child>b</child><axis>'
        "<xyz>2 0 0</xyz><use_parent_model_frame>true</use_parent_model_frame>"
        "<limit><lower>-1e16</lower><upper>1.5</upper></limit><dynamics><damping>.2</damping></dynamics>"
        "</axis></joint>"
    )
    joint = parsed.joints[0]
    assert joint.pose.position_m == (0.0, 0.0, 0.5)
    # The model's x axis, seen from a link that is turned by 90 degrees to the left, is its -y axis.
    np.testing.assert_allclose(joint.axis, (0.0, -1.0, 0.0), atol=1e-12)
    assert (joint.lower_rad, joint.upper_rad, joint.damping) == (-math.inf, 1.5, 0.2)


def test_habits_of_the_models_that_come_with_px4():
    parsed = model(
        f'<link name="base"><collision name="c">{BOX}<surface><contact><ode/></contact>'
        "<friction><ode/></friction></surface></collision><velocity_decay/><gravity>1</gravity><self_collide>0</self_collide></link>"
        '<link name="m/imu_link"/><joint name="m/imu_joint" type="revolute"><child>m/imu_link</child>'
        "<parent>base</parent><axis><xyz>1 0 0</xyz><limit><lower>0</lower><upper>0</upper></limit>"
        "<dynamics><spring_reference>0</spring_reference><spring_stiffness>0</spring_stiffness></dynamics>"
        "<use_parent_model_frame>1</use_parent_model_frame></axis></joint>"
    )
    assert parsed.warnings == ()
    assert parsed.joint("m/imu_joint").kind == "fixed"  # a hinge without play


def test_poses_in_the_frames_of_others():
    parsed = model(
        '<frame name="f"><pose>0 0 1 0 0 0</pose></frame>'
        '<link name="a"><pose frame="f">1 0 0 0 0 1.5707963267948966</pose></link>'
        '<link name="b"><pose relative_to="a">1 0 0 0 0 0</pose>'
        f'<collision name="c"><pose frame="f">0 0 0 0 0 0</pose>{BOX}</collision></link>'
    )
    np.testing.assert_allclose(parsed.link("a").pose.position_m, (1, 0, 1), atol=1e-12)
    np.testing.assert_allclose(parsed.link("b").pose.position_m, (1, 1, 1), atol=1e-12)
    in_model = parsed.link("b").pose @ parsed.link("b").collisions[0].pose
    np.testing.assert_allclose(in_model.position_m, (0, 0, 1), atol=1e-12)


TURNED = '<link name="b"><pose>1 0 0 0 0 1.5707963267948966</pose></link>'


def hinge(more="", xyz="<xyz>1 0 0</xyz>"):
    return (
        f'<joint name="j" type="revolute">{more}<parent>a</parent><child>b</child><axis>{xyz}</axis></joint>'
    )


@pytest.mark.table(
    ("expressed_in", "axis"),
    [
        ("", (1, 0, 0)),  # in the joint's own frame
        ("j", (1, 0, 0)),
        ("b", (1, 0, 0)),
        ("a", (0, -1, 0)),  # a's x axis, seen from b that is turned by 90 degrees to the left
        ("__model__", (0, -1, 0)),
        ("f", (0, 0, 1)),  # its x axis points up
    ],
)
def test_an_axis_in_the_frame_of_another_as_sdf_1_7_has_it(expressed_in, axis):
    frame = '<frame name="f"><pose>0 0 0 0 -1.5707963267948966 0</pose></frame>'
    xyz = f'<xyz expressed_in="{expressed_in}">1 0 0</xyz>'
    parsed = model('<link name="a"/>' + TURNED + frame + hinge(xyz=xyz))
    np.testing.assert_allclose(parsed.joints[0].axis, axis, atol=1e-12)


def test_poses_relative_to_a_joint():
    # the joint stands 0.5 m above b's origin, and b turned by 90 degrees at x = 1 m
    parsed = model(
        '<link name="a"/>'
        + TURNED
        + hinge("<pose>0 0 0.5 0 0 0</pose>")
        + '<link name="c"><pose relative_to="j">2 0 0 0 0 0</pose></link>'
        '<frame name="f" attached_to="j"/><link name="d"><pose relative_to="f">0 1 0 0 0 0</pose></link>'
        '<joint name="k" type="fixed"><pose relative_to="j"/><parent>b</parent><child>c</child></joint>'
        '<model name="arm"><pose>0 0 3 0 0 0</pose><link name="a"/><link name="b"/>'
        + hinge("<pose>0 1 0 0 0 0</pose>")
        + '</model><link name="e"><pose relative_to="arm::j"/></link>'
    )
    np.testing.assert_allclose(parsed.link("c").pose.position_m, (1, 2, 0.5), atol=1e-12)
    np.testing.assert_allclose(parsed.link("d").pose.position_m, (0, 0, 0.5), atol=1e-12)
    np.testing.assert_allclose(parsed.joint("k").pose.position_m, (-2, 0, 0), atol=1e-12)
    np.testing.assert_allclose(parsed.link("e").pose.position_m, (0, 1, 3), atol=1e-12)


def test_nested_models_are_flattened():
    parsed = model(
        '<link name="a"/><model name="arm"><pose>0 0 2 0 0 0</pose><link name="upper"/><link name="lower">'
        '<pose>0 0 1 0 0 0</pose></link><joint name="elbow" type="fixed"><parent>upper</parent>'
        "<child>lower</child></joint></model>"
        '<joint name="shoulder" type="fixed"><parent>a</parent><child>arm::upper</child></joint>'
    )
    assert [one.name for one in parsed.links] == ["a", "arm::upper", "arm::lower"]
    assert parsed.link("arm::lower").pose.position_m == (0.0, 0.0, 3.0)
    assert parsed.joint("arm::elbow").parent == "arm::upper"


def test_a_world_with_includes_that_override_name_pose_and_static(tmp_path):
    put_model(tmp_path, "crate", f'<link name="l"><collision name="c">{BOX}</collision></link>')
    world = tmp_path / "test.world"
    world.write_text(
        '<sdf version="1.6"><world name="w"><gravity>0 0 -1.6</gravity>'
        "<wind><linear_velocity>1 2 0</linear_velocity></wind>"
        '<physics name="p" type="ode"><max_step_size>.002</max_step_size>'
        "<real_time_factor>2</real_time_factor></physics>"
        "<include><uri>model://crate</uri></include>"
        "<include><uri>model://crate</uri><name>second</name><pose>1 2 3 0 0 0</pose>"
        "<static>true</static></include>"
        '<light name="lamp" type="point"><pose>0 0 3 0 0 0</pose></light></world></sdf>'
    )
    parsed = load_world(world, [tmp_path])
    first, second = parsed.models
    assert (first.name, first.static) == ("crate", False)
    assert (second.name, second.static, second.pose.position_m) == ("second", True, (1.0, 2.0, 3.0))
    assert parsed.gravity_m_s2 == (0.0, 0.0, -1.6)
    assert parsed.wind_m_s == (1.0, 2.0, 0.0)
    assert parsed.warnings == ()


def test_the_warning_of_an_included_file_appears_once(tmp_path):
    put_model(tmp_path, "crate", '<link name="l"><audio_sink/></link>')
    world = tmp_path / "test.world"
    includes = "".join(f"<include><uri>model://crate</uri><name>c{k}</name></include>" for k in range(3))
    world.write_text(f'<sdf version="1.6"><world name="w"><population/>{includes}</world></sdf>')
    warnings = load_world(world, [tmp_path]).warnings
    assert len(warnings) == 2
    assert "<world/population>" in warnings[0]
    assert str(tmp_path / "crate" / "model.sdf") in warnings[1]


def test_a_model_is_found_by_uri_by_folder_and_by_file(tmp_path):
    home = put_model(tmp_path, "crate", '<link name="l"/>')
    for place in ("model://crate", home, str(home / "model.sdf")):
        parsed = load_model(place, [tmp_path])
        assert parsed.name == "crate"
        assert parsed.source == str(home / "model.sdf")


def test_the_model_path_comes_from_the_environment_when_none_is_given(tmp_path, monkeypatch):
    put_model(tmp_path, "crate", '<link name="l"/>')
    monkeypatch.setenv("GAZEBO_MODEL_PATH", f"/nowhere:{tmp_path}")
    assert load_model("model://crate").name == "crate"


@pytest.mark.table("uri", ["model://crate/t.stl", "t.stl", "file://{home}/t.stl"])
def test_a_mesh_is_found_by_every_kind_of_uri(tmp_path, uri):
    home = tmp_path / "crate"
    mesh = f"<mesh><uri>{uri.format(home=home)}</uri><scale>1 1 2</scale></mesh>"
    put_model(
        tmp_path, "crate", f'<link name="l"><visual name="v"><geometry>{mesh}</geometry></visual></link>'
    )
    (home / "t.stl").write_text(TRIANGLE)
    geometry = load_model("model://crate", [tmp_path]).links[0].visuals[0].geometry
    assert isinstance(geometry, Mesh)
    assert geometry.path == str(home / "t.stl")
    assert geometry.scale == (1.0, 1.0, 2.0)
