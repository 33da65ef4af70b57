"""A bag through gridslam_replay: map, trajectories and timing of a way that is known."""

import json
import math

import numpy as np
import planar_world
import pytest

from gridslam.evaluation.tum import read_tum
from gridslam.map_file import read_map

rosbag = pytest.importorskip("rosbag", reason="needs ROS")
replay = pytest.importorskip("gridslam_ros.replay", reason="the workspace is not built, or not sourced")
rospy = pytest.importorskip("rospy")
TransformStamped = pytest.importorskip("geometry_msgs.msg").TransformStamped
LaserScan = pytest.importorskip("sensor_msgs.msg").LaserScan
TFMessage = pytest.importorskip("tf2_msgs.msg").TFMessage

START_S = 1_500_000_000.0
LIDAR = planar_world.Lidar(6.2, 180, 20.0, 0.01, 10.0)
FEW = ("particles:=5", "linearUpdate:=0.5", "--angularUpdate:=0.3", "srr:=0.02", "srt:=0.02", "stt:=0.05")


def stamp_of(seconds):
    return rospy.Time.from_sec(START_S + seconds)


def transform(parent, child, stamp, pose, z=0.0):
    edge = TransformStamped(child_frame_id=child)
    edge.header.stamp, edge.header.frame_id = stamp, parent
    t, q = edge.transform.translation, edge.transform.rotation
    t.x, t.y, t.z = (*pose[:2], z)
    q.z, q.w = math.sin(pose[2] / 2), math.cos(pose[2] / 2)
    return edge


def message_of(scan, stamp, angles_rad):
    message = LaserScan(range_min=0.02, range_max=scan.range_max_m, ranges=scan.ranges_m)
    message.header.stamp, message.header.frame_id = stamp, "laser"
    message.angle_min, message.angle_increment = angles_rad[0], angles_rad[1] - angles_rad[0]
    return message


@pytest.fixture(scope="module")
def way():
    route = np.array([(-8.0, -5.0), (0.0, -5.0)])
    return planar_world.drive(planar_world.hold(), planar_world.along(route, 0.2), LIDAR, seed=4)


@pytest.fixture(scope="module")
def bag(way, tmp_path_factory):
    """The way as a bag: TF comes 30 ms after each scan, the lidar's mounting once and for all."""
    path = tmp_path_factory.mktemp("bag") / "way.bag"
    with rosbag.Bag(str(path), "w") as opened:
        mounting = transform("base_link", "laser", rospy.Time(), (0.0, 0.0, 0.0), z=0.2)
        opened.write("/tf_static", TFMessage([mounting]), stamp_of(0.0))
        for scan, odometry in zip(way.scans, way.odometry):
            stamp = stamp_of(scan.stamp_s)
            opened.write("/scan", message_of(scan, stamp, LIDAR.angles_rad), stamp)
            edge = transform("odom", "base_link", stamp, odometry)
            opened.write("/tf", TFMessage([edge]), stamp + rospy.Duration(0.03))
    return path


@pytest.fixture(scope="module")
def results(bag):
    assert replay.main([str(bag), *FEW]) == 0
    return bag.parent / "way_slam"


def test_everything_is_written(results):
    assert sorted(path.name for path in results.iterdir()) == [
        "map.pgm",
        "map.png",
        "map.yaml",
        "timing.json",
        "trajectory_final.tum",
        "trajectory_online.tum",
    ]


@pytest.mark.parametrize("name", ["online", "final"])
def test_the_trajectories_are_the_vehicles(results, way, name):
    found = read_tum(results / f"trajectory_{name}.tum")
    index = np.round((found.stamps_s - START_S) / 0.5).astype(int)
    np.testing.assert_allclose(found.stamps_s, START_S + 0.5 * index, atol=1e-5)
    error_m = np.hypot(*(found.poses_in_map - way.truth.poses_in_map[index])[:, :2].T)
    assert error_m.max() < 0.15
    assert len(index) == len(way.scans)


def test_the_map_is_the_holds(results):
    walls = read_map(results / "map.yaml").occupied_xy()
    in_sides = (np.abs(walls[:, 0]) > 14.3) | (np.abs(walls[:, 1]) > 9.3)  # 15 x 10 m, with beams of 0.5 m
    outside = (np.abs(walls[:, 0]) > 15.1) | (np.abs(walls[:, 1]) > 10.1)
    assert len(walls) > 300
    assert in_sides.mean() > 0.98
    assert outside.mean() < 0.02


def test_the_timing_tells_what_was_done(results, way):
    timing = json.loads((results / "timing.json").read_text())
    way_m = np.hypot(*np.diff(way.truth.poses_in_map[:, :2], axis=0).T).sum()
    assert timing["scans_read"] == len(way.scans)
    assert abs(timing["scans_integrated"] - way_m / 0.5) < 4  # linearUpdate
    assert (timing["scans_without_tf"], timing["scans_unusable"], timing["loops_closed"]) == (0, 0, 0)
    assert 0.0 < timing["cpu_ms_per_integrated_scan"] <= timing["cpu_s"] * 1e3
    assert timing["parameters"]["particles"] == 5


def test_the_same_again_is_the_same(bag, results, tmp_path):
    assert replay.main([str(bag), "--output", str(tmp_path / "again"), *FEW]) == 0
    for name in ("map.pgm", "trajectory_online.tum", "trajectory_final.tum"):
        assert (tmp_path / "again" / name).read_bytes() == (results / name).read_bytes()


def test_only_every_third_scan(bag, tmp_path, way):
    assert replay.main([str(bag), "--output", str(tmp_path), "throttle_scans:=3", *FEW]) == 0
    assert len(read_tum(tmp_path / "trajectory_online.tum").stamps_s) == len(way.scans) // 3


def test_on_a_starting_map(bag, results, tmp_path, way):
    given = (f"starting_map:={results / 'map.yaml'}", "starting_pose:=-7.9 -5.1 0", "localisation_only:=true")
    assert replay.main([str(bag), "--output", str(tmp_path), *given, *FEW]) == 0
    last = read_tum(tmp_path / "trajectory_online.tum").poses_in_map[-1]
    np.testing.assert_allclose(last[:2], way.truth.poses_in_map[-1, :2], atol=0.15)


@pytest.mark.parametrize(
    ("words", "answer"),
    [
        (["BAG", "partcles:=5"], "no parameter partcles"),
        (["BAG", "particles:=0"], "particles must be at least 1"),
        (["BAG", "--scan", "/front"], "There are scans on /scan."),
        (["BAG", "base_frame:=robot"], "base_frame:=..."),
        (["BAG", "starting_map:=/nothing.yaml"], "/nothing.yaml cannot be read"),
        (["/nothing.bag"], "/nothing.bag cannot be opened"),
    ],
)
def test_what_cannot_be_done_is_one_sentence(bag, capsys, tmp_path, words, answer):
    words = [str(bag) if word == "BAG" else word for word in words]
    assert replay.main([*words, "--output", str(tmp_path / "none")]) == 1
    said = capsys.readouterr().err
    assert answer in said
    assert "Traceback" not in said
    assert not (tmp_path / "none").exists()


def test_parameters_and_other_words():
    given, rest = replay.split_parameters(
        ["a.bag", "--particles:=60", "_delta:=0.1", "map_frame:=m", "--scan", "/s"]
    )
    assert given == {"particles": 60, "delta": 0.1, "map_frame": "m"}
    assert rest == ["a.bag", "--scan", "/s"]
