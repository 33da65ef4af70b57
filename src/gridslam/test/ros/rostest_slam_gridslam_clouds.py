"""The node slam_gridslam with clouds: odometry that sinks is corrected in TF and on the path."""

import unittest

import numpy as np
import rospy
from gridslam_ros.volume import messages
from nav_msgs.msg import Path as PathMessage
from nav_msgs.srv import GetMap
from puck_in_a_room import cloud, heading, ranges_m
from sensor_msgs.msg import LaserScan, PointCloud2
from slam_probe import transform
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage

from node_tools.testing import Input, Output, Warned, wait_until

NODE = "/clouds/gridslam"
ROUNDS, STEP_M, RADIUS_M, HEIGHT_M = 5.2, 0.5, 2.0, 1.0
SUNK_M = 0.4
"""By odometry, from the start to the end."""
ASIDE_M = 1.0
"""Radius of a way that is new. Where five passes have mapped, scans that tell nothing new are not kept."""


def place_at(turn, radius_m=RADIUS_M):
    return np.array([4.0 + radius_m * np.cos(turn), 3.5 + radius_m * np.sin(turn), HEIGHT_M])


class SlamGridslamCloudsTest(unittest.TestCase):
    def setUp(self):
        self.processed = Output(NODE + "/processed", Header)
        self.paths = Output(NODE + "/path", PathMessage)
        self.tf = Output("clouds/tf", TFMessage)
        self.warned = Warned(NODE)
        self.scans, self.clouds = Input("clouds/scan", LaserScan), Input("clouds/cloud", PointCloud2)
        self.odometry = Input("clouds/tf", TFMessage)
        self.static = Input("clouds/tf_static", TFMessage, latch=True)
        self.static.send(transform("base_link", "laser", rospy.Time(0)))
        self.rng, self.now_s = np.random.default_rng(1), 1000.0

    def step(self, turn, told_m, points=None, with_cloud=True, radius_m=RADIUS_M):
        """Send odometry, cloud and scan of a place on a circle; returns the stamp."""
        self.now_s += 1.0
        stamp, yaw = rospy.Time.from_sec(self.now_s), turn + np.pi / 2
        place = place_at(turn, radius_m)
        self.odometry.send(transform("odom", "base_link", stamp, (*place[:2], yaw), z=told_m))
        if with_cloud:
            self.send_cloud(stamp, turn, points)
        bearings = np.linspace(-np.pi, np.pi, 360, endpoint=False)
        rays = np.column_stack((np.cos(bearings), np.sin(bearings), np.zeros(360)))
        scan = LaserScan(angle_min=-np.pi, angle_increment=np.pi / 180, range_min=0.1, range_max=20.0)
        scan.header, scan.ranges = (
            Header(stamp=stamp, frame_id="laser"),
            ranges_m(place, rays @ heading(yaw).T),
        )
        self.scans.send(scan)
        self.scan = scan
        return stamp

    def send_cloud(self, stamp, turn, points=None):
        seen = cloud(place_at(turn), heading(turn + np.pi / 2), self.rng) if points is None else points
        self.clouds.send(messages.cloud_of(seen, Header(stamp=stamp, frame_id="laser")))

    def wait_for_processed(self, stamp):
        wait_until(lambda: stamp in [each.stamp for each in self.processed.messages], f"processed {stamp}")

    def risen_m(self):
        """z of the newest map -> odom."""
        edges = [edge for message in self.tf.messages for edge in message.transforms]
        return next(e.transform.translation.z for e in reversed(edges) if e.child_frame_id == "odom")

    def test_odometry_that_sinks_is_risen_again_where_the_start_is_seen_again(self):
        # the first scan, which lockstep repeats, is answered when clouds are heard
        first = self.step(0.0, HEIGHT_M, with_cloud=False)
        self.scans.send(self.scan)
        self.processed.assert_quiet()
        self.send_cloud(first, 0.0)
        self.wait_for_processed(first)
        turns = np.arange(0.0, ROUNDS * 2 * np.pi, STEP_M / RADIUS_M)
        for turn in turns:
            told_m = HEIGHT_M - SUNK_M * turn / turns[-1]
            self.wait_for_processed(self.step(turn, told_m))
        self.assertGreater(self.risen_m(), 0.5 * SUNK_M)
        self.assertLess(self.risen_m(), 1.2 * SUNK_M)
        # the path's heights are the true ones again
        rospy.ServiceProxy("clouds/dynamic_map", GetMap)()  # publishes the path, too
        stamp = rospy.Time.from_sec(self.now_s - 2.0)
        path = self.paths.last(lambda path: path.poses and path.header.stamp > stamp, "the newest path")
        heights_m = np.array([each.pose.position.z for each in path.poses])
        self.assertLess(np.abs(heights_m - HEIGHT_M).max(), 0.5 * SUNK_M)
        # a cloud that makes no sense is one sentence, and the scan counts; so does a scan without a cloud
        step = self.step(turns[-1] + 0.3, told_m, points=np.zeros((0, 3)), radius_m=ASIDE_M)
        self.wait_for_processed(step)
        stamp = self.step(turns[-1] + 1.3, told_m, with_cloud=False, radius_m=ASIDE_M)
        self.odometry.send(transform("odom", "base_link", stamp + rospy.Duration(2.0), z=told_m))
        self.wait_for_processed(stamp)
        self.warned.wait_for("Scans have no cloud of the same stamp")
