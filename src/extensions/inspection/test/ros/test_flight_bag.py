"""Given the bag of a flight, photographs get their poses from SLAM's last path and the camera's TF."""

import json
import math

import numpy as np
import pytest

bags = pytest.importorskip("inspection_ros.flight_bag", reason="needs ROS")

import rosbag  # noqa: E402
import rospy  # noqa: E402
from geometry_msgs.msg import PoseStamped, Quaternion, TransformStamped  # noqa: E402
from nav_msgs.msg import Odometry, Path  # noqa: E402
from own_photographs import store  # noqa: E402
from tf2_msgs.msg import TFMessage  # noqa: E402

from inspection.photograph_poses.command import main  # noqa: E402

pytestmark = pytest.mark.ros
read_flight = bags.read_flight
AHEAD, STRAIGHT_UP = (-0.5, 0.5, -0.5, 0.5), (0.0, 0.0, -math.sqrt(0.5), math.sqrt(0.5))
"""Of an optical frame: x right, y down, z ahead."""
AT_1003_5 = {0x9003: "1970:01:01 00:16:43", 0x9291: "5", 0xA405: 24}


def path_of(aside_m):
    path = Path()
    for stamp_s in (1000.0, 1010.0):
        pose = PoseStamped()
        pose.header.stamp = rospy.Time.from_sec(stamp_s)
        pose.pose.position.x, pose.pose.position.y = stamp_s - 1000.0, aside_m
        pose.pose.orientation.w = 1.0
        path.poses.append(pose)
    return path


def write_bag(path, topic="/gridslam/path"):
    """Along x at 1 m/s, 2 m high; the camera 0.2 m ahead, its axis along x, on a gimbal that turns up."""
    with rosbag.Bag(str(path), "w") as bag:
        mount = TransformStamped()
        mount.header.frame_id, mount.child_frame_id = "base_frame", "gimbal"
        mount.transform.translation.x, mount.transform.rotation.w = 0.2, 1.0
        bag.write("/tf_static", TFMessage([mount]), rospy.Time(1000.0))
        for stamp_s in np.arange(1000.0, 1010.05, 0.1):
            stamp = rospy.Time.from_sec(stamp_s)
            odometry = Odometry(child_frame_id="base_frame")
            odometry.header.stamp = stamp
            odometry.pose.pose.position.x, odometry.pose.pose.position.z = stamp_s - 1000.0, 2.0
            odometry.pose.pose.orientation.w = 1.0
            bag.write("/UAV/odometry", odometry, stamp)
            turning = TransformStamped()
            turning.header.frame_id, turning.child_frame_id = "gimbal", "lens"
            turning.header.stamp = stamp
            turning.transform.rotation = Quaternion(*(STRAIGHT_UP if stamp_s > 1002.0 else AHEAD))
            bag.write("/tf", TFMessage([turning]), stamp)
        for aside_m, stamp_s in ((0.0, 1005.0), (3.0, 1010.0)):
            bag.write(topic, path_of(aside_m), rospy.Time(stamp_s))
    return path


def test_poses_follow_the_last_path_and_a_gimbal_that_turns(tmp_path):
    bag = write_bag(tmp_path / "flight.bag")
    path = store(tmp_path / "DSC1.JPG", block=AT_1003_5)
    assert main([str(tmp_path), "--bag", str(bag), "--camera-frame", "lens"], read_flight) == 0
    held = json.loads(path.with_suffix(".json").read_text())
    assert held["position_m"] == pytest.approx((3.7, 3.0, 2.0), abs=1e-6)
    assert abs(np.dot(held["orientation_xyzw"], STRAIGHT_UP)) == pytest.approx(1.0)
    assert held["stamp_s"] == pytest.approx(1003.5)
    assert main([str(tmp_path), "--bag", str(bag), "--mount", "0,0,1,-0.5,0.5,-0.5,0.5"], read_flight) == 0
    assert json.loads(path.with_suffix(".json").read_text())["position_m"] == pytest.approx((3.5, 3.0, 3.0))


def test_what_a_bag_lacks_is_told(tmp_path, capsys):
    store(tmp_path / "a.jpg", block=AT_1003_5)
    bag = write_bag(tmp_path / "flight.bag", "/other/path")
    given = [str(tmp_path), "--bag", str(bag)]
    assert main(given, read_flight) == 1
    assert "Give one of /other/path with --path" in capsys.readouterr().err
    assert main([*given, "--path", "other/path"], read_flight) == 1
    assert "its TF has no frame inspection_camera_optical" in capsys.readouterr().err
    bag.write_bytes(b"no bag")
    assert main(given, read_flight) == 1
    assert "cannot be read" in capsys.readouterr().err
