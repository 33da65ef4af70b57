"""What is let in: scans in order, strays left out, and a clock that has gone back told from a stray."""

import math

import pytest

rospy = pytest.importorskip("rospy", reason="needs ROS")
intake = pytest.importorskip("gridslam_ros.intake", reason="the workspace is not built, or not sourced")
odometry_frames = pytest.importorskip("gridslam_ros.frames.odometry_frames")
transform = pytest.importorskip("slam_probe").transform
LaserScan = pytest.importorskip("sensor_msgs.msg").LaserScan


class Feed:
    """An intake with its odometry's frames, and all that it has done with what it got."""

    def __init__(self, throttle=1):
        self.said, self.let_in, self.left_out, self.begun = [], [], [], []
        self.frames = odometry_frames.OdometryFrames("odom", "base_link", self.said.append)
        self.frames.add(transform("base_link", "laser", rospy.Time(0)).transforms, static=True)
        self.intake = intake.Intake(
            self.frames,
            throttle,
            self.said.append,
            lambda scan: self.let_in.append(seconds_of(scan)),
            lambda scan: self.left_out.append(seconds_of(scan)),
            self.begin_anew,
        )

    def begin_anew(self, seconds):
        self.begun.append(seconds)
        self.let_in.clear()

    def scans(self, *stamps_s):
        for stamp_s in stamps_s:
            self.intake.add_scan(scan_at(stamp_s))

    def odometry(self, *stamps_s, pose=(0.0, 0.0, 0.0)):
        for stamp_s in stamps_s:
            edge = transform("odom", "base_link", rospy.Time.from_sec(stamp_s), pose)
            self.intake.add_transforms(edge.transforms)

    def both(self, *stamps_s):
        for stamp_s in stamps_s:
            self.odometry(stamp_s)
            self.scans(stamp_s)

    def knows(self, stamp_s):
        return self.frames.know(scan_at(stamp_s))


def seconds_of(scan):
    return round(scan.header.stamp.to_sec(), 6)


def scan_at(stamp_s, frame="laser"):
    scan = LaserScan()
    scan.header.stamp, scan.header.frame_id = rospy.Time.from_sec(stamp_s), frame
    return scan


def test_scans_in_order_are_let_in_and_others_left_out():
    feed = Feed()
    feed.both(100.0, 100.1, 100.3)
    feed.scans(100.2, 100.3, 100.4)
    assert feed.let_in == [100.0, 100.1, 100.3, 100.4]
    assert feed.left_out == [100.2, 100.3]
    assert feed.said == ["A scan is older than the one before it; it is left out."]  # not of the repeated one


def test_odometry_without_scans_is_told_once_a_silence():
    feed = Feed()
    feed.odometry(*range(100, 115))
    assert [sentence for sentence in feed.said if "without a scan" in sentence] == [
        "Odometry has come for 11 s without a scan; check the lidar and the scans' topic."
    ]
    # A pause of 30 s, and then one of 61 s, are less than three times the longest
    feed.both(115.0)
    feed.odometry(*range(116, 145))
    feed.both(145.0)
    feed.odometry(*range(146, 235))
    assert len(feed.said) == 1
    feed.odometry(236.0)
    assert len(feed.said) == 2


def test_one_of_three():
    feed = Feed(throttle=3)
    feed.scans(*range(9))
    assert feed.let_in == [2.0, 5.0, 8.0]
    assert len(feed.left_out) == 6
    assert feed.said == []


@pytest.mark.parametrize("stray_s", [0.0, 98.0])
def test_a_stray_does_not_end_a_map(stray_s):
    # Given a run, and in it one scan of another time: a driver's default message, say, and once more the same
    feed = Feed()
    feed.both(100.0, 100.1)
    feed.scans(stray_s, stray_s)
    feed.both(100.2, 100.3)
    # Then the run goes on
    assert feed.let_in == [100.0, 100.1, 100.2, 100.3]
    assert feed.left_out == [stray_s, stray_s]
    assert feed.begun == []
    assert feed.said == [f"A scan is {100.1 - stray_s:.3f} s older than the one before it; it is left out."]


