#!/usr/bin/env python3
"""sitl.launch and tools.launch together: the UAV takes off by itself, hovers, and TF says where."""

from __future__ import annotations

import threading
import time
import unittest

import rospy
import rostest
import tf2_ros
from diagnostic_msgs.msg import DiagnosticArray
from dynamic_reconfigure.client import Client
from gazebo_msgs.msg import ContactsState
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Bool

HOVER_M = (0.0, 0.0, 2.0)


class TestSitl(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        began = time.time()
        cls.places, cls.contacts = [], []
        cls.ready = threading.Event()
        cls.tf = tf2_ros.Buffer()
        cls.listener = tf2_ros.TransformListener(cls.tf)
        rospy.Subscriber("/UAV/ground_truth", Odometry, cls._on_ground_truth)
        rospy.Subscriber("/UAV/collision", ContactsState, lambda m: cls.contacts.append(m))
        rospy.Subscriber("/UAV/ready", Bool, lambda m: cls.ready.set() if m.data else None)
        assert cls.ready.wait(30.0), "the UAV does not get ready"
        cls.took_s = time.time() - began

    @classmethod
    def _on_ground_truth(cls, message):
        p = message.pose.pose.position
        cls.places.append((message.header.stamp.to_sec(), (p.x, p.y, p.z)))

    def test_1_it_is_soon_ready_at_the_hover_point(self):
        self.assertLess(self.took_s, 15.0)  # of wall time, from when this test starts
        _, place = self.places[-1]
        for value, wanted in zip(place, HOVER_M):
            self.assertAlmostEqual(value, wanted, delta=0.25)

    def test_2_without_commands_it_holds_its_place_within_5_cm(self):
        gazebo = Client("/gazebo", timeout=5.0)
        gazebo.update_configuration({"real_time_factor": 3.0})
        rospy.sleep(6.0)  # the rest of the climb
        self.places.clear()
        self.contacts.clear()
        rospy.sleep(3.0)
        gazebo.update_configuration({"real_time_factor": 1.0})
        self.assertGreater(len(self.places), 250)
        for _, place in self.places:
            for value, wanted in zip(place, HOVER_M):
                self.assertAlmostEqual(value, wanted, delta=0.05)
        self.assertFalse([message for message in self.contacts if message.states])

    def test_3_tf_knows_the_lidar_in_the_world_and_agrees_with_the_ground_truth(self):
        hokuyo = self.tf.lookup_transform("world", "hokuyo", rospy.Time(0), rospy.Duration(3.0))
        base = self.tf.lookup_transform("world", "base_frame", rospy.Time(0), rospy.Duration(3.0))
        self.tf.lookup_transform("odom", "hokuyo", rospy.Time(0), rospy.Duration(3.0))
        self.assertAlmostEqual(base.transform.translation.z, 2.0, delta=0.06)
        height = hokuyo.transform.translation.z - base.transform.translation.z
        self.assertAlmostEqual(height, 0.062 + 0.0525, delta=0.002)  # the mount and the UST's own height

    def test_4_velocities_are_flown_and_their_latency_is_measured(self):
        commands = rospy.Publisher(
            "/UAV/vel_setpoint/final/body", TwistStamped, queue_size=1, tcp_nodelay=True
        )

        def answer(scan):
            command = TwistStamped(header=scan.header)
            command.header.frame_id = "base_frame"
            command.twist.linear.x = 0.5
            commands.publish(command)

        subscriber = rospy.Subscriber("/scan", LaserScan, answer, queue_size=1, tcp_nodelay=True)
        time.sleep(4.0)
        began, start = self.places[-1]
        time.sleep(2.0)
        ended, end = self.places[-1]
        subscriber.unregister()
        self.assertAlmostEqual((end[0] - start[0]) / (ended - began), 0.5, delta=0.1)
        message = rospy.wait_for_message("/gazebo/performance", DiagnosticArray, timeout=3.0)
        values = {item.key: float(item.value) for item in message.status[0].values}
        self.assertGreater(values["setpoint_latency_count"], 150)
        self.assertTrue(0.0 < values["setpoint_latency_ms_median"] < 15.0, values)


if __name__ == "__main__":
    rospy.init_node("rostest_sitl")
    rostest.rosrun("simulation_tools", "sitl_test", TestSitl)
