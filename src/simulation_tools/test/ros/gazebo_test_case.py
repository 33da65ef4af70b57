"""What the rostests of the node gazebo share: topics whose messages are kept, and its services."""

from __future__ import annotations

import math
import threading
import time
import unittest

import rospy
from gazebo_msgs.msg import ContactsState, ModelStates
from gazebo_msgs.srv import DeleteModel, GetModelState, GetWorldProperties, SetModelState, SpawnModel
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu, LaserScan
from std_srvs.srv import Empty

from node_tools.testing import wait_until

TOPICS = {
    "/clock": Clock,
    "/scan": LaserScan,
    "/UAV/odometry": Odometry,
    "/UAV/ground_truth": Odometry,
    "/UAV/collision": ContactsState,
    "/imu": Imu,
    "/gazebo/model_states": ModelStates,
}


PATIENCE_S = 60.0
"""Wall time; only a test that fails waits this long."""
STILL_S = 0.5
"""Wall time without a message after which the clock counts as stopped."""


class GazeboTestCase(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.changed = threading.Condition()
        cls.received = {name: [] for name in TOPICS}
        for name, message_class in TOPICS.items():
            rospy.Subscriber(name, message_class, cls._on_message, name, queue_size=1000, tcp_nodelay=True)
        cls.services = {}
        for name, service_class in (
            ("pause_physics", Empty),
            ("unpause_physics", Empty),
            ("reset_simulation", Empty),
            ("reset_world", Empty),
            ("spawn_sdf_model", SpawnModel),
            ("spawn_urdf_model", SpawnModel),
            ("delete_model", DeleteModel),
            ("get_model_state", GetModelState),
            ("set_model_state", SetModelState),
            ("get_world_properties", GetWorldProperties),
        ):
            rospy.wait_for_service(f"/gazebo/{name}", timeout=PATIENCE_S)
            cls.services[name] = rospy.ServiceProxy(f"/gazebo/{name}", service_class)

    @classmethod
    def _on_message(cls, message, name):
        with cls.changed:
            cls.received[name].append(message)
            cls.changed.notify_all()

    def setUp(self):
        self.services["unpause_physics"]()
        self.forget()

    def forget(self):
        with self.changed:
            for messages in self.received.values():
                messages.clear()

    def wait_for(self, condition, what="condition"):
        with self.changed:
            assert self.changed.wait_for(condition, PATIENCE_S), f"{what} did not come true"

    def sim_time_s(self):
        return self.services["get_world_properties"]().sim_time

    def let_pass(self, simulated_s):
        """Wait until so much simulated time is over."""
        end_s = self.sim_time_s() + simulated_s
        wait_until(lambda: self.sim_time_s() >= end_s, "simulated time to pass", PATIENCE_S)

    def wait_for_standstill(self):
        """Wait until the last messages before a pause are here and no further ones come."""

        def stands_still():
            self.forget()
            time.sleep(STILL_S)
            return not (self.received["/clock"] or self.received["/scan"])

        wait_until(stands_still, "the clock to stop", PATIENCE_S)

    def scan_ahead(self):
        """Median range of the beams within 2 degrees of straight ahead, of a scan made from now on."""
        asked_s = self.sim_time_s()
        newest = lambda: self.received["/scan"][-1] if self.received["/scan"] else None  # noqa: E731
        self.wait_for(lambda: newest() and newest().header.stamp.to_sec() > asked_s, what="a new scan")
        scan = newest()
        beams = [
            r
            for k, r in enumerate(scan.ranges)
            if abs(scan.angle_min + k * scan.angle_increment) < math.radians(2.0)
        ]
        return sorted(beams)[len(beams) // 2]
