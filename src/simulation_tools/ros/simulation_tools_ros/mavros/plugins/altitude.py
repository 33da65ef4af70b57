"""MAVROS's plugin `altitude`."""

from __future__ import annotations

import rospy
from mavros_msgs.msg import Altitude
from pymavlink.dialects.v20 import common
from std_msgs.msg import Header

from simulation_tools_ros.mavros.uas import Uas, stamp_from_us


class AltitudePlugin:
    """Publishes altitude. Parameter: ~frame_id."""

    def __init__(self, uas: Uas) -> None:
        self._frame_id = rospy.get_param("~frame_id", "map")
        self._altitude = uas.advertise("altitude", Altitude)
        uas.client.on("ALTITUDE", self._on_altitude)

    def _on_altitude(self, message: common.MAVLink_message) -> None:
        self._altitude.publish(lambda: altitude_message(message, self._frame_id))


def altitude_message(altitude: common.MAVLink_message, frame_id: str) -> Altitude:
    """ALTITUDE to Altitude."""
    return Altitude(
        header=Header(stamp=stamp_from_us(altitude.time_usec), frame_id=frame_id),
        monotonic=altitude.altitude_monotonic,
        amsl=altitude.altitude_amsl,
        local=altitude.altitude_local,
        relative=altitude.altitude_relative,
        terrain=altitude.altitude_terrain,
        bottom_clearance=altitude.bottom_clearance,
    )
