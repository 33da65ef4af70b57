"""The order in which the lidar odometry gets its messages does not depend on which came first."""

from __future__ import annotations

import math

import numpy as np
import pytest
import rospy
from geometry_msgs.msg import Quaternion, Vector3
from gridslam_ros.frames.odometry_frames import FrameError
from gridslam_ros.odometry.feed import OdometryFeed
from gridslam_ros.odometry.messages import odometry_message, transform_of
from hypothesis import given, settings
from hypothesis import strategies as st
from sensor_msgs.msg import Imu, LaserScan, PointCloud2, PointField, Range
from std_msgs.msg import Header

from gridslam.cloud_odometry import CloudOdometry
from gridslam.odometry import LidarOdometry

BEAMS = 90
MOUNTS = {
    "lidar": ((0.0, 0.0, 0.1), (0.0, 0.0, 0.0, 1.0)),
    "finder": ((0.0, 0.0, -0.05), (0.0, math.sqrt(0.5), 0.0, math.sqrt(0.5))),
}


class Bench:
    def __init__(self, first_range_m=1.0):
        self.estimates, self.said = [], []
        odometry = LidarOdometry(say=self.said.append)
        self.stamps = []
        self.feed = OdometryFeed(odometry, self._mount, 0.0205, self._take, self.said.append)
        if first_range_m is not None:
            self.range(0.0, first_range_m)

    def _take(self, stamp, estimate):
        self.stamps.append(stamp)
        self.estimates.append(estimate)

    @staticmethod
    def _mount(frame):
        if frame not in MOUNTS:
            raise FrameError(f'TF knows no transform from "{frame}" to "base_frame".')
        return MOUNTS[frame]

    def scan(self, stamp_s, frame="lidar", ranges=None, range_max=10.0):
        angles = -math.pi + math.tau / BEAMS * np.arange(BEAMS)
        walls = 2.0 / np.maximum(np.abs(np.cos(angles)), np.abs(np.sin(angles)))
        self.feed.on_scan(
            LaserScan(
                header=_header(stamp_s, frame),
                angle_min=-math.pi,
                angle_increment=math.tau / BEAMS,
                range_min=0.1,
                range_max=range_max,
                ranges=walls if ranges is None else ranges,
            )
        )

    def imu(self, stamp_s, orientation=(0.0, 0.0, 0.0, 1.0), force=(0.0, 0.0, 9.80665)):
        message = Imu(header=_header(stamp_s, "base_link"), orientation=Quaternion(*orientation))
        message.linear_acceleration = Vector3(*(force or (0.0, 0.0, 0.0)))
        if force is None:
            message.linear_acceleration_covariance = [-1.0] + 8 * [0.0]
        self.feed.on_imu(message)

    def range(self, stamp_s, range_m, frame="finder"):
        self.feed.on_range(
            Range(header=_header(stamp_s, frame), min_range=0.05, max_range=40.0, range=range_m)
        )


def _header(stamp_s, frame):
    return Header(stamp=rospy.Time(0, round(1e9 * stamp_s)), frame_id=frame)


def test_a_scan_waits_for_the_imu_but_not_for_a_silent_one():
    bench = Bench()
    bench.scan(0.0)
    assert not bench.estimates
    bench.imu(1.0)
    assert len(bench.estimates) == 1
    bench.scan(1.05)
    assert len(bench.estimates) == 1
    bench.imu(1.04)
    assert [stamp.to_sec() for stamp in bench.stamps] == [0.0, 1.05]
    bench.scan(1.5)  # the IMU is silent
    assert len(bench.estimates) == 3
    assert "IMU is silent" in bench.said[-1]


def test_the_next_scan_ends_the_wait_of_the_one_before():
    bench = Bench()
    bench.imu(1.0)
    bench.scan(1.05)
    bench.scan(1.10)
    assert [stamp.to_sec() for stamp in bench.stamps] == [1.05]


