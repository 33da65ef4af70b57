"""What a change of the lidar during a run is called."""

import pytest

rospy = pytest.importorskip("rospy", reason="needs ROS")
scan_source = pytest.importorskip(
    "gridslam_ros.scan_source", reason="the workspace is not built, or not sourced"
)
from gridslam_ros.frames.odometry_frames import EarlyScanError, FrameError, OdometryFrames  # noqa: E402
from slam_probe import room_scan, transform  # noqa: E402


def said_of(lidars):
    """What is said of scans that come from these lidars (frame and beams), one after the other."""
    said = []
    frames = OdometryFrames("odom", "base_link", said.append)
    for frame in {frame for frame, _ in lidars}:
        frames.add(transform("base_link", frame, rospy.Time(0)).transforms, static=True)
    source = scan_source.ScanSource(frames, said.append)
    for index, (frame, beams) in enumerate(lidars):
        stamp = rospy.Time(10 + index)
        frames.add(transform("odom", "base_link", stamp).transforms)
        source.planar(room_scan(stamp, (0.0, 0.0, 0.0), frame=frame, beams=beams))
    return said


def test_another_lidar_is_told_once():
    said = said_of([("front", 360)] * 3 + [("rear", 180)] * 3)
    assert len(said) == 1
    assert 'changed from 360 beams in "front" to 180 beams in "rear"' in said[0]


def test_two_lidars_on_one_topic_are_told_as_such():
    said = said_of([("front", 360), ("rear", 360)] * 4)
    assert 'Scans of 360 beams in "front" and of 360 beams in "rear" come in turns' in said[-1]


def test_a_scan_before_all_odometry_is_told_apart_from_one_that_odometry_leaves_out():
    frames = OdometryFrames("odom", "base_link", lambda sentence: None)
    frames.add(transform("base_link", "lidar", rospy.Time(0)).transforms, static=True)
    frames.add(transform("odom", "base_link", rospy.Time(10)).transforms)
    with pytest.raises(EarlyScanError):
        frames.look_up(room_scan(rospy.Time(9.97), (0.0, 0.0, 0.0), frame="lidar"))
    with pytest.raises(FrameError) as late:
        frames.look_up(room_scan(rospy.Time(11), (0.0, 0.0, 0.0), frame="lidar"))
    assert not isinstance(late.value, EarlyScanError)


def test_a_scan_waits_for_its_odometry_also_when_the_odometry_began_at_time_zero():
    # Given a simulation that begins at 0: TF's "newest time" is then 0, as if all transforms were static
    frames = OdometryFrames("odom", "base_link", lambda sentence: None)
    frames.add(transform("base_link", "lidar", rospy.Time(0)).transforms, static=True)
    frames.add(transform("odom", "base_link", rospy.Time(0)).transforms)
    first, second = (room_scan(rospy.Time(at_s), (0.0, 0.0, 0.0), frame="lidar") for at_s in (0.0, 0.028))
    # Then the second scan waits until its odometry has come
    assert frames.know(first)
    assert not frames.know(second)
    frames.add(transform("odom", "base_link", rospy.Time(0.028)).transforms)
    assert frames.know(second)
    frames.look_up(second)


def test_static_odometry_holds_at_any_time():
    frames = OdometryFrames("odom", "base_link", lambda sentence: None)
    for edge in (("odom", "base_link"), ("base_link", "lidar")):
        frames.add(transform(*edge, rospy.Time(0)).transforms, static=True)
    assert frames.know(room_scan(rospy.Time(9.0), (0.0, 0.0, 0.0), frame="lidar"))
