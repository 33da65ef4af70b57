"""What the rostests of the node mavros share: topics whose messages are kept, and waiting in wall time."""

from __future__ import annotations

import threading
import time
import unittest

import rospy
from mavros_msgs.msg import ParamValue
from mavros_msgs.srv import ParamSet

PATIENCE_S = 8.0


class MavrosTestCase(unittest.TestCase):
    """A script for MAVROS: `listen` to topics below /mavros, and read what came."""

    @classmethod
    def setUpClass(cls):
        cls.lock = threading.Lock()
        cls.received = {}
        cls.be_patient(PATIENCE_S)

    @classmethod
    def be_patient(cls, without_setpoints_s):
        """Set how long PX4 flies on without setpoints, simulated: a busy machine keeps nodes waiting.

        The services exist before MAVROS has found PX4, so the first tries may fail.
        """
        set_parameter = cls.service("param/set", ParamSet)
        value = ParamValue(real=without_setpoints_s)
        taken = cls.eventually(lambda: set_parameter("COM_OF_LOSS_T", value).success)
        assert taken, "PX4 did not take COM_OF_LOSS_T within 60 s; read the log of the node mavros"

    @classmethod
    def land_soon(cls):
        """Let PX4 sink faster from now on: by default a landing takes half of a flight here."""
        set_parameter = cls.service("param/set", ParamSet)
        for name, speed_m_s in (("MPC_Z_VEL_MAX_DN", 3.0), ("MPC_LAND_SPEED", 1.5)):
            assert set_parameter(name, ParamValue(real=speed_m_s)).success, name

    @classmethod
    def listen(cls, topics):
        """Keep the messages of topics: {name: message class}."""
        for name, message_class in topics.items():
            cls.received[name] = []
            rospy.Subscriber(f"/mavros/{name}", message_class, cls.on_message, name, tcp_nodelay=True)

    @classmethod
    def on_message(cls, message, name):
        with cls.lock:
            cls.received[name] = [*cls.received[name][-200:], message]

    @classmethod
    def messages(cls, name):
        with cls.lock:
            return list(cls.received[name])

    @classmethod
    def last(cls, name):
        with cls.lock:
            return cls.received[name][-1] if cls.received[name] else None

    @classmethod
    def forget(cls, name):
        with cls.lock:
            cls.received[name] = []

    @staticmethod
    def service(name, service_class):
        rospy.wait_for_service(f"/mavros/{name}", timeout=200.0)
        return rospy.ServiceProxy(f"/mavros/{name}", service_class)

    @staticmethod
    def eventually(condition, timeout_s=60.0, act=lambda: None, period_s=0.02):
        """Wait, in wall time, until a condition holds; returns whether it did."""
        end = time.monotonic() + timeout_s
        while time.monotonic() < end and not rospy.is_shutdown():
            act()
            if condition():
                return True
            time.sleep(period_s)
        return False
