"""MAVROS's plugin `sys_time`."""

from __future__ import annotations

import rospy
from mavros_msgs.msg import TimesyncStatus
from pymavlink.dialects.v20 import common
from sensor_msgs.msg import TimeReference
from std_msgs.msg import Header

from simulation_tools.timesync import ClockOffset, Observation
from simulation_tools_ros.mavros.uas import Uas, stamp_from_us

_A_CLOCK_THAT_WAS_SET_US = 1234567890 * 1_000_000  # in 2009


class SysTimePlugin:
    """Publishes time_reference and timesync_status.

    Stamps do not depend on the measured offset, because in simulation the flight controller's clock is ROS's.
    Parameters: ~conn/timesync_rate (Hz of wall time, 0: none), ~time/time_ref_source.
    """

    def __init__(self, uas: Uas) -> None:
        self._uas = uas
        self._source = rospy.get_param("~time/time_ref_source", "fcu")
        self._offset = ClockOffset()
        self._reference = uas.advertise("time_reference", TimeReference)
        self._status = uas.advertise("timesync_status", TimesyncStatus)
        uas.client.on("SYSTEM_TIME", self._on_system_time)
        uas.client.on("TIMESYNC", self._on_timesync)
        rate_hz = float(rospy.get_param("~conn/timesync_rate", 10.0))
        if rate_hz > 0.0:
            uas.every(1.0 / min(rate_hz, 100.0), self._ask)

    def _on_system_time(self, message: common.MAVLink_message) -> None:
        if message.time_unix_usec > _A_CLOCK_THAT_WAS_SET_US:
            self._reference.publish(lambda: self._reference_message(message))

    def _reference_message(self, message: common.MAVLink_message) -> TimeReference:
        time_ref = stamp_from_us(message.time_unix_usec)
        return TimeReference(Header(stamp=self._uas.now), time_ref, self._source)

    def _ask(self, _now_s: float) -> None:
        """Send our time. Only this plugin reads the answer."""
        if self._status.wanted and self._uas.client.connected:
            self._uas.client.send(common.MAVLink_timesync_message(0, rospy.get_rostime().to_nsec()))

    def _on_timesync(self, message: common.MAVLink_message) -> None:
        now_ns = rospy.get_rostime().to_nsec()
        if message.tc1 == 0:
            # A zero means a question. While simulated time is zero, the two sides would answer for ever
            self._uas.client.send(common.MAVLink_timesync_message(max(now_ns, 1), message.ts1))
        elif message.tc1 > 0:
            observation = self._offset.add(message.ts1, message.tc1, now_ns)
            self._status.publish(lambda: self._status_message(observation))

    def _status_message(self, observation: Observation) -> TimesyncStatus:
        return TimesyncStatus(
            header=Header(stamp=self._uas.now),
            remote_timestamp_ns=observation.remote_ns,
            observed_offset_ns=observation.observed_offset_ns,
            estimated_offset_ns=observation.estimated_offset_ns,
            round_trip_time_ms=1e-6 * observation.round_trip_ns,
        )
