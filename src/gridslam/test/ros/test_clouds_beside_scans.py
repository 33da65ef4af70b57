"""A scan gets the cloud of its own stamp, levelled by the attitude that TF tells."""

import numpy as np
import pytest

rospy = pytest.importorskip("rospy", reason="needs ROS")
cloud_source = pytest.importorskip(
    "gridslam_ros.beside.clouds", reason="the workspace is not built, or not sourced"
)
from gridslam_ros.frames.odometry_frames import FrameError, OdometryFrames  # noqa: E402
from gridslam_ros.volume.messages import cloud_of  # noqa: E402
from slam_probe import room_scan, transform  # noqa: E402
from std_msgs.msg import Header  # noqa: E402

from gridslam import ScanError  # noqa: E402

POINTS = np.array([(2.0, 0.0, 0.5), (0.0, 3.0, -0.5), (np.nan, 0.0, 0.0)])


def source(said=None):
    """With the lidar 0.2 m above a base that is turned by a quarter, from 10 s to 20 s."""
    said = [] if said is None else said
    frames = OdometryFrames("odom", "base_link", said.append)
    frames.add(transform("base_link", "laser", rospy.Time(0), z=0.2).transforms, static=True)
    for stamp_s in (10, 20):
        frames.add(
            transform("odom", "base_link", rospy.Time(stamp_s), (1.0, 2.0, np.pi / 2), z=5.0).transforms
        )
    return cloud_source.CloudSource(frames, said.append)


def cloud(stamp_s):
    return cloud_of(POINTS, Header(stamp=rospy.Time(stamp_s), frame_id="laser"))


def scan(stamp_s):
    return room_scan(rospy.Time(stamp_s), (0.0, 0.0, 0.0))


def test_a_scan_gets_the_cloud_of_its_stamp_at_the_base():
    clouds = source()
    for stamp_s in (11.0, 11.05, 11.1):
        clouds.add(cloud(stamp_s))
    found = clouds.of(scan(11.05))
    np.testing.assert_allclose(found.points_m, np.add(POINTS[:2], (0.0, 0.0, 0.2)), atol=0.003)
    np.testing.assert_allclose(found.lidar_m, (0.0, 0.0, 0.2))


def test_a_scan_waits_for_its_cloud_but_not_for_ever():
    clouds = source()
    clouds.add(cloud(11.0))
    assert clouds.know(rospy.Time(11.0), None)
    assert not clouds.know(rospy.Time(11.05), 11_050_000_000)
    assert clouds.know(rospy.Time(11.05), 12_100_000_000)
    clouds.add(cloud(1.0))  # the clock went back
    assert not clouds.know(rospy.Time(2.0), 1_000_000_000)


def test_only_the_last_clouds_are_kept():
    clouds = source()
    for index in range(cloud_source.KEPT + 1):
        clouds.add(cloud(11.0 + 0.05 * index))
    assert clouds.of(scan(11.0)) is None
    assert clouds.of(scan(11.05)) is not None


def test_scans_without_clouds_are_told():
    said = []
    clouds = source(said)
    assert clouds.of(scan(11.0)) is None
    assert said == ["Scans have no cloud of the same stamp; loops are closed by level scans alone there."]


def test_a_cloud_that_cannot_be_used_is_one_sentence():
    clouds = source()
    broken = cloud(11.0)
    broken.fields = broken.fields[:2]
    clouds.add(broken)
    with pytest.raises(ScanError, match="x, y and z"):
        clouds.of(scan(11.0))
    clouds.add(cloud(25.0))
    with pytest.raises(FrameError, match="TF knows no transform"):
        clouds.of(scan(25.0))
