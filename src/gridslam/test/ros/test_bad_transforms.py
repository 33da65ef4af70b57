"""Bags whose TF tells of a part of the scans only, or tells one thing twice: what is right is mapped."""

import planar_world
import pytest

from gridslam import se2

rosbag = pytest.importorskip("rosbag", reason="needs ROS")
pytest.importorskip("gridslam_ros.replay", reason="the workspace is not built, or not sourced")
rospy = pytest.importorskip("rospy")
TFMessage = pytest.importorskip("tf2_msgs.msg").TFMessage
from test_bad_bags import ROUTE, as_it_is, error_m, mounting, refused, write  # noqa: E402
from test_replay import LIDAR, message_of, stamp_of, transform  # noqa: E402


@pytest.fixture(scope="module")
def drive():
    return planar_world.drive(planar_world.hold(), planar_world.along(ROUTE, 0.25), LIDAR, seed=4)


def test_scans_before_odometry_begins_are_told(drive, tmp_path, capsys):
    def late(index, stamp, base):
        return as_it_is(index, stamp, base) if index >= 10 else []

    worst_m, poses = error_m(write(tmp_path / "late.bag", drive, [mounting()], edges=late), drive)
    assert worst_m < 0.2
    assert poses == len(drive.scans) - 10
    said = capsys.readouterr().err
    assert "10 of the 57 scans are not in the map: the transforms are of other times than the scans" in said


def test_scans_of_a_lidar_without_a_mounting_keep_no_others_out(drive, tmp_path, capsys):
    # given two lidars on one topic. Odometry comes after the scans of both, and one of them hangs nowhere
    path = tmp_path / "two.bag"
    with rosbag.Bag(str(path), "w") as opened:
        opened.write("/tf_static", TFMessage([mounting()]), stamp_of(0.0))
        for index, (scan, base) in enumerate(zip(drive.scans, drive.odometry)):
            stamp = stamp_of(scan.stamp_s)
            for frame, after_s in (("laser", 0.0), ("laser_back", 0.001)):
                message = message_of(scan, stamp + rospy.Duration.from_sec(after_s), LIDAR.angles_rad)
                message.header.frame_id = frame
                opened.write("/scan", message, stamp)
            opened.write("/tf", TFMessage(as_it_is(index, stamp, base)), stamp)
    worst_m, poses = error_m(str(path), drive)
    assert worst_m < 0.2
    assert poses == len(drive.scans)
    said = capsys.readouterr().err
    assert "57 of the 114 scans are not in the map: the lidar's mounting lacks: no transform from" in said
    assert 'to "laser_back" has come' in said


def test_a_mounting_with_two_values_is_told(drive, tmp_path, capsys):
    turned = transform("base_link", "laser", rospy.Time(), (0.3, -0.4, 1.0), z=0.2)
    bag = write(tmp_path / "twice.bag", drive, [turned, mounting(), mounting()])
    assert error_m(bag, drive)[0] < 0.2
    said = capsys.readouterr().err
    assert 'TF "base_link" -> "laser" is told as static with two values, 0.500 m and 57.3 degrees' in said
    assert said.count("two values") == 1


def test_odometry_the_wrong_way_round_is_named(drive, tmp_path, capsys):
    def inverse(index, stamp, base):
        return [transform("base_link", "odom", stamp, se2.inverse(base))]

    bag = write(tmp_path / "inverse.bag", drive, [mounting()], edges=inverse)
    assert 'TF has "odom" below "base_link", but needs "base_link" below "odom"' in refused(bag, capsys)


OFF = (0.5, 0.0, 0.0)


def test_two_odometries_in_turns_are_told_and_the_state_is_uncertain(drive, tmp_path, capsys):
    # given a second source of odometry's transform, half a metre beside the first
    def both(index, stamp, base):
        edges = []
        for part in range(10):
            at = stamp + rospy.Duration.from_sec(0.05 * part)
            edges.append(transform("odom", "base_link", at, base))
            edges.append(transform("odom", "base_link", at + rospy.Duration.from_sec(0.02), base + OFF))
        return edges

    error_m(write(tmp_path / "both.bag", drive, [mounting()], edges=both), drive)
    said = capsys.readouterr().err
    assert 'Two sources send TF "odom" -> "base_link" in turns' in said
    assert "uncertain" in said
