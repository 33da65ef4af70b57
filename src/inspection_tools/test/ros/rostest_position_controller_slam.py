"""The node position_controller with its poses from SLAM and from the ground truth."""

import math
import unittest

import rospy
from flight_basics_ros.testing import correction, odometry_of
from geometry_msgs.msg import Pose, PoseStamped, TwistStamped
from nav_msgs.msg import Odometry
from std_msgs.msg import Bool, String
from tf2_msgs.msg import TFMessage

from node_tools.conversions import xyz
from node_tools.testing import Input, Output, Stamps, Warned, wait_until

NODE = "/slam/position_controller"


class SlamTest(unittest.TestCase):
    def test_poses_are_corrected_by_slam_and_missed_while_there_is_none(self):
        poses, setpoints = Input("slam/odometry", Odometry), Input("slam/pos_setpoint", Pose)
        tf = Input("slam/tf", TFMessage)
        commands, goals = Output("slam/vel_setpoint_out", TwistStamped), Output(NODE + "/goal", PoseStamped)
        warned, stamps = Warned(NODE), Stamps()

        # Given a setpoint, and no SLAM yet
        setpoint = Pose()
        setpoint.position.x, setpoint.position.y, setpoint.position.z = 50.0, 0.0, 2.0
        setpoints.send(setpoint)
        self.assertEqual(goals.next().header.frame_id, "map")
        poses.send(odometry_of(stamps.next(0.01)))
        rospy.sleep(0.3)
        self.assertFalse(warned.count("Is SLAM running?"))  # it may still start
        wait_until(
            lambda: (
                poses.send(odometry_of(stamps.next(0.01)))
                or warned.count('no transform from "odom" to "map". Is SLAM running?')
            ),
            "the warning that SLAM is missing",
        )
        commands.assert_quiet()

        # When SLAM says that odom lies 10 m ahead in the map and is turned left by 90 degrees,
        # and a UAV at (-3, 40) in odom faces along odom's x
        tf.deliver(correction(stamps.next(0.01), 10.0, 0.0, math.pi / 2.0))
        stamps.next(0.2)  # a correction counts so long after its stamp
        for _ in range(200):
            stamp = stamps.next(0.01)
            poses.send(odometry_of(stamp, (-3.0, 37.0, 2.0)))
            command = commands.next()

        # Then it is at (10 - 37, -3) = (-27, -3) in the map and faces left: the goal lies 77 m to its right
        # and 3 m ahead, and the command bears the odometry's stamp although the correction is older
        self.assertEqual(command.header.stamp, stamp)
        linear = command.twist.linear
        self.assertAlmostEqual(math.hypot(linear.x, linear.y), 2.0)
        self.assertAlmostEqual(math.atan2(linear.y, linear.x), math.atan2(-77.0, 3.0), places=6)

        # And a later correction by 0.02 rad, which moves the UAV by 0.74 m, moves the goal slowly
        tf.deliver(correction(stamps.next(0.01), 10.0, 0.0, math.pi / 2.0 - 0.02))
        headings = []
        for _ in range(800):
            poses.send(odometry_of(stamps.next(0.01), (-3.0, 37.0, 2.0)))
            linear = commands.next().twist.linear
            headings.append(math.atan2(linear.y, linear.x))
        turn = [later - before for before, later in zip(headings, headings[1:])]
        self.assertLess(max(map(abs, turn)), 0.002)
        cos, sin = math.cos(0.02), math.sin(0.02)
        there = (10.0 - 37.0 * cos - 3.0 * sin, 37.0 * sin - 3.0 * cos)
        bearing = math.atan2(-there[1], 50.0 - there[0]) - (math.pi / 2.0 - 0.02)
        self.assertAlmostEqual(headings[-1], bearing, places=6)

        # And a correction does not count before 0.2 s have passed since its stamp
        tf.deliver(correction(stamps.next(0.01) + rospy.Duration(0.05), 0.0, 0.0, 0.0))
        for _ in range(20):
            poses.send(odometry_of(stamps.next(0.01), (-3.0, 37.0, 2.0)))
            linear = commands.next().twist.linear
        self.assertAlmostEqual(math.atan2(linear.y, linear.x), headings[-1], places=9)

        # When the flight controller has no pose
        states = Input("slam/vision_state", String)
        states.send(String("uncertain"))  # it has been no other before
        states.send(String("good"))
        states.send(String("stale"))
        warned.wait_for("vision is stale")
        self.assertFalse(warned.count("vision is uncertain"))
        poses.send(odometry_of(stamps.next(0.01), (-3.0, 37.0, 2.0)))
        linear = commands.next().twist.linear
        self.assertEqual((linear.x, linear.y, linear.z), (0.0, 0.0, 0.0))

        # Then it stops, until the pose is good again
        states.deliver(String("good"))
        poses.send(odometry_of(stamps.next(0.01), (-3.0, 37.0, 2.0)))
        poses.send(odometry_of(stamps.next(0.01), (-3.0, 37.0, 2.0)))
        commands.next()
        self.assertGreater(math.hypot(*xyz(commands.next().twist.linear)), 0.0)

        # When SLAM begins another map, then the setpoint is a place of the old one, and the UAV hovers
        maps = Input("slam/map_id", String)
        maps.deliver(String("one"))
        maps.send(String("two"))
        warned.wait_for("another map")
        for _ in range(300):
            poses.send(odometry_of(stamps.next(0.01), (-3.0, 37.0, 2.0)))
            command = commands.next()
        self.assertAlmostEqual(math.hypot(*xyz(command.twist.linear)), 0.0)

    def test_ground_truth_is_in_world(self):
        poses, setpoints = Input("truth/ground_truth", Odometry), Input("truth/pos_setpoint", Pose)
        commands = Output("truth/vel_setpoint_out", TwistStamped)
        goals = Output("truth/position_controller/goal", PoseStamped)
        reached = Output("truth/goal_reached", Bool)
        setpoint = Pose()
        setpoint.position.z = 3.0
        setpoints.send(setpoint)
        self.assertEqual(goals.next().header.frame_id, "world")
        stamps = Stamps()
        for _ in range(100):
            poses.send(odometry_of(stamps.next(0.01), (0.0, 0.0, 2.0), frame="world"))
            command = commands.next()
        # 1 m below: half of 1 m/s^2 until a / g^2 = 0.5 m are left, so v = sqrt(2 * 0.5 * (1 - 0.25))
        self.assertAlmostEqual(command.twist.linear.z, math.sqrt(0.75))
        self.assertFalse(reached.next().data)
