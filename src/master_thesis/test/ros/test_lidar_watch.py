"""How the lidar hangs on the UAV in flight, from transforms and scans."""

import numpy as np
import pytest

rospy = pytest.importorskip("rospy", reason="needs ROS")
lidar_watch = pytest.importorskip(
    "master_thesis_ros.experiments_3_4.lidar_watch", reason="the workspace is not built, or not sourced"
)
TransformStamped = pytest.importorskip("geometry_msgs.msg").TransformStamped
Odometry = pytest.importorskip("nav_msgs.msg").Odometry
LaserScan = pytest.importorskip("sensor_msgs.msg").LaserScan
TFMessage = pytest.importorskip("tf2_msgs.msg").TFMessage


class Subscriptions(dict):
    """Stands for rospy.Subscriber: keeps the callback of each topic."""

    def __call__(self, topic, _kind, callback, **_):
        self[topic] = callback
        return self

    def unregister(self):
        pass


@pytest.fixture
def heard(monkeypatch):
    topics = Subscriptions()
    monkeypatch.setattr(lidar_watch.rospy, "Subscriber", topics)
    watch = lidar_watch.LidarWatch()
    topics["ground_truth"](Odometry(child_frame_id="base_frame"))
    mount = edge("base_frame", "lidar_mount", 0.0, (0.1, 0.0, 0.2), 0.0)
    topics["/tf_static"](TFMessage([mount]))
    return watch, topics


def edge(parent, child, stamp_s, place, pitch):
    found = TransformStamped(child_frame_id=child)
    found.header.frame_id, found.header.stamp = parent, rospy.Time.from_sec(stamp_s)
    t, q = found.transform.translation, found.transform.rotation
    t.x, t.y, t.z = place
    q.y, q.w = np.sin(pitch / 2), np.cos(pitch / 2)
    return found


def scan(stamp_s, frame="lidar"):
    message = LaserScan()
    message.header.frame_id, message.header.stamp = frame, rospy.Time.from_sec(stamp_s)
    return message


def test_a_nodding_lidar_has_another_attitude_at_each_scan(heard):
    """The joint's transforms come after the scans, at other stamps: TF interpolates between them."""
    watch, topics = heard
    stamps_s = [1.0, 1.025, 1.05]
    for stamp_s in stamps_s:
        topics["lidar_scan"](scan(stamp_s))
    for stamp_s in (0.99, 1.06):
        topics["/tf"](TFMessage([edge("lidar_mount", "lidar", stamp_s, (0, 0, 0), 2.0 * (stamp_s - 1.0))]))
    rows = watch.close()
    np.testing.assert_allclose(rows[:, 0], stamps_s)
    np.testing.assert_allclose(rows[:, 1:4], [(0.1, 0.0, 0.2)] * 3, atol=1e-9)
    np.testing.assert_allclose(2 * np.arcsin(rows[:, 5]), [0.0, 0.05, 0.1], atol=1e-4)


def test_a_scan_that_tf_does_not_know_is_left_out(heard):
    watch, topics = heard
    topics["/tf_static"](TFMessage([edge("lidar_mount", "lidar", 0.0, (0, 0, 0.05), 0.0)]))
    topics["lidar_scan"](scan(1.0, "elsewhere"))
    topics["lidar_scan"](scan(3.0))  # a second later the first one is looked up in vain
    rows = watch.close()
    np.testing.assert_allclose(rows, [[3.0, 0.1, 0.0, 0.25, 0, 0, 0, 1]], atol=1e-9)
