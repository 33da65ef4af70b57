#!/usr/bin/env python3
"""What the node gazebo says when it cannot start, and how fast it ends."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import time
import unittest

import rosnode
import rospy
import rostest
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan


class TestStart(unittest.TestCase):
    """A node that cannot start says why in one sentence and returns 1; SIGINT ends one quickly."""

    def start(self, *parameters):
        if rospy.has_param("/other_gazebo"):
            rospy.delete_param("/other_gazebo")
        command = ["rosrun", "simulation_tools", "gazebo", "__name:=other_gazebo", "/clock:=/other_clock"]
        ports = ["_offboard_port:=0", "_gcs_port:=0"]
        given = {parameter.split(":=")[0] for parameter in parameters}
        ports = [port for port in ports if port.split(":=")[0] not in given]
        return subprocess.Popen(
            [*command, *ports, *parameters],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            env={**os.environ, "ROSCONSOLE_STDOUT_LINE_BUFFERED": "1"},
            start_new_session=True,
        )

    def assert_fails(self, words, *parameters):
        process = self.start(*parameters)
        try:
            output, _ = process.communicate(timeout=20.0)
        finally:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
        self.assertEqual(process.returncode, 1, output)
        self.assertNotIn("Traceback", output)
        fatal = [line for line in output.splitlines() if "[FATAL]" in line]
        self.assertEqual(len(fatal), 1, output)
        self.assertIn(words, fatal[0])

    WORLD = "_world:=" + os.path.join(os.path.dirname(os.path.abspath(__file__)), "worlds", "one_box.world")

    def test_missing_world(self):
        self.assert_fails("/nowhere.world", "_world:=/nowhere.world")

    def test_malformed_world(self):
        self.assert_fails("rostest_gazebo_start.py", "_world:=" + os.path.abspath(__file__))

    def test_unknown_lidar_names_the_six(self):
        self.assert_fails("urg, ust, utm, puck, tim, m8", self.WORLD, "_lidar:=velodyne")

    def test_unknown_model(self):
        self.assert_fails("no_such_model", self.WORLD, "_model:=no_such_model")

    def test_a_parameter_that_is_no_number(self):
        self.assert_fails("seed", self.WORLD, "_seed:=many")
        self.assert_fails("real_time_factor", self.WORLD, "_real_time_factor:=-1")

    def test_a_port_that_is_taken(self):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
            other.bind(("127.0.0.1", 0))
            port = other.getsockname()[1]
            # The flight controller's own port lies 40 above that of its client, as PX4's 14580 above 14540.
            self.assert_fails(str(port), self.WORLD, f"_offboard_port:={port - 40}")

    def test_a_port_that_is_none(self):
        self.assert_fails("gcs_port", self.WORLD, "_gcs_port:=70000")

    def test_sigint_ends_it_soon_whatever_it_is_just_publishing(self):
        messages = []
        for topic, message_class in (("/other_scan", LaserScan), ("/other_odometry", Odometry)):
            rospy.Subscriber(topic, message_class, messages.append)
        for _ in range(3):
            messages.clear()
            # As fast as possible: nearly all of its time goes into publishing.
            process = self.start(
                self.WORLD, "_real_time_factor:=0", "scan:=/other_scan", "odometry:=/other_odometry"
            )
            try:
                deadline = time.time() + 20.0
                while len(messages) < 100:
                    self.assertLess(time.time(), deadline, "the simulator publishes nothing")
                    time.sleep(0.01)
                began = time.time()
                os.killpg(process.pid, signal.SIGINT)
                output, _ = process.communicate(timeout=10.0)
                took = time.time() - began
            finally:
                if process.poll() is None:
                    os.killpg(process.pid, signal.SIGKILL)
            self.assertNotIn("Traceback", output)
            self.assertLess(took, 2.0)  # 0.6 s on an idle machine, most of it rospy's

    def test_sigint_while_it_starts_leaves_no_traceback(self):
        process = self.start(self.WORLD)
        deadline = time.time() + 20.0
        while not any("other_gazebo" in name for name in rosnode.get_node_names()):
            self.assertLess(time.time(), deadline, "the node does not register")
            time.sleep(0.01)
        os.killpg(process.pid, signal.SIGINT)
        try:
            output, _ = process.communicate(timeout=10.0)
        finally:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
        self.assertNotIn("Traceback", output)


if __name__ == "__main__":
    rospy.init_node("rostest_gazebo_start")
    rostest.rosrun("simulation_tools", "gazebo_start_test", TestStart)
