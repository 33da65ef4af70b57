"""tools.launch as a whole: the graph of figure 5.2 of the thesis, respawning, bad parameters at the start."""

import subprocess
import unittest

import rosnode
import rospy
from flight_basics_ros.testing import odometry_of, scan_of, velocity_of
from geometry_msgs.msg import Pose, TwistStamped
from nav_msgs.msg import Odometry
from roslib.packages import find_node
from sensor_msgs.msg import LaserScan

from node_tools.testing import Input, Output, Stamps, address_of, long, wait_until

TYPES = {
    "/scan/filtered": "sensor_msgs/LaserScan",
    "/scan/padded": "sensor_msgs/LaserScan",
    "/UAV/vel_setpoint/raw/body": "geometry_msgs/TwistStamped",
    "/UAV/vel_setpoint/final/body": "geometry_msgs/TwistStamped",
    "/UAV/goal_reached": "std_msgs/Bool",
    "/position_controller/goal": "geometry_msgs/PoseStamped",
}


class ToolsLaunchTest(unittest.TestCase):
    def test_names_and_types(self):
        wait_until(lambda: TYPES.items() <= dict(rospy.get_published_topics()).items(), f"{TYPES}")

    def test_scans_and_velocities_go_through_with_their_stamp(self):
        scans, padded = Input("/scan", LaserScan), Output("/scan/padded", LaserScan)
        filtered = Output("/scan/filtered", LaserScan)
        stamp = Stamps().next()

        def answered():
            scans.send(scan_of(stamp, [5.0] * 540 + [1.0] + [5.0] * 540))
            rospy.sleep(0.05)
            return padded.messages

        wait_until(answered, "a padded scan")  # padding may not have heard of a filter that was started again
        self.assertEqual(set(filtered.next().ranges), {5.0})
        result = padded.next()
        self.assertEqual((len(result.ranges), result.header.stamp), (1440, stamp))
        self.assertEqual(sum(intensity == -1.0 for intensity in result.intensities), 1440 - 1081)

        poses, setpoints = Input("/UAV/odometry", Odometry), Input("/UAV/pos_setpoint", Pose)
        raw = Output("/UAV/vel_setpoint/raw/body", TwistStamped)
        setpoint = Pose()
        setpoint.position.y, setpoint.position.z = -30.0, 2.0
        setpoints.deliver(setpoint)
        stamps = Stamps()
        for _ in range(150):
            poses.send(odometry_of(stamps.next(0.01)))
            wanted = raw.next()
        self.assertAlmostEqual(wanted.twist.linear.y, -2.0)

        # what obstacle avoidance made of it is zero: look to the right, where it wanted to go
        safe = Input("/UAV/vel_setpoint/safe/body", TwistStamped)
        final = Output("/UAV/vel_setpoint/final/body", TwistStamped)
        rospy.sleep(0.5)
        safe.send(velocity_of(wanted.header.stamp, (0.0, 0.0, 0.0)))
        result = final.next()
        self.assertEqual(result.header.stamp, wanted.header.stamp)
        self.assertEqual((result.twist.linear.x, result.twist.angular.z), (0.0, -1.0))

    def kill(self, node):
        """Kill a node and wait for roslaunch to start it again."""
        before = address_of(node)
        rosnode.kill_nodes([node])
        wait_until(lambda: address_of(node) not in (None, before), f"the return of {node}")

    def test_a_killed_filter_comes_back_and_works(self):
        scans, filtered = Input("/scan", LaserScan), Output("/scan/filtered", LaserScan)
        self.kill("/lidar_median_filter")
        stamps = Stamps()

        def answered():
            scans.send(scan_of(stamps.next(), [2.0] * 9))
            rospy.sleep(0.05)
            return filtered.messages

        wait_until(answered, "a scan from the new filter")

    def test_a_killed_position_controller_flies_on_to_a_latched_setpoint(self):
        setpoints = rospy.Publisher("/UAV/pos_setpoint", Pose, queue_size=1, latch=True)
        setpoint = Pose()
        setpoint.position.x, setpoint.position.z = 30.0, 2.0
        setpoints.publish(setpoint)
        poses = Input("/UAV/odometry", Odometry)
        raw = Output("/UAV/vel_setpoint/raw/body", TwistStamped)
        self.kill("/position_controller")
        stamps = Stamps(start_s=1000.0)

        def flies():
            """It begins from rest, and reaches its speed within 1 s of the poses' time."""
            for _ in range(120):
                poses.send(odometry_of(stamps.next(0.01)))
                raw.holds(lambda command: command.header.stamp.to_sec() >= stamps.now_s, 0.02)
            return raw.messages and raw.messages[-1].twist.linear.x == 2.0

        wait_until(flies, "full speed from the new position controller")
        setpoints.unregister()

    @long
    def test_bad_parameters_at_the_start_give_one_sentence_and_exit_code_1(self):
        cases = (
            ("lidar_median_filter", "_window:=4", "window is 4; it must be odd"),
            ("lidar_padding", "_value:=far", "value is 'far'; it must be"),
            ("position_controller", "_pose_source:=gps", "pose_source is 'gps'; it must be one of"),
            ("yaw_regulator", "_speed_off:=1.0", "it must be below speed_on"),
        )
        started = [
            subprocess.Popen(
                [find_node("inspection_tools", node)[0], f"__name:=misled_{index}", parameter],
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
            )
            for index, (node, parameter, _) in enumerate(cases)
        ]
        for (_, parameter, complaint), process in zip(cases, started):
            with self.subTest(parameter):
                said, _ = process.communicate(timeout=200.0)
                self.assertEqual(process.returncode, 1, said)
                self.assertIn(complaint, said)
                self.assertNotIn("Traceback", said)
