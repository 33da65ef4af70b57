"""CARMEN logs to bags and back: the same scans, poses and stamps; what cannot be done is one sentence."""

import math
from pathlib import Path

import numpy as np
import pytest

from gridslam.logs.carmen import (
    CarmenOdometry,
    CarmenScan,
    flaser_angles,
    format_odometry,
    format_scan,
    planar_scans,
    read_log,
)

rosbag = pytest.importorskip("rosbag", reason="needs ROS")
carmen_bags = pytest.importorskip(
    "gridslam_ros.carmen_bags", reason="the workspace is not built, or not sourced"
)
from gridslam_ros.bags import BagCount, BagScans  # noqa: E402
from gridslam_ros.frames.odometry_frames import OdometryFrames  # noqa: E402
from gridslam_ros.scan_source import ScanSource  # noqa: E402

INTEL = Path(__file__).resolve().parents[5] / "shared/data"
LIDAR_ON_ROBOT_M = 0.2


def written(path, count=5, beams=181, **changes):
    """A log of a robot that drives a curve, with its lidar 0.2 m ahead of its middle."""
    lines = []
    for index in range(count):
        x, yaw = 0.1 * index, 0.05 * index
        facts = {
            "stamp_s": 1000.0 + index,
            "ranges_m": np.append(np.full(beams - 2, 1.5 + index), [np.inf, np.nan]),
            "robot_in_odom": (x, 0.0, yaw),
            "lidar_in_odom": (x + LIDAR_ON_ROBOT_M * math.cos(yaw), LIDAR_ON_ROBOT_M * math.sin(yaw), yaw),
            "range_max_m": 80.0,
        }
        angles = dict(zip(("angle_min_rad", "angle_increment_rad"), flaser_angles(beams)))
        lines.append(format_scan(CarmenScan(**{**facts, **angles, **changes})))
        lines.append(format_odometry(CarmenOdometry(1000.5 + index, (x, 0.0, yaw), 0.1, 0.05)))
    path.write_text("".join(line + "\n" for line in lines))
    return str(path)


def bag_of(log, *options):
    bag = str(log).replace(".log", ".bag")
    assert carmen_bags.carmen_to_bag([log, bag, *options]) == 0
    return bag


@pytest.mark.parametrize("changes", [{}, {"angle_min_rad": -1.0, "angle_increment_rad": 0.01}])
def test_there_and_back_it_is_the_same_log(tmp_path, changes):
    log = written(tmp_path / "a.log", **changes)
    back = tmp_path / "back.log"
    assert carmen_bags.bag_to_carmen([bag_of(log), str(back), "--odometry", "/odom"]) == 0
    assert back.read_text().splitlines()[1:] == Path(log).read_text().splitlines()


def test_the_bag_is_what_ros_expects(tmp_path):
    with rosbag.Bag(bag_of(written(tmp_path / "a.log"), "--lidar-frame", "sick")) as bag:
        messages = {(topic, stamp.to_sec()): message for topic, message, stamp in bag.read_messages()}
    scan, (odom, lidar) = messages["/scan", 1003.0], messages["/tf", 1003.0].transforms
    assert (scan.header.frame_id, scan.header.stamp.to_sec()) == ("sick", 1003.0)
    np.testing.assert_allclose((scan.angle_min, scan.angle_max), (-math.pi / 2, math.pi / 2), atol=1e-6)
    assert scan.ranges[0] == 4.5
    assert scan.ranges[-2:] == (math.inf, 0.0)
    assert (odom.header.frame_id, odom.child_frame_id) == ("odom", "base_link")
    assert (lidar.header.frame_id, lidar.child_frame_id) == ("base_link", "sick")
    np.testing.assert_allclose(odom.transform.translation.x, 0.3)
    np.testing.assert_allclose(odom.transform.rotation.z, math.sin(0.075))
    np.testing.assert_allclose(lidar.transform.translation.x, LIDAR_ON_ROBOT_M, atol=1e-5)
    assert messages["/odom", 1003.5].twist.twist.linear.x == 0.1


def test_a_lidar_that_wanders_over_the_robot_is_noticed(tmp_path, capsys):
    lines = [
        Path(written(tmp_path / f"{x}.log", 1, lidar_in_odom=(x, 0.0, 0.0))).read_text() for x in (0.0, 1.0)
    ]
    (tmp_path / "a.log").write_text("".join(lines))
    bag = bag_of(str(tmp_path / "a.log"))
    assert "the lidar's pose on the robot changes" in capsys.readouterr().err
    with rosbag.Bag(bag) as opened:
        edges = [message.transforms[1] for _, message, _ in opened.read_messages(["/tf"])]
    assert {edge.transform.translation.x for edge in edges} == {0.0}
    pose = ("--lidar-pose", "0.1", "0.0", "3.0")
    with rosbag.Bag(bag_of(str(tmp_path / "a.log"), *pose)) as opened:
        edges = [message.transforms[1] for _, message, _ in opened.read_messages(["/tf"])]
    assert {edge.transform.translation.x for edge in edges} == {0.1}