def test_the_first_scan_after_a_reset_is_not_lost():
    orders = {
        "odometry first": lambda feed: feed.both(50.0, 50.1),
        "scan first": lambda feed: (feed.scans(50.0), feed.odometry(50.0), feed.scans(50.1)),
        "scans only": lambda feed: feed.scans(50.0, 50.1),
        "odometry much earlier": lambda feed: (feed.odometry(49.5, 49.6, 50.0), feed.scans(50.0, 50.1)),
    }
    for order, send in orders.items():
        feed = Feed()
        feed.both(100.0, 100.1)
        send(feed)
        assert feed.begun == [pytest.approx(50.1)], order
        assert feed.let_in == [50.0, 50.1], order
        assert feed.left_out == feed.said == [], order
        feed.odometry(50.2)
        assert feed.knows(50.2), order
        assert not feed.knows(50.3), order


def test_a_reset_in_lockstep_needs_no_second_scan():
    feed = Feed()
    feed.both(100.0, 0.0)
    assert feed.let_in == [0.0]
    feed = Feed()
    feed.both(100.0)
    feed.scans(0.0)
    assert feed.let_in == [100.0]
    feed.odometry(0.0)
    assert feed.let_in == [0.0]


def test_late_tf_is_no_reset():
    feed = Feed()
    feed.both(100.0)
    feed.scans(103.0, 104.0)
    feed.odometry(101.0, 102.0, 103.0, 104.0)
    assert (feed.begun, feed.let_in, feed.said) == ([], [100.0, 103.0, 104.0], [])


def test_a_stray_while_tf_is_late_does_not_end_a_map():
    feed = Feed()
    feed.both(100.0)
    feed.scans(103.0, 104.0, 100.5)
    feed.odometry(101.0, 102.0, 103.0, 104.0)
    feed.both(104.1)
    assert (feed.begun, feed.let_in) == ([], [100.0, 103.0, 104.0, 104.1])
    assert feed.left_out == [100.5]


def test_a_scan_from_the_future_does_not_count():
    feed = Feed()
    feed.both(100.0, 100.1)
    feed.scans(1e6)
    feed.both(100.2, 100.3)
    assert feed.let_in == [100.0, 100.1, 1e6, 100.2, 100.3]  # the stray waits in vain for TF
    assert feed.begun == []
    assert len(feed.said) == 1


@pytest.mark.parametrize("stray_s", [0.0, 50.0])
def test_a_stray_of_odometry_is_left_out(stray_s):
    feed = Feed()
    feed.both(100.0, 100.1)
    feed.odometry(stray_s)
    feed.both(100.2)
    assert feed.frames.resets == 0
    assert feed.knows(100.05)
    assert feed.said == ['TF "odom" -> "base_link" was of another time; it is left out.']


def test_what_tf2_would_complain_of_is_one_sentence_of_ours(capfd):
    feed = Feed()
    cases = {
        "came again": lambda: feed.odometry(100.0),
        "came again, or late": lambda: feed.odometry(99.9),
        "not a transform": lambda: feed.odometry(100.1, pose=(math.nan, 0.0, 0.0)),
        "not a transform: ": lambda: feed.odometry(100.1, pose=(0.0, 0.0, math.nan)),
    }
    feed.odometry(100.0)
    for words, send in cases.items():
        feed.said.clear()
        send()
        assert len(feed.said) == 1
        assert words in feed.said[0]
        assert '"odom" -> "base_link"' in feed.said[0]
    for changes in (
        {"child_frame_id": ""},
        {"child_frame_id": "odom_2", "frame": "odom_2"},
        {"norm": 0.9},
        {"norm": 1e200},
    ):
        feed.said.clear()
        edge = transform("base_link", "arm", rospy.Time(101)).transforms[0]
        edge.transform.rotation.w = changes.pop("norm", 1.0)
        edge.header.frame_id = changes.pop("frame", "base_link")
        edge.child_frame_id = changes.pop("child_frame_id", "arm")
        feed.intake.add_transforms([edge])
        assert len(feed.said) == 1
        assert "not a transform" in feed.said[0]
    feed.odometry(100.2)
    assert feed.knows(100.2)
    assert capfd.readouterr().err == ""
