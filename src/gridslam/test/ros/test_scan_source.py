"""What a change of the lidar during a run is called."""

import numpy as np
import pytest

rospy = pytest.importorskip("rospy", reason="needs ROS")
scan_source = pytest.importorskip(
    "gridslam_ros.scan_source", reason="the workspace is not built, or not sourced"
)
from gridslam_ros.frames.odometry_frames import EarlyScanError, FrameError, OdometryFrames  # noqa: E402
from slam_probe import room_scan, transform  # noqa: E402

from gridslam import se2  # noqa: E402


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


def test_beams_that_tell_range_max_have_met_nothing():
    """Else the ring of them turns with the UAV, and odometry's yaw is blamed."""
    said = []
    frames = OdometryFrames("odom", "base_link", said.append)
    frames.add(transform("base_link", "lidar", rospy.Time(0)).transforms, static=True)
    frames.add(transform("odom", "base_link", rospy.Time(10)).transforms)
    scan = room_scan(rospy.Time(10), (0.0, 0.0, 0.0), frame="lidar", beams=360)
    scan.range_max, scan.ranges = 8.0, np.where(np.arange(360) < 200, 2.0 + 0.01 * np.arange(360), 8.0)
    planar, _ = scan_source.ScanSource(frames, said.append).planar(scan)
    assert np.isposinf(planar.ranges_m).sum() == 160
    assert "range_max" in said[0]


def test_two_lidars_on_one_topic_are_told_as_such():
    said = said_of([("front", 360), ("rear", 360)] * 4)
    assert 'Scans of 360 beams in "front" and of 360 beams in "rear" come in turns' in said[-1]


@pytest.mark.parametrize(("beams", "words"), [(1, "has 1 beam:"), (9, "has 9 beams:"), (10, None)])
def test_scans_of_few_beams_are_told_once(beams, words):
    said = [sentence for sentence in said_of([("front", beams)] * 4) if "cannot be compared" in sentence]
    assert len(said) == (words is not None)
    assert words is None or words in said[0]


def test_odometry_of_other_times_is_told(monkeypatch):
    checked = iter(["", "Odometry turns late.", ""])
    monkeypatch.setattr(scan_source.ClockWatch, "check", lambda *_: next(checked))
    assert said_of([("front", 360)] * 3) == ["Odometry turns late."]


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


def turning(until_s, **changes):
    """The transforms of a base that turns by 1 rad from 10 s to 10.2 s, up to some time, and its scan."""
    frames = OdometryFrames("odom", "base_link", lambda sentence: None)
    frames.add(transform("base_link", "lidar", rospy.Time(0)).transforms, static=True)
    for at_s, yaw in ((10.0, 0.0), (10.2, 1.0)):
        if at_s <= until_s:
            frames.add(transform("odom", "base_link", rospy.Time(at_s), (0.0, 0.0, yaw)).transforms)
    return frames, room_scan(rospy.Time(10), (0.0, 0.0, 0.0), "lidar", beams=101, **changes)


def test_a_scan_waits_for_the_odometry_of_its_last_beam_which_straightens_it():
    told = {"time_increment": 0.001}
    assert not turning(10.0, **told)[0].know(turning(10.0, **told)[1])
    frames, scan = turning(10.2, **told)
    assert frames.know(scan)
    planar, base = scan_source.ScanSource(frames, print).planar(scan)
    as_measured = scan.angle_min + scan.angle_increment * np.arange(101)
    turned = np.abs(se2.wrap(planar.angles_rad - as_measured - np.linspace(0.0, 0.5, 101)))
    assert turned.max() < 1e-6
    assert base == pytest.approx((0.0, 0.0, 0.0))


@pytest.mark.parametrize("step_s", [0.0, -0.001, 0.1, float("nan")])
def test_beams_without_a_sensible_time_are_of_one_instant(step_s):
    frames, scan = turning(10.0, time_increment=step_s)
    assert frames.know(scan)
    planar, _ = scan_source.ScanSource(frames, print).planar(scan)
    np.testing.assert_allclose(planar.angles_rad, scan.angle_min + scan.angle_increment * np.arange(101))


def test_the_last_scan_of_a_bag_counts_as_of_one_instant():
    frames, scan = turning(10.0, time_increment=0.001)
    planar, _ = scan_source.ScanSource(frames, print).planar(scan)
    np.testing.assert_allclose(planar.angles_rad, scan.angle_min + scan.angle_increment * np.arange(101))
