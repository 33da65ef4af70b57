"""What a file leaves out, and newer or older names: as sdformat has it."""

from __future__ import annotations

import math

import pytest

from simulation_tools.sdf.elements import Box, Cylinder, Sphere
from simulation_tools.sdf.parser import SdfError, parse_model

TWO = '<link name="a"/><link name="b"><pose>0 0 1 0 0 0</pose></link>'


def read(body, version="1.6"):
    return parse_model(f'<sdf version="{version}"><model name="m">{body}</model></sdf>', "some.sdf", [])


def sensed(sensor, version="1.6"):
    return read(f'<link name="a">{sensor}</link>', version)


@pytest.mark.table(
    ("shape", "right", "saying"),
    [
        ("<box/>", Box((1.0, 1.0, 1.0)), "<size>"),
        ("<box><size/></box>", Box((1.0, 1.0, 1.0)), "<size>"),
        ("<cylinder><length>2</length></cylinder>", Cylinder(1.0, 2.0), "<radius>"),
        ("<cylinder><radius>2</radius></cylinder>", Cylinder(2.0, 1.0), "<length>"),
        ("<sphere/>", Sphere(1.0), "<radius>"),
    ],
)
def test_a_shape_without_its_size_has_that_of_sdf_and_this_is_said(shape, right, saying):
    model = read(f'<link name="a"><collision name="c"><geometry>{shape}</geometry></collision></link>')
    assert model.links[0].collisions[0].geometry == right
    (said,) = model.warnings
    assert saying in said


@pytest.mark.table("axis", ["", "<axis/>", "<axis><limit><lower>-1</lower></limit></axis>"])
def test_a_joint_without_an_axis_turns_about_z_and_this_is_said(axis):
    model = read(f'{TWO}<joint name="j" type="revolute"><parent>a</parent><child>b</child>{axis}</joint>')
    assert (model.joints[0].kind, model.joints[0].axis) == ("revolute", (0.0, 0.0, 1.0))
    assert "has no <xyz> of its axis" in model.warnings[0]


def test_a_joint_may_name_frames_in_place_of_links():
    f = '<frame name="f" attached_to="a"/>'
    g = '<frame name="h" attached_to="b"><pose>1 0 0 0 0 0</pose></frame><frame name="g" attached_to="h"/>'
    model = read(f'{TWO}{f}{g}<joint name="j" type="fixed"><parent>f</parent><child>g</child></joint>', "1.8")
    joint = model.joint("j")
    assert (joint.parent, joint.child) == ("a", "b")
    assert joint.pose.position_m == (1.0, 0.0, 0.0)  # it is where the child's frame is


def test_a_joint_may_name_a_nested_model_and_means_its_first_link():
    inner = '<model name="in"><link name="x"/><link name="y"/></model>'
    model = read(
        f'{inner}{TWO}<joint name="j" type="fixed"><parent>in</parent><child>a</child></joint>', "1.8"
    )
    assert (model.joint("j").parent, model.joint("j").child) == ("in::x", "a")


@pytest.mark.table("frame", ['<frame name="f"/>', '<frame name="f" attached_to="f"/>', ""])
def test_a_joint_to_a_frame_of_no_link_is_refused(frame):
    body = f'{TWO}{frame}<joint name="j" type="fixed"><parent>f</parent><child>a</child></joint>'
    with pytest.raises(SdfError, match="f"):
        read(body, "1.8")


SCAN = "<horizontal><samples>9</samples><min_angle>{}</min_angle><max_angle>{}</max_angle></horizontal>"


def lidar(kind="ray", low=-1, high=1, tag="ray", least="<min>0.1</min>"):
    scan = SCAN.format(low, high)
    return (
        f'<sensor name="s" type="{kind}"><{tag}><scan>{scan}</scan>'
        f"<range>{least}<max>9</max></range></{tag}></sensor>"
    )


@pytest.mark.table(
    ("kind", "drawn"), [("ray", False), ("lidar", False), ("gpu_ray", True), ("gpu_lidar", True)]
)
def test_a_lidar_has_its_old_or_its_new_name(kind, drawn):
    for tag in ("ray", "lidar"):
        ((sensor,),) = (link.sensors for link in sensed(lidar(kind, tag=tag)).links)
        assert sensor.sees_what_is_drawn == drawn


@pytest.mark.table(("low", "high"), [(-3.1416, 3.1416), (0, 6.28319), (0, 6.29), (-math.pi, math.pi)])
def test_a_full_circle_may_be_rounded(low, high):
    assert sensed(lidar(low=low, high=high)).links[0].sensors


def test_a_lidar_without_a_least_range_sees_from_zero_on():
    assert sensed(lidar(least="")).links[0].sensors[0].range_min_m == 0.0


def test_a_camera_without_an_image_has_320_x_240_pixels():
    model = sensed('<sensor name="s" type="camera"><camera/></sensor>')
    assert (model.links[0].sensors[0].width, model.links[0].sensors[0].height) == (320, 240)
    assert "has no <image>" in model.warnings[0]


IMU = """<sensor name="s" type="imu"><imu><noise><type>{}</type>
<rate><mean>0.1</mean><stddev>0.2</stddev></rate>
<accel><mean>0.3</mean><stddev>0.4</stddev></accel></noise></imu></sensor>"""


def test_the_noise_of_an_imu_before_sdf_1_6_is_that_of_every_axis():
    sensor = sensed(IMU.format("gaussian"), "1.5").links[0].sensors[0]
    assert {(each.mean, each.stddev) for each in sensor.gyroscope_noise} == {(0.1, 0.2)}
    assert {(each.mean, each.stddev) for each in sensor.accelerometer_noise} == {(0.3, 0.4)}
    quiet = sensed(IMU.format("none"), "1.4").links[0].sensors[0]
    assert {each.stddev for each in quiet.gyroscope_noise} == {0.0}
    assert "noise" in sensed(IMU.format("gaussian"), "1.6").warnings[0]


def test_inertia_that_is_to_be_computed_is_said_not_to_be():
    (said,) = read('<link name="a"><inertial auto="true"/></link>', "1.11").warnings
    assert "auto" in said


def test_words_behind_the_numbers_do_not_count_as_in_gazebo_and_this_is_said():
    model = read('<link name="a"><pose>1 2 3 0 0 0 9</pose><inertial><mass>2 kg</mass></inertial></link>')
    assert model.links[0].pose.position_m == (1.0, 2.0, 3.0)
    assert model.links[0].inertial.mass_kg == 2.0
    assert [said.partition(": ")[2] for said in model.warnings] == [
        'What stands behind the numbers of <pose> does not count: "9".',
        'What stands behind the numbers of <mass> does not count: "kg".',
    ]
