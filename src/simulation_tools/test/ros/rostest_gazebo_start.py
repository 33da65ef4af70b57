"""What the node gazebo says when it cannot start, and how fast it ends."""

from __future__ import annotations

import os
import re
import signal
import socket
import subprocess
import unittest

import rosnode
import rospy
from nav_msgs.msg import Odometry
from roslib.packages import find_node
from sensor_msgs.msg import LaserScan

from node_tools.testing import long, wait_until

TESTS = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
WORLD = "_world:=" + os.path.join(TESTS, "worlds", "one_box.world")
TAKEN = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
TAKEN.bind(("127.0.0.1", 0))
TAKEN_PORT = TAKEN.getsockname()[1]

# What is wrong: (words of the sentence that says so, the parameters)
REFUSED = {
    "a malformed world": ("rostest_gazebo_start.py", "_world:=" + os.path.abspath(__file__)),
    # The flight controller's own port lies 40 above that of its client, as PX4's 14580 above 14540.
    "a port that is taken": (str(TAKEN_PORT), WORLD, f"_offboard_port:={TAKEN_PORT - 40}"),
}
REFUSED_TOO = {
    "an unknown lidar, told the six": ("urg, ust, utm, puck, tim, m8", WORLD, "_lidar:=velodyne"),
    "a negative real-time factor": ("real_time_factor", WORLD, "_real_time_factor:=-1"),
    "a port that is none": ("gcs_port", WORLD, "_gcs_port:=70000"),
}


def start(name, *parameters):
    """Start a node of this name beside the others."""
    command = [find_node("simulation_tools", "gazebo")[0], f"__name:={name}", "/clock:=/other_clock"]
    given = {parameter.split(":=")[0] for parameter in parameters}
    ports = [f"{port}:=0" for port in ("_offboard_port", "_gcs_port") if port not in given]
    return subprocess.Popen(
        [*command, *ports, *parameters],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        env={**os.environ, "ROSCONSOLE_STDOUT_LINE_BUFFERED": "1"},
        start_new_session=True,
    )


class TestStart(unittest.TestCase):
    """A node that cannot start says why in one sentence and returns 1; SIGINT ends one quickly."""

    def start(self, name, *parameters):
        """Start a node; it does not outlive the test."""
        process = start(name, *parameters)
        self.addCleanup(lambda: process.poll() is None and os.killpg(process.pid, signal.SIGKILL))
        return process

    def assert_ends_quietly(self, process):
        os.killpg(process.pid, signal.SIGINT)
        output, _ = process.communicate(timeout=200.0)
        self.assertNotIn("Traceback", output)

    def test_what_cannot_be_simulated_is_refused_in_one_sentence(self):
        self.assert_refused(REFUSED)

    @long
    def test_so_is_more(self):
        self.assert_refused(REFUSED_TOO)

    def assert_refused(self, refused):
        # A name for each, because the master keeps the parameters of a name.
        started = {what: self.start(re.sub(r"\W", "_", what), *refused[what][1:]) for what in refused}
        for what, process in started.items():
            with self.subTest(what):
                output, _ = process.communicate(timeout=200.0)
                self.assertEqual(process.returncode, 1, output)
                self.assertNotIn("Traceback", output)
                fatal = [line for line in output.splitlines() if "[FATAL]" in line]
                self.assertEqual(len(fatal), 1, output)
                self.assertIn(refused[what][0], fatal[0])

    def test_sigint_ends_it_soon_whatever_it_is_just_publishing(self):
        messages = []
        for topic, message_class in (("/other_scan", LaserScan), ("/other_odometry", Odometry)):
            rospy.Subscriber(topic, message_class, messages.append)
        # As fast as possible: nearly all of its time goes into publishing.
        topics = ("scan:=/other_scan", "odometry:=/other_odometry")
        process = self.start("other_gazebo", WORLD, "_real_time_factor:=0", *topics)
        wait_until(lambda: len(messages) >= 100, "messages of the simulator", 200.0)
        self.assert_ends_quietly(process)

    def test_sigint_while_it_starts_leaves_no_traceback(self):
        process = self.start("starting_gazebo", WORLD)
        wait_until(lambda: "/starting_gazebo" in rosnode.get_node_names(), "the node", 200.0)
        self.assert_ends_quietly(process)
