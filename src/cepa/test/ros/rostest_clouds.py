"""The node cepa with clouds: what it answers, what it tells, and clouds that make no sense."""

import math
import unittest

import dynamic_reconfigure.client
import numpy as np
import rospy
from cepa_probe import Mounts, odometry_of, of_stamp, scan_of, velocity_of
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TransformStamped, TwistStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Imu, LaserScan, PointCloud2, PointField, Range
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import MarkerArray

from node_tools.testing import Input, Output, Stamps, Warned, wait_until

WALL_M = 1.7
HEIGHTS = np.radians(np.arange(-15.0, 15.1, 2.0))
AROUND = np.radians(np.arange(-180.0, 180.0, 2.0))


def top_of_path(picture):
    """The greatest height of a picture's predicted path, m; 0 without one."""
    paths = [marker.points for marker in picture.markers if marker.ns == "predicted path"]
    return max((point.z for points in paths for point in points), default=0.0)


def low_wall():
    """A Puck 2 m over a floor, 1.7 m before a wall of 1.9 m that goes on to both sides."""
    around, up = (angles.ravel() for angles in np.meshgrid(AROUND, HEIGHTS))
    along = np.stack([np.cos(up) * np.cos(around), np.cos(up) * np.sin(around), np.sin(up)], axis=1)
    with np.errstate(divide="ignore"):
        to_floor = np.where(along[:, 2] < 0.0, -2.0 / along[:, 2], math.inf)
        to_wall = np.where(along[:, 0] > 0.0, WALL_M / along[:, 0], math.inf)
    to_wall[to_wall * along[:, 2] > -0.1] = math.inf
    ranges = np.minimum(to_floor, to_wall)
    return along[ranges < 100.0] * ranges[ranges < 100.0, None]


def cloud_of(stamp, points, frame="base_frame", **changes):
    """A cloud of points (n, 3), m; ``changes`` replace what it says."""
    fields = [PointField(name, 4 * k, PointField.FLOAT32, 1) for k, name in enumerate("xyz")]
    cloud = PointCloud2(height=1, width=len(points), fields=fields, point_step=12, row_step=12 * len(points))
    cloud.header.stamp, cloud.header.frame_id = stamp, frame
    cloud.data = np.asarray(points, np.float32).tobytes()
    for name, value in changes.items():
        setattr(cloud, name, value)
    return cloud


class CloudsTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.client = dynamic_reconfigure.client.Client("/clouds/cepa", timeout=200.0)
        cls.client.update_configuration({"algorithm": "dynamic"})  # from now on it wants clouds
        cls.commands = Output("clouds/vel_setpoint_out", TwistStamped)
        cls.stats = Output("clouds/cepa/stats", DiagnosticArray)
        cls.decisions = Output("clouds/cepa/decision", MarkerArray)
        cls.remembered = Output("clouds/cepa/remembered", PointCloud2)
        cls.pictures = Output("clouds/cepa_visualiser/markers", MarkerArray)
        cls.scans = Input("clouds/scan_in", LaserScan)
        cls.references = Input("clouds/vel_setpoint_in", TwistStamped)
        cls.odometry = Input("clouds/odometry", Odometry)
        cls.clouds = Input("clouds/cloud", PointCloud2)
        cls.ranges_up = Input("clouds/range_finder_up", Range)
        cls.imu = Input("clouds/imu", Imu)
        cls.mounts = Mounts("clouds/tf_static")
        cls.mounts.add("base_frame", "up_link", pitch=-math.pi / 2)
        cls.warned = Warned("/clouds/cepa")
        cls.stamps = Stamps(100.0)

    def fly(self, points=None, stamp=None, v_ref=(1.0, 0.0, 0.0), **changes):
        """The command for one scan at 10 Hz, which sees nothing, and for its cloud."""
        stamp = stamp or self.stamps.next(0.1)
        is_answered_at_once = points is not None and not changes
        if points is not None:
            self.clouds.send(cloud_of(changes.pop("cloud_stamp", stamp), points, **changes))
        self.odometry.send(odometry_of(stamp, v_ref))
        self.references.send(velocity_of(stamp, v_ref))
        rospy.rostime.wallsleep(0.05)
        self.scans.send(scan_of(stamp))
        stamps = [stamp]
        # A further scan tells that no cloud will come. A node that is late hears only the newest scan.
        while not (is_answered_at_once or self.is_answered(*stamps)):
            stamps.append(self.stamps.next(1e-3))
            self.scans.send(scan_of(stamps[-1]))
        linear = of_stamp(self.commands, *stamps).twist.linear
        return np.array([linear.x, linear.y, linear.z])

    def is_answered(self, *stamps):
        """Whether the command for one of the scans comes within a moment."""
        return self.commands.holds(
            lambda message: message.header.stamp in stamps, 0.05 if len(stamps) == 1 else 0.3
        )

    def test_0_until_a_cloud_comes_the_scan_counts(self):
        np.testing.assert_allclose(self.fly(v_ref=(1.0, 0.0, 0.2)), (1.0, 0.0, 0.2))
        self.warned.wait_for("No cloud has come yet; the scan alone counts.")

    def climb(self, range_m, frame="up_link", **limits):
        """The climb that answers a wish for 0.5 m/s, after a range of the range finder that looks up."""
        stamp = self.stamps.next(0.1)
        message = Range(range=range_m, **{"min_range": 0.05, "max_range": 10.0, **limits})
        message.header.stamp, message.header.frame_id = stamp, frame
        self.ranges_up.send(message)
        return self.fly(stamp=stamp, v_ref=(0.0, 0.0, 0.5))[2]

    def test_1_range_finders_say_where_it_may_climb(self):
        wait_until(lambda: self.climb(0.4) < 0.1, "the range finder's place on the UAV")
        self.forget(80.0)
        self.assertGreater(self.climb(math.inf), 0.4)
        for sentence, wrong in (
            ("limits must fulfil", {"max_range": 0.01}),
            ("looks neither up nor down", {"frame": "base_frame"}),
        ):
            self.climb(8.0, **wrong)
            self.warned.wait_for(sentence)
        self.forget(50.0)

    def forget(self, now_s):
        """Make the clock jump back, so that the node forgets what it has seen."""
        type(self).stamps = Stamps(now_s)
        self.fly()

    def test_2_it_climbs_over_a_low_wall_and_tells_why(self):
        for output in (self.stats, self.decisions, self.remembered, self.pictures):
            output.messages.clear()
        for _ in range(3):
            answer = self.fly(low_wall())
        self.assertGreater(answer[2], 0.2)  # the scan sees nothing
        status = self.stats.last(
            lambda message: message.header.stamp.to_sec() > self.stamps.now_s - 0.05, "the newest answer"
        ).status[0]
        values = {pair.key: pair.value for pair in status.values}
        self.assertEqual(status.message, "steered")
        self.assertAlmostEqual(float(values["clearance_m"]), WALL_M - 0.35, delta=0.01)
        self.assertGreater(int(values["remembered"]), 100)
        self.assertGreater(int(values["admissible"]), 0)
        markers = {marker.ns: marker for marker in self.decisions.messages[-1].markers}
        path = markers["predicted path"].points
        self.assertGreater(path[-1].z, 0.2)
        self.assertLess(markers["braking path"].points[-1].x, WALL_M - 0.35)
        rows = np.frombuffer(self.remembered.messages[-1].data, np.float32).reshape(-1, 4)
        on_wall = rows[np.abs(rows[:, 0] - WALL_M) < 0.01]
        self.assertGreater(np.ptp(on_wall[:, 2]), 0.3)
        self.pictures.last(lambda message: top_of_path(message) > 0.2, "a picture of the climb")

    def test_3_clouds_that_make_no_sense_are_dropped_with_one_sentence_each(self):
        wall = low_wall()
        cases = {
            "has no fields x, y and z": {"fields": []},
            "fields do not fit into points of 8 bytes": {"point_step": 8},
            "bytes for 1 rows of": {"data": b"short"},
            "has no stamp": {"cloud_stamp": rospy.Time()},
            'from "nowhere"': {"frame": "nowhere"},
            "no valid point among": {"points": np.full((50, 3), math.nan), "frame": "base_frame"},
        }
        for sentence, changes in cases.items():
            for _ in range(2):
                answer = self.fly(**{"points": wall, **changes})
                self.assertLess(np.hypot(*answer[:2]), 1.01)
            self.warned.wait_for(sentence)
        for sentence in cases:
            self.assertEqual(self.warned.count(sentence), 1, sentence)
        partly = np.concatenate((wall, np.full((50, 3), math.nan)))
        self.assertGreater(self.fly(partly)[2], 0.2)
        self.assertEqual(self.warned.count("no valid point among"), 1)

    def test_3_a_cloud_that_does_not_tell_where_its_lidar_was_is_dropped(self):
        self.fly(low_wall(), frame="odom")  # now it listens to /tf
        tf = Input("clouds/tf", TFMessage)
        edge = TransformStamped(child_frame_id="base_frame")
        edge.header.frame_id, edge.transform.rotation.w = "odom", 1.0

        def is_told():
            edge.header.stamp = self.stamps.next(0.1)
            tf.send(TFMessage([edge]))
            self.fly(low_wall(), frame="odom")
            return self.warned.count('"odom" does not move with "base_frame"')

        wait_until(is_told, "a warning of the cloud's frame")

    def test_3_a_cloud_that_the_motion_bends_is_told(self):
        points = low_wall()
        rows = np.zeros((len(points), 4), np.float32)
        rows[:, :3], rows[:, 3] = points, np.linspace(-0.1, 0.0, len(points))
        fields = [
            PointField(name, 4 * k, PointField.FLOAT32, 1) for k, name in enumerate(("x", "y", "z", "time"))
        ]
        changes = {"fields": fields, "point_step": 16, "row_step": 16 * len(rows), "data": rows.tobytes()}
        for _ in range(2):
            self.fly(points, v_ref=(1.5, 0.0, 0.0), **changes)
        self.warned.wait_for("within 0.1 s (field time)")

    def test_4_without_clouds_it_flies_by_the_planar_scan_and_says_so_once(self):
        self.fly(low_wall())
        for _ in range(8):
            self.fly()
        sentence = "the UAV flies by the planar scan and by what clouds showed before"
        self.warned.wait_for(sentence)
        for _ in range(60):
            self.fly()
        self.assertEqual(self.warned.count(sentence), 1)
        self.fly(low_wall())
        self.warned.wait_for("Clouds come with the scans again.")

    def test_5_a_clock_that_jumps_back_is_survived(self):
        self.fly(low_wall())
        self.clouds.send(cloud_of(rospy.Time(40), low_wall()))
        self.assertGreater(self.fly(low_wall())[2], 0.2)
        type(self).stamps = Stamps(20.0)
        self.fly(low_wall())
        self.warned.wait_for("clock jumped back")
        wait_until(lambda: self.fly(low_wall())[2] > 0.2, "the next climb")

    def test_5_an_imu_that_is_silent_or_makes_no_sense_is_told_once(self):
        silence = "No reading of the IMU has come"
        for _ in range(11):
            self.fly(low_wall())
        self.warned.wait_for(silence)
        no_rates = Imu()
        no_rates.angular_velocity_covariance[0] = -1.0
        not_finite = Imu()
        not_finite.angular_velocity.z = math.nan
        for sentence, message in (("tells no rates", no_rates), ("rates are not finite", not_finite)):
            message.header.stamp = self.stamps.next(0.01)
            self.imu.send(message)
            self.warned.wait_for(sentence)
        self.fly(low_wall())
        self.assertEqual(self.warned.count(silence), 1)

    def test_6_an_algorithm_that_stays_level_comes_no_nearer_to_the_ceiling_than_r_lb(self):
        self.client.update_configuration({"algorithm": "improved", "r_lb": 0.5})
        self.warned.wait_for("improved knows neither keep-out boxes nor a ceiling")
        self.assertEqual(self.climb(0.45), 0.0)
        self.assertEqual(self.climb(8.0), 0.5)
        self.climb(math.nan)
        self.warned.wait_for("The range finder that looks up measures nothing (NaN); the UAV does not climb.")
