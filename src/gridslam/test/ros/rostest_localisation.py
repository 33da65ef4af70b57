"""What slam_gridslam says about where it is: ~state, /diagnostics, and what it does with initialpose."""

import itertools
import math
import unittest

import numpy as np
import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseArray, PoseWithCovarianceStamped
from planar_world import Lidar, along, rectangle_route, scan_at
from rooms import WALLS
from sensor_msgs.msg import LaserScan
from slam_probe import transform
from std_msgs.msg import Header, String
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker

from gridslam import se2
from node_tools.testing import Input, Output, Warned, wait_until

NODE = "/localisation/gridslam"
LIDAR = Lidar(math.radians(270.0), 271, 10.0, 0.01, 10.0)
WAY = along(rectangle_route(2.0, 1.5, 0.5), 0.3)


class LocalisationTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.processed = Output(NODE + "/processed", Header)
        cls.states = Output(NODE + "/state", String)
        cls.diagnostics = Output("localisation/diagnostics", DiagnosticArray)
        cls.particles = Output(NODE + "/particles", PoseArray)
        cls.warned = Warned(NODE)
        cls.scans = Input("localisation/scan", LaserScan)
        cls.odometry = Input("localisation/tf", TFMessage)
        cls.given = Input("localisation/initialpose", PoseWithCovarianceStamped)
        cls.static = Input("localisation/tf_static", TFMessage, latch=True)
        cls.static.send(transform("base_link", "laser", rospy.Time(0)))
        cls.starts_s = itertools.count(100_000.0, -1000.0)

    def setUp(self):
        """Each test begins with a map of the room, made anew, since the clock goes back."""
        self.now_s = next(self.starts_s)
        self.rng = np.random.default_rng(0)
        self.odom_in_map = np.zeros(3)
        for pose in WAY:
            self.step(pose)
        self.warned.sentences.clear()
        self.states.last(lambda state: state.data == "tracking", "tracking at first")
        self.states.messages.clear()

    def step(self, pose):
        """Send the odometry and the scan of a true pose; wait until SLAM has seen it."""
        self.now_s += 0.5
        stamp = rospy.Time.from_sec(self.now_s)
        ranges = scan_at(WALLS, pose, LIDAR, self.rng).ranges_m
        step_rad = LIDAR.fov_rad / (LIDAR.beams - 1)
        scan = LaserScan(range_min=0.02, range_max=LIDAR.range_m, ranges=ranges, angle_increment=step_rad)
        scan.header.stamp, scan.header.frame_id, scan.angle_min = stamp, "laser", -LIDAR.fov_rad / 2
        in_odom = se2.between(self.odom_in_map, pose)
        self.odometry.send(transform("odom", "base_link", stamp, in_odom.tolist()))
        self.scans.send(scan)
        wait_until(lambda: stamp in [each.stamp for each in self.processed.messages], f"processed {stamp}")

    def carry(self, before, after):
        """Carry the vehicle from a pose to another one, which odometry does not see."""
        self.odom_in_map = se2.compose(after, se2.inverse(se2.between(self.odom_in_map, before)))

    def give(self, x, y, yaw, frame="map", variances=(0.04, 0.04, 0.02)):
        message = PoseWithCovarianceStamped()
        message.header.frame_id = frame
        pose = message.pose.pose
        pose.position.x, pose.position.y = x, y
        pose.orientation.z, pose.orientation.w = math.sin(yaw / 2.0), math.cos(yaw / 2.0)
        covariance = np.zeros((6, 6))
        covariance[[0, 1, 5], [0, 1, 5]] = variances
        message.pose.covariance = covariance.ravel().tolist()
        self.given.send(message)

    def status(self, level, word):
        return self.diagnostics.last(
            lambda array: (array.status[0].level, word in array.status[0].message) == (level, True), word
        ).status[0]

    def wait_for_state(self, word):
        self.states.last(lambda state: state.data == word, word)

    def test_tracking_is_said_with_numbers_and_to_latecomers(self):
        self.assertEqual(Output(NODE + "/state", String).last(lambda state: True, "it").data, "tracking")
        marker = Output(NODE + "/state_marker", Marker).last(lambda marker: True, "a marker")
        self.assertEqual((marker.text, marker.header.frame_id), ("tracking", "base_link"))
        status = self.status(DiagnosticStatus.OK, "tracking")
        self.assertEqual(status.name, "localisation/gridslam: localisation")
        numbers = {each.key: each.value for each in status.values}
        self.assertGreater(float(numbers["beams that agree with the map (share)"]), 0.9)
        self.assertLess(float(numbers["spread of the particles (m)"]), 0.1)
        self.assertEqual(float(numbers["scans since tracking"]), 0.0)

    def test_a_vehicle_that_was_carried_is_lost_aloud_and_found_again(self):
        self.carry(WAY[-1], WAY[8])
        for pose in WAY[8:]:
            self.step(pose)
        self.wait_for_state("tracking")
        said = [state.data for state in self.states.messages]
        self.assertEqual(said, ["uncertain", "lost", "uncertain", "tracking"])
        self.warned.wait_for("The vehicle is lost: 3 scans in a row contradict the map")
        self.warned.wait_for("The vehicle is found again at")
        self.assert_particles_at(WAY[-1])

    def assert_particles_at(self, pose):
        def are_there(poses):
            place = poses.poses[0].position
            return math.hypot(place.x - pose[0], place.y - pose[1]) < 0.4  # the last scan may wait for motion

        self.particles.last(are_there, f"particles at {pose}")

    def test_a_given_pose_is_taken(self):
        self.carry(WAY[-1], WAY[8])
        self.give(WAY[8][0] + 0.15, WAY[8][1] - 0.1, WAY[8][2] + 0.05)
        self.wait_for_state("uncertain")
        for pose in WAY[8:13]:
            self.step(pose)
        self.wait_for_state("tracking")
        self.assertNotIn("lost", [state.data for state in self.states.messages])
        self.assert_particles_at(WAY[12])

    def test_a_pose_that_makes_no_sense_is_ignored_in_a_sentence(self):
        for sentence, pose in {
            'must be in the frame "map", not in "odom". It is ignored.': (0.0, 0.0, 0.0, "odom"),
            "must have finite numbers. It is ignored.": (math.nan, 0.0, 0.0),
            "is outside the map": (700.0, 0.0, 0.0),
            "covariance must be symmetric": (0.0, 0.0, 0.0, "map", (0.1, -1.0, 0.1)),
            "covariance must be finite": (0.0, 0.0, 0.0, "map", (0.1, math.inf, 0.1)),
        }.items():
            self.give(*pose)
            self.warned.wait_for(sentence)
        self.assertEqual(self.states.messages, [])
