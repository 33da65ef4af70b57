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

TOPICS = {
    "/clock": Clock,
    "/scan": LaserScan,
    "/UAV/odometry": Odometry,
    "/UAV/ground_truth": Odometry,
    "/UAV/collision": ContactsState,
    "/imu": Imu,
    "/gazebo/model_states": ModelStates,
}


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
            ("delete_model", DeleteModel),
            ("get_model_state", GetModelState),
            ("set_model_state", SetModelState),
            ("get_world_properties", GetWorldProperties),
        ):
            rospy.wait_for_service(f"/gazebo/{name}", timeout=20.0)
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

    def wait_for(self, condition, timeout_s=5.0, what="condition"):
        with self.changed:
            assert self.changed.wait_for(condition, timeout_s), f"{what} did not come true"

    def collect(self, seconds):
        self.wait_for(lambda: self.received["/clock"], what="/clock")
        time.sleep(seconds)
        with self.changed:
            return {name: list(messages) for name, messages in self.received.items()}

    def scan_ahead(self):
        """Median range of the beams within 2 degrees of straight ahead, of a scan that comes from now on."""
        time.sleep(0.1)
        self.forget()
        self.wait_for(lambda: self.received["/scan"], what="a scan")
        scan = self.received["/scan"][-1]
        beams = [
            r
            for k, r in enumerate(scan.ranges)
            if abs(scan.angle_min + k * scan.angle_increment) < math.radians(2.0)
        ]
        return sorted(beams)[len(beams) // 2]