def test_a_scan_that_comes_again_gets_the_same_answer_with_its_exact_stamp():
    # A simulator in lockstep sends a scan until it is answered. 2.252 s is not a whole number of nanoseconds
    # as a float.
    bench = Bench()
    for _ in range(2):
        bench.scan(2.252)
        bench.range(2.252, 1.0)
    bench.imu(2.252)
    bench.scan(2.252)
    assert bench.estimates[0] is bench.estimates[1]
    assert bench.stamps[0].to_nsec() == bench.stamps[1].to_nsec() == 2_252_000_000
    assert not bench.said  # the first range may come a little after the first scan


def test_clouds_that_are_bent_by_the_motion_are_told_once():
    """The IMU turns at 1 rad/s, and a cloud takes 0.1 s: 1 m at a distance of 10 m."""
    said = []
    feed = OdometryFeed(CloudOdometry(), Bench._mount, 0.0205, lambda *_: None, said.append)
    directions = np.random.default_rng(1).normal(size=(2000, 3))
    walls = (3.0 / np.abs(directions).max(axis=1))[:, None] * directions
    rows = np.zeros(2000, [("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("t", "<u4")])
    rows["t"] = np.linspace(0, 1e8, 2000)
    names = [*((name, PointField.FLOAT32) for name in "xyz"), ("t", PointField.UINT32)]
    for number in range(5):
        stamp_s, yaw = 0.1 * number, 0.1 * number
        turn = np.array(((math.cos(yaw), math.sin(yaw)), (-math.sin(yaw), math.cos(yaw))))
        rows["x"], rows["y"] = turn @ walls[:, :2].T
        rows["z"] = walls[:, 2]
        for step in range(5):
            imu = Imu(header=_header(stamp_s + 0.02 * step, "base_link"), orientation=Quaternion(0, 0, 0, 1))
            imu.linear_acceleration, imu.angular_velocity = Vector3(0, 0, 9.80665), Vector3(0, 0, 1)
            feed.on_imu(imu)
        cloud = PointCloud2(header=_header(stamp_s, "lidar"), height=1, width=2000, point_step=16)
        cloud.fields = [PointField(name, 4 * k, kind, 1) for k, (name, kind) in enumerate(names)]
        cloud.data, cloud.row_step = rows.tobytes(), 32000
        feed.on_cloud(cloud)
    told = [sentence for sentence in said if "field t" in sentence]
    assert len(told) == 1
    assert "1 m off at 10 m" in told[0]


def test_an_imu_that_never_comes_holds_up_the_first_scan_only():
    bench = Bench()
    bench.scan(1.0)
    for stamp_s in (1.1, 1.2):
        bench.scan(stamp_s)
    assert [stamp.to_sec() for stamp in bench.stamps] == [1.0, 1.1, 1.2]


def test_a_later_reading_of_the_imu_does_not_count_whenever_it_comes():
    leans = []
    for comes_first in (True, False):
        bench = Bench()
        bench.imu(1.0)
        if comes_first:
            bench.imu(1.02, orientation=(0.1, 0.0, 0.0, math.sqrt(0.99)))
        bench.scan(1.02)
        leans.append(bench.estimates[0].roll_pitch_yaw)
    assert leans[0] == leans[1]


def test_an_overdue_range_holds_a_scan_but_a_silent_finder_does_not():
    bench = Bench(first_range_m=None)
    bench.imu(0.0)
    bench.scan(0.0)
    assert not bench.estimates  # the first scan waits for the range finder
    for k in range(12):
        bench.range(0.05 * k, 1.0)
        bench.imu(0.05 * k + 0.02)
        bench.scan(0.05 * k + 0.03)
    bench.imu(0.604)
    bench.scan(0.604)  # the range of 0.60 s is due, but that of 0.55 s is young enough
    assert len(bench.estimates) == 14
    bench.imu(0.63)
    bench.scan(0.63)
    assert len(bench.estimates) == 14
    bench.range(0.60, 1.0)
    assert len(bench.estimates) == 15
    bench.imu(1.0)
    bench.scan(1.0)
    assert len(bench.estimates) == 16


def heights(delays_s):
    """Send 1 s of a flight that climbs and sinks, as a simulator in lockstep does. Return all heights.

    delays_s: of the readings and ranges. A scan comes when the one before it is answered.
    """
    times_s = [0.004 * math.ceil(round(0.05 * k / 0.004, 6)) for k in range(20)]
    ranges = [(t, "range", (t, 1.0 + 0.3 * math.sin(4.0 * t))) for t in times_s]
    readings = [(0.02 * k, "imu", (0.02 * k,)) for k in range(50)]
    late = {"range": 0.0, "imu": 0.0}
    coming = []
    for (stamp_s, what, sent), delay_s in zip(sorted(ranges + readings), delays_s):
        late[what] = max(late[what], stamp_s + delay_s)  # each connection keeps its order
        coming.append((late[what], what, sent))
    coming.sort(key=lambda each: each[0])
    bench = Bench(first_range_m=None)
    for k in range(38):
        scan_s = 0.004 * math.ceil(round(0.025 * k / 0.004, 6))
        while coming and (coming[0][0] <= scan_s or len(bench.estimates) < k):
            _, what, sent = coming.pop(0)
            getattr(bench, what)(*sent)
        bench.scan(scan_s)
    for _, what, sent in coming:
        getattr(bench, what)(*sent)
    return [e.position_xyz[2] for e in bench.estimates]


IN_TIME = heights(70 * [0.0])


@given(st.lists(st.sampled_from((0.0, 0.001, 0.03, 0.1)), min_size=70, max_size=70))
@settings(max_examples=8)
def test_the_order_of_arrival_changes_nothing(delays_s):
    assert heights(delays_s) == IN_TIME


def test_the_force_of_the_first_instant_does_not_count():
    # A simulator in lockstep repeats the first instant. MAVROS may know the force in the first message or not
    places = []
    for force in ((1.0, 0.0, 9.80665), None):
        bench = Bench()
        bench.scan(0.0)
        bench.imu(0.0, force=force)
        bench.imu(0.0)
        bench.imu(0.02)
        bench.scan(0.028)
        places.append(bench.estimates[-1].position_xyz)
    assert len(bench.estimates) == 2
    assert places[0] == places[1]


def test_bad_messages_get_one_sentence_and_change_nothing():
    bench = Bench()
    bench.imu(0.0, orientation=(0.0, 0.0, 0.0, 0.0))
    assert "norm" in bench.said[-1]
    bench.imu(0.0, orientation=(math.nan, 0.0, 0.0, 1.0))
    assert "not finite" in bench.said[-1]
    bench.imu(1.0)
    bench.scan(1.0, frame="moon")
    assert '"moon"' in bench.said[-1]
    bench.imu(1.1)
    bench.scan(1.1, range_max=-1.0)
    assert "range_max -1" in bench.said[-1]
    assert bench.estimates == []
    bench.range(1.0, math.nan)
    bench.range(1.0, 1.0, frame="moon")
    bench.imu(1.2, force=None)
    bench.scan(1.2)
    assert len(bench.estimates) == 1
    assert not any("\n" in str(sentence) for sentence in bench.said)


def test_a_message_holds_the_estimate():
    bench = Bench()
    roll, pitch = 0.1, -0.2
    cr, sr, cp, sp = math.cos(roll / 2), math.sin(roll / 2), math.cos(pitch / 2), math.sin(pitch / 2)
    leaning = (cp * sr, sp * cr, -sp * sr, cp * cr)
    bench.imu(0.0, leaning)
    bench.scan(0.0)
    message = odometry_message(bench.stamps[0], bench.estimates[0], "odom", "base_frame")
    orientation = message.pose.pose.orientation
    found = (orientation.x, orientation.y, orientation.z, orientation.w)
    assert found == pytest.approx(leaning, abs=1e-9)  # yaw 0 at the start
    matched = odometry_message(bench.stamps[0], bench.estimates[0], "odom", "base_frame", matched=True)
    assert matched.pose.covariance == bench.estimates[0].matched_covariance.ravel().tolist()
    assert (message.header.frame_id, message.child_frame_id) == ("odom", "base_frame")
    assert len(message.pose.covariance) == len(message.twist.covariance) == 36
    edge = transform_of(message)
    assert edge.transform.rotation == orientation
    assert (edge.header, edge.child_frame_id) == (message.header, "base_frame")


def cloud_message(stamp_s, points):
    fields = [PointField(name, 4 * i, PointField.FLOAT32, 1) for i, name in enumerate("xyz")]
    data = np.asarray(points, "<f4").tobytes()
    size = {"height": 1, "width": len(points), "point_step": 12, "row_step": 12 * len(points)}
    return PointCloud2(header=_header(stamp_s, "lidar"), fields=fields, data=data, **size)


def test_clouds_get_estimates_of_their_own_stamps_and_a_bad_one_a_sentence():
    estimates, said = [], []
    odometry = CloudOdometry(say=said.append)
    take = lambda stamp, estimate: estimates.append((stamp.to_sec(), estimate))  # noqa: E731
    feed = OdometryFeed(odometry, lambda frame: MOUNTS[frame], 0.0205, take, said.append)
    rng = np.random.default_rng(1)
    walls = rng.uniform(-2.1, 2.1, (4000, 3))
    walls[np.arange(4000), np.arange(4000) % 3] = 2.1 * rng.choice((-1.0, 1.0), 4000)
    for tick in range(5):
        stamp_s = 0.1 * tick
        feed.on_imu(Imu(header=_header(stamp_s, "base_link"), orientation=Quaternion(0.0, 0.0, 0.0, 1.0)))
        feed.on_range(Range(header=_header(stamp_s, "finder"), min_range=0.05, max_range=40.0, range=2.05))
        message = cloud_message(stamp_s, walls - (0.02 * max(tick - 1, 0), 0.0, 0.0))
        if tick == 3:
            message.data = message.data[:-5]
        feed.on_cloud(message)
    assert [stamp_s for stamp_s, _ in estimates] == pytest.approx([0.0, 0.1, 0.2, 0.4])
    assert estimates[-1][1].position_xyz[:2] == pytest.approx((0.06, 0.0), abs=0.01)
    assert [words for words in said if "bytes" in words and words.endswith("The cloud is left out.")]


def fly(bench, seconds, steps_s):
    """Fly along x at 0.5 m/s in a room of 8 x 8 m; return by how much each estimate is off, m.

    steps_s: by how much the clock of (IMU, range finder, lidar) is ahead, by the time of flight.
    """
    off_m = []
    for k in range(round(seconds / 0.01)):
        now_s = 0.01 * k
        of_imu_s, of_finder_s, of_lidar_s = steps_s(now_s)
        if k % 2 == 0:
            bench.imu(100.0 + now_s + of_imu_s)
        if k % 5 == 0:
            bench.range(100.0 + now_s + of_finder_s, 1.0)
        if k % 5 == 1:
            x_m = 0.5 * now_s - 1.0
            told = len(bench.estimates)
            bench.scan(100.0 + now_s + of_lidar_s, ranges=_walls(x_m))
            off_m += [abs(each.position_xyz[0] - 1.0 - x_m) for each in bench.estimates[told:]]
    return off_m


def _walls(x_m):
    angles = -math.pi + math.tau / BEAMS * np.arange(BEAMS)
    ahead = np.where(np.cos(angles) > 0.0, 4.0 - x_m, 4.0 + x_m) / np.maximum(np.abs(np.cos(angles)), 1e-9)
    return np.minimum(ahead, 4.0 / np.maximum(np.abs(np.sin(angles)), 1e-9))


@pytest.mark.parametrize("step_s", [0.0, 1.0, 600.0, 31_536_000.0])
@pytest.mark.parametrize("late_s", [(0.0, 0.0, 0.0), (0.1, 0.1, 0.0), (0.0, 0.1, 0.1), (0.0, 0.0, 0.1)])
def test_a_clock_that_is_set_ahead_moves_nothing(step_s, late_s):
    # Given a UAV that flies; when the clocks of IMU, range finder and lidar are set, one after the other
    bench = Bench(first_range_m=None)
    off_m = fly(bench, 4.0, lambda now_s: [step_s * (now_s >= 2.0 + late) for late in late_s])
    # Then the odometry goes on
    assert len(bench.estimates) > 75
    assert np.max(off_m) < 0.1
    heights_m = [each.position_xyz[2] for each in bench.estimates]
    assert np.ptp(heights_m) < 0.1
    assert not any("anew" in words for words in bench.said)