@pytest.mark.parametrize(
    ("argv", "words"),
    [
        (["nothing.log"], "nothing.log cannot be read"),
        (["empty.log"], "no FLASER or ROBOTLASER1"),
        (["broken.log"], "broken.log:1: "),
        (["raw.log"], "or are of another lidar: 2 of RAWLASER1."),
    ],
)
def test_logs_that_make_no_bag(tmp_path, monkeypatch, capsys, argv, words):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "empty.log").write_text("# nothing\n")
    (tmp_path / "broken.log").write_text("FLASER 3 1.0 2.0\n")
    (tmp_path / "raw.log").write_text("RAWLASER1 0\nRAWLASER1 1\n")
    assert carmen_bags.carmen_to_bag(argv) == 1
    assert words in capsys.readouterr().err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["broken.log", "empty.log", "raw.log"]


def test_scans_of_another_lidar_are_named(tmp_path, capsys):
    ending = "0 0 0 0 0 0 {} nohost 0\n"
    text = f"FLASER 1 2.0 {ending.format(1)}RLASER 1 2.0 {ending.format(2)}"
    (tmp_path / "a.log").write_text(text)
    assert carmen_bags.carmen_to_bag([str(tmp_path / "a.log")]) == 0
    assert "these are left out: 1 of RLASER." in capsys.readouterr().err


def test_without_a_name_the_file_is_a_new_one_beside_the_old_one(tmp_path, capsys):
    # Given a log in a folder whose name has the endings, too
    folder = tmp_path / "runs.log" / "day.gz.d"
    folder.mkdir(parents=True)
    log = Path(written(folder / "flight.2.log"))
    before = log.read_bytes()
    # When it becomes a bag, twice, and the bag a log
    assert carmen_bags.carmen_to_bag([str(log)]) == 0
    bag = folder / "flight.2.bag"
    assert carmen_bags.carmen_to_bag([str(log)]) == 1
    assert f"{bag} exists already; name it as the second argument" in capsys.readouterr().err
    assert carmen_bags.bag_to_carmen([str(bag)]) == 1
    assert f"{log} exists already" in capsys.readouterr().err
    assert carmen_bags.bag_to_carmen([str(bag), str(bag)]) == 1
    assert "is the file to read" in capsys.readouterr().err
    # Then all is beside the log, which is as it was, until the user names it
    assert {path for path in tmp_path.rglob("*") if path.is_file()} == {log, bag}
    assert log.read_bytes() == before
    assert carmen_bags.bag_to_carmen([str(bag), str(log)]) == 0
    assert log.read_bytes() != before


def test_bags_that_make_no_log(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    bag = str(Path(bag_of(written(tmp_path / "a.log"))).rename("c.bag"))
    for argv, words in (
        (["nothing.bag"], "cannot be opened"),
        ([bag, "--scan", "/front"], "It has scans on /scan."),
        ([bag, "--base-frame", "robot"], "--base-frame"),
        ([str(tmp_path / "a.log")], "is the file to read"),
        ([str(tmp_path / "a.log"), "b.log"], "cannot be opened"),
        ([bag, "/no/folder/a.log"], "cannot be written"),
    ):
        assert carmen_bags.bag_to_carmen(argv) == 1
        assert words in capsys.readouterr().err


@pytest.mark.skipif(not INTEL.exists(), reason=f"needs {INTEL}")
def test_the_intel_log_as_a_bag_is_the_intel_bag(tmp_path):
    ours = str(tmp_path / "intel.bag")
    assert carmen_bags.carmen_to_bag([str(INTEL / "intel_keyframes.log.gz"), ours]) == 0
    log = tmp_path / "theirs.log"
    assert carmen_bags.bag_to_carmen([str(INTEL / "intel_keyframes.bag"), str(log)]) == 0
    back = tmp_path / "ours.log"
    assert carmen_bags.bag_to_carmen([ours, str(back)]) == 0
    assert len(list(read_log(back))) == 910
    for one, other in zip(read_log(back), read_log(log)):
        assert one.stamp_s == other.stamp_s
        np.testing.assert_allclose(one.ranges_m, other.ranges_m, atol=1e-3)
        np.testing.assert_allclose(one.robot_in_odom, other.robot_in_odom, atol=1e-5)


@pytest.mark.skipif(not INTEL.exists(), reason=f"needs {INTEL}")
def test_a_log_read_by_the_library_is_bit_for_bit_its_bag(tmp_path):
    frames, path = OdometryFrames("odom", "base_link", print), str(tmp_path / "intel.bag")
    source = ScanSource(frames, print)
    assert (
        carmen_bags.carmen_to_bag([str(INTEL / "intel_keyframes.log.gz"), path, "--lidar-pose", *"000"]) == 0
    )
    with rosbag.Bag(path) as bag:
        of_bag = [source.planar(m) for m in BagScans("/scan", frames, BagCount(), print, print).of(bag)]
    of_log = list(planar_scans(INTEL / "intel_keyframes.log.gz"))
    assert len(of_log) == len(of_bag) == 910
    for (one, base), (other, other_base) in zip(of_log, of_bag):
        assert (one.stamp_s, one.range_max_m, one.lidar_in_base, base) == (
            other.stamp_s,
            other.range_max_m,
            other.lidar_in_base,
            other_base,
        )
        np.testing.assert_array_equal(one.angles_rad, other.angles_rad)
        np.testing.assert_array_equal(one.ranges_m, other.ranges_m)
