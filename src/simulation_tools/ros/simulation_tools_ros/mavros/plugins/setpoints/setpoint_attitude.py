"""MAVROS's plugin `setpoint_attitude`."""

from __future__ import annotations

import threading
from typing import Any, Callable

import rospy
from geometry_msgs.msg import PoseStamped, TwistStamped
from mavros_msgs.msg import Thrust
from pymavlink.dialects.v20 import common

from simulation_tools.geometry import IDENTITY_QUATERNION
from simulation_tools.mavros.conversions import (
    ATTITUDE_IGNORE_ATTITUDE,
    ATTITUDE_IGNORE_RATES,
    attitude_target,
)
from simulation_tools_ros.mavros.uas import Uas


class SetpointAttitudePlugin:
    """Takes setpoint_attitude/thrust with setpoint_attitude/cmd_vel or, by parameter, /attitude.

    A thrust and a rate (or attitude) together make one setpoint, and each message is used once. So setpoints
    have the rate of the slower topic. A thrust outside 0..1 is refused. Parameters:
    ~setpoint_attitude/use_quaternion (false:
    cmd_vel, true: attitude), ~setpoint_attitude/reverse_thrust.
    """

    def __init__(self, uas: Uas) -> None:
        self._uas = uas
        self._lowest_thrust = -1.0 if rospy.get_param("~setpoint_attitude/reverse_thrust", False) else 0.0
        uses_attitude = bool(rospy.get_param("~setpoint_attitude/use_quaternion", False))
        pair = Pair(self._send_attitude if uses_attitude else self._send_rates)
        if uses_attitude:
            uas.subscribe("setpoint_attitude/attitude", PoseStamped, pair.first)
        else:
            uas.subscribe("setpoint_attitude/cmd_vel", TwistStamped, pair.first)
        uas.subscribe("setpoint_attitude/thrust", Thrust, pair.second)

    def _send_attitude(self, message: PoseStamped, thrust: Thrust) -> None:
        q = message.pose.orientation
        # MAVROS reads a quaternion of zeros as no rotation.
        attitude = (q.x, q.y, q.z, q.w) if any((q.x, q.y, q.z, q.w)) else IDENTITY_QUATERNION
        self._uas.send_setpoint(
            "setpoint_attitude/attitude",
            message.header,
            lambda ms: self._build(ms, ATTITUDE_IGNORE_RATES, attitude, (0.0, 0.0, 0.0), thrust.thrust),
        )

    def _send_rates(self, message: TwistStamped, thrust: Thrust) -> None:
        """MAVROS converts these rates from ENU, not from FLU: x is PX4's pitch rate, y its roll rate."""
        w = message.twist.angular
        rates_flu = (w.y, -w.x, w.z)
        self._uas.send_setpoint(
            "setpoint_attitude/cmd_vel",
            message.header,
            lambda ms: self._build(
                ms, ATTITUDE_IGNORE_ATTITUDE, IDENTITY_QUATERNION, rates_flu, thrust.thrust
            ),
        )

    def _build(
        self, time_boot_ms: int, type_mask: int, attitude: Any, rates_flu: Any, thrust: float
    ) -> common.MAVLink_message:
        if not self._lowest_thrust <= thrust <= 1.0:  # true for NaN, too
            raise ValueError(f"the thrust {thrust:g} is not within {self._lowest_thrust:g}..1")
        target = self._uas.client.target
        return attitude_target(
            target, time_boot_ms, type_mask, attitude, rates_flu, thrust, self._lowest_thrust
        )


class Pair:
    """Calls `use` with the newest messages of two topics, when both have a new one."""

    def __init__(self, use: Callable[[Any, Any], None]) -> None:
        self._use = use
        self._lock = threading.Lock()
        self._first: Any = None
        self._second: Any = None

    def first(self, message: Any) -> None:
        """Take a message of the first topic."""
        with self._lock:
            self._first = message
            self._use_both()

    def second(self, message: Any) -> None:
        """Take a message of the second topic."""
        with self._lock:
            self._second = message
            self._use_both()

    def _use_both(self) -> None:
        if self._first is not None and self._second is not None:
            first, second = self._first, self._second
            self._first = self._second = None
            self._use(first, second)
