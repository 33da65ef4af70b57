"""MAVROS's plugin `home_position`."""

from __future__ import annotations

import math

import rospy
from geometry_msgs.msg import Point, Quaternion, Vector3
from mavros_msgs.msg import HomePosition
from pymavlink.dialects.v20 import common
from std_msgs.msg import Header
from std_srvs.srv import Trigger, TriggerRequest, TriggerResponse

from simulation_tools.geometry import quaternion_multiply
from simulation_tools.mavros.conversions import require_finite
from simulation_tools.ned_frames import enu_to_ned
from simulation_tools_ros.mavros.uas import Uas

_GET_HOME_POSITION, _ACCEPTED = 410, 0
_HALF_ROOT = math.sqrt(0.5)
_NED_IN_ENU = (_HALF_ROOT, _HALF_ROOT, 0.0, 0.0)  # x y z w


class HomePositionPlugin:
    """Publishes home_position/home (latched); takes home_position/set; serves home_position/req_update."""

    def __init__(self, uas: Uas) -> None:
        self._uas = uas
        self._home = uas.advertise("home_position/home", HomePosition, latch=True)
        uas.client.on("HOME_POSITION", self._on_home)
        uas.subscribe("home_position/set", HomePosition, self._on_set)
        uas.serve("home_position/req_update", Trigger, self._on_request)

    def _on_home(self, home: common.MAVLink_message) -> None:
        """MAVROS turns the orientation to ENU but keeps PX4's body axes: forward, right, down."""
        message = HomePosition(header=Header(stamp=self._uas.now))
        message.geo.latitude = 1e-7 * home.latitude
        message.geo.longitude = 1e-7 * home.longitude
        message.geo.altitude = 1e-3 * home.altitude + self._uas.geoid_height_m
        message.position = Point(*enu_to_ned((home.x, home.y, home.z)))
        w, x, y, z = home.q
        message.orientation = Quaternion(*quaternion_multiply(_NED_IN_ENU, (x, y, z, w)))
        message.approach = Vector3(*enu_to_ned((home.approach_x, home.approach_y, home.approach_z)))
        self._home.publish(lambda: message)

    def _on_set(self, message: HomePosition) -> None:
        """PX4 ignores SET_HOME_POSITION. It understands cmd/set_home."""
        place, p, q, a = message.geo, message.position, message.orientation, message.approach
        altitude_m = place.altitude - self._uas.geoid_height_m
        position, approach = (p.x, p.y, p.z), (a.x, a.y, a.z)
        try:
            require_finite((*position, *approach, q.x, q.y, q.z, q.w))
            is_place = abs(place.latitude) <= 90.0 and abs(place.longitude) <= 180.0
            if not (is_place and abs(altitude_m) <= 1e6):
                raise ValueError("it is not a place on earth")
        except ValueError as error:
            rospy.logwarn_throttle(1.0, f"home_position/set is refused: {error}.")
            return
        rospy.logwarn_once("PX4 does not act on home_position/set (SET_HOME_POSITION): use cmd/set_home.")
        x, y, z, w = quaternion_multiply(
            _NED_IN_ENU, (q.x, q.y, q.z, q.w)
        )  # its own inverse, but for the sign
        self._uas.client.send(
            common.MAVLink_set_home_position_message(
                self._uas.client.target.system_id,
                round(1e7 * place.latitude),
                round(1e7 * place.longitude),
                round(1e3 * altitude_m),
                *enu_to_ned(position),
                (w, x, y, z),
                *enu_to_ned(approach),
            )
        )

    def _on_request(self, _request: TriggerRequest) -> TriggerResponse:
        result = self._uas.client.command(_GET_HOME_POSITION)
        if result is None:
            return TriggerResponse(False, "the flight controller did not answer")
        accepted = result == _ACCEPTED
        return TriggerResponse(accepted, "" if accepted else "the flight controller has no home position yet")
