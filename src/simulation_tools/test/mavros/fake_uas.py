"""A graph without ROS for MAVROS's plugins: what they publish, and what they send, is kept."""

from __future__ import annotations

import math
from types import SimpleNamespace

import pytest
from pymavlink.dialects.v20 import common

from simulation_tools.mavros.conversions import Target

for module in ("mavros_msgs.msg", "simulation_tools_ros.mavros.uas"):
    pytest.importorskip(module, reason="needs ROS's message packages")

HALF_ROOT = math.sqrt(0.5)


class FakeClient:
    """Hands messages of a flight controller to the plugins, and keeps what they send."""

    def __init__(self):
        self.target = Target(1, 1)
        self.connected = True
        self.sent = []
        self.commands = []
        self.result = 0
        self._handlers = {}

    def on(self, name, handler, any_component=False):
        self._handlers.setdefault(name, []).append(handler)

    def hear(self, message):
        for handler in self._handlers.get(message.get_type(), ()):
            handler(message)

    def send(self, message):
        self.sent.append(message)
        return True

    def command(self, command, *params):
        self.commands.append((command, *params))
        return self.result


class FakeTopic:
    """A topic with, or without, somebody who listens."""

    def __init__(self):
        self.messages = []
        self.wanted = True

    def publish(self, make):
        if self.wanted:
            self.messages.append(make())

    @property
    def last(self):
        return self.messages[-1]


def make_uas(monkeypatch, parameters=None):
    """Return a Uas whose topics, subscribers and services are kept in dicts by their names."""
    import rospy

    from simulation_tools_ros.mavros.uas import Uas

    known = parameters or {}
    monkeypatch.setattr(rospy, "get_param", lambda name, default=None: known.get(name, default))
    monkeypatch.setattr(rospy, "get_rostime", lambda: rospy.Time(77))
    monkeypatch.setattr(rospy, "logwarn_throttle", lambda period_s, text: rospy.logwarn(text))
    uas = Uas(FakeClient())
    uas.topics, uas.callbacks, uas.services = {}, {}, {}
    uas.advertise = lambda name, message_class, latch=False: uas.topics.setdefault(name, FakeTopic())
    uas.subscribe = lambda name, message_class, callback, queue_size=1: uas.callbacks.update({name: callback})
    uas.serve = lambda name, service_class, handler: uas.services.update({name: handler})
    return uas


def xyz(vector):
    return (vector.x, vector.y, vector.z)


def xyzw(quaternion):
    return (quaternion.x, quaternion.y, quaternion.z, quaternion.w)


def request(**fields):
    return SimpleNamespace(**fields)


def attitude(q=(1.0, 0.0, 0.0, 0.0), rates=(0.1, 0.2, 0.3), ms=5000):
    """Level, facing north by default."""
    return common.MAVLink_attitude_quaternion_message(ms, *q, *rates)


def local_position(us=5_040_000):
    return common.MAVLink_local_position_ned_message(us // 1000, 1.0, 2.0, -3.0, 0.4, 0.5, -0.6)


def global_position(lat=473977420, lon=85455940, relative=2500):
    return common.MAVLink_global_position_int_message(5000, lat, lon, 490500, relative, 10, 20, -30, 4500)
