"""The contract of the node position_controller with poses from odometry, seen from outside."""

import math
import unittest

import rospy
from dynamic_reconfigure.client import Client
from flight_basics_ros.testing import odometry_of
from geometry_msgs.msg import Pose, PoseStamped, TwistStamped
from nav_msgs.msg import Odometry
from std_msgs.msg import Bool

from node_tools.testing import Input, Output, Stamps, Warned, wait_until

NODE = "/control/position_controller"
DEFAULTS = {"max_speed": 2.0, "max_acceleration": 2.0, "braking_deceleration": 1.0}


def setpoint_at(x, y, z):
    pose = Pose()  # its orientation stays all zeros, as most people send it
    pose.position.x, pose.position.y, pose.position.z = x, y, z
    return pose


class PositionControllerTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.poses = Input("control/odometry", Odometry)
        cls.setpoints = Input("control/pos_setpoint", Pose)
        cls.commands = Output("control/vel_setpoint_out", TwistStamped)
        cls.reached = Output("control/goal_reached", Bool)
        cls.goals = Output(NODE + "/goal", PoseStamped)
        cls.warned = Warned(NODE)
        cls.client = Client(NODE, timeout=200.0)
        cls.stamps = Stamps()
        cls.without_setpoint = cls.answer(cls)
        cls.reached_at_first = cls.reached.next().data

    def setUp(self):
        self.client.update_configuration(DEFAULTS)

    def answer(self, position=(0.0, 0.0, 2.0), yaw=0.0, **frames):
        self.poses.send(odometry_of(self.stamps.next(0.01), position, yaw, **frames))
        return self.commands.next()

    def go_to(self, x, y, z):
        self.setpoints.send(setpoint_at(x, y, z))
        return self.goals.next()

    def test_hovers_without_a_setpoint(self):
        linear = self.without_setpoint.twist.linear
        self.assertEqual((linear.x, linear.y, linear.z), (0.0, 0.0, 0.0))
        self.assertFalse(self.reached_at_first)

    def test_one_command_per_pose_with_its_stamp_in_the_body_frame(self):
        self.go_to(40.0, 0.0, 2.0)
        for _ in range(150):
            stamp = self.stamps.next(0.01)
            self.poses.send(odometry_of(stamp, yaw=math.pi / 2.0))
            command = self.commands.next()
            self.assertEqual(command.header.stamp, stamp)
            self.assertEqual(command.header.frame_id, "base_frame")
        linear = command.twist.linear
        for value, expected in ((linear.x, 0.0), (linear.y, -2.0), (linear.z, 0.0)):
            self.assertAlmostEqual(value, expected, places=9)
        self.assertEqual(self.commands.messages, [])

    def test_shows_its_goal(self):
        goal = self.go_to(3.0, 4.0, 5.0)
        self.assertEqual(goal.header.frame_id, "odom")
        position = goal.pose.position
        self.assertEqual((position.x, position.y, position.z), (3.0, 4.0, 5.0))
        self.assertEqual(goal.pose.orientation.w, 1.0)
        late = Output(NODE + "/goal", PoseStamped)  # latched
        self.assertEqual(late.next().pose.position.x, 3.0)

    def test_goal_reached_is_latched_and_said_on_change_only(self):
        self.go_to(1.0, 2.0, 3.0)
        self.answer((0.0, 0.0, 0.0))
        rospy.sleep(0.3)
        self.reached.messages.clear()
        for _ in range(5):
            self.answer((1.0, 2.0, 3.1))
        self.assertTrue(self.reached.next().data)
        self.reached.assert_quiet()
        late = Output("control/goal_reached", Bool)
        self.assertTrue(late.next().data)
        self.go_to(9.0, 2.0, 3.0)
        self.answer((1.0, 2.0, 3.1))
        self.assertFalse(self.reached.next().data)

    def test_bad_poses_give_one_sentence_and_nothing_else(self):
        nan = odometry_of(self.stamps.next(0.01), (math.nan, 0.0, 0.0))
        zeros = odometry_of(self.stamps.next(0.01))
        zeros.pose.pose.orientation.w = zeros.pose.pose.orientation.z = 0.0
        elsewhere = odometry_of(self.stamps.next(0.01), frame="world")
        another = odometry_of(self.stamps.next(0.01), child="uav2/base_frame")
        cases = (
            (nan, "position that is not finite"),
            (odometry_of(self.stamps.next(0.01), (0.0, -1e7, 0.0)), "position beyond 1e+06 m"),
            (zeros, "quaternion is zero"),
            (elsewhere, '"base_frame" in "world", but "base_frame" in "odom"'),
            (another, 'frame "uav2/base_frame"'),
        )
        for pose, complaint in cases:
            self.poses.send(pose)
            self.warned.wait_for(complaint)
            self.poses.deliver(pose)
        self.commands.assert_quiet()
        for _, complaint in cases:
            self.assertEqual(self.warned.count(complaint), 1)
        self.answer()

    def test_a_bad_setpoint_leaves_the_last_one_in_force(self):
        self.go_to(40.0, 0.0, 2.0)
        self.setpoints.send(setpoint_at(math.nan, 0.0, 2.0))
        self.warned.wait_for("setpoint has a coordinate that is not finite")
        self.setpoints.send(setpoint_at(1e308, 0.0, 2.0))
        self.warned.wait_for("setpoint has a coordinate beyond 1e+06 m")
        self.goals.assert_quiet()
        for _ in range(150):
            command = self.answer()
        self.assertAlmostEqual(command.twist.linear.x, 2.0)

    def test_a_clock_that_jumps_back_starts_from_rest(self):
        self.go_to(40.0, 0.0, 2.0)
        for _ in range(150):
            self.answer()
        self.stamps = Stamps(start_s=5.0)
        self.assertEqual(self.answer().twist.linear.x, 0.0)
        self.assertAlmostEqual(self.answer().twist.linear.x, 2.0 * 0.01)
        self.warned.wait_for("clock jumped back")

    def test_live_parameters(self):
        self.go_to(40.0, 0.0, 2.0)
        self.client.update_configuration({"max_speed": 0.5})
        for _ in range(150):
            command = self.answer()
        self.assertAlmostEqual(command.twist.linear.x, 0.5)

    def test_braking_harder_than_accelerating_is_refused(self):
        kept = self.client.update_configuration({"max_acceleration": 0.5})
        self.assertEqual(kept["max_acceleration"], 2.0)
        self.warned.wait_for("lower the one or raise the other")
        wait_until(lambda: rospy.get_param(NODE + "/max_acceleration") == 2.0, "the old value")
