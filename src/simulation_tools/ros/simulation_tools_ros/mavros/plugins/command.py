"""MAVROS's plugin `command`: each service waits, in wall time, for the flight controller's answer."""

from __future__ import annotations

from typing import Any, Sequence

import rospy
from mavros_msgs import srv
from pymavlink.dialects.v20 import common

from simulation_tools.bounds import fit_float32
from simulation_tools_ros.mavros.uas import Uas

RESULT_ACCEPTED, RESULT_FAILED = 0, 4
_COMPONENT_ARM_DISARM, _DO_SET_HOME, _NAV_LAND, _NAV_TAKEOFF = 400, 179, 21, 22
_BROADCAST = (0, 0)


class CommandPlugin:
    """Serves cmd/{arming,command,command_int,set_home,takeoff,land}.

    A result is the flight controller's MAV_RESULT, or 4 (failed) without an answer. As in MAVROS,
    command_int and broadcasts do not wait for an answer.
    """

    def __init__(self, uas: Uas) -> None:
        self._client = uas.client
        for name, service_class, handler in (
            ("cmd/arming", srv.CommandBool, self._on_arming),
            ("cmd/command", srv.CommandLong, self._on_command),
            ("cmd/command_int", srv.CommandInt, self._on_command_int),
            ("cmd/set_home", srv.CommandHome, self._on_set_home),
            ("cmd/takeoff", srv.CommandTOL, self._on_takeoff),
            ("cmd/land", srv.CommandTOL, self._on_land),
        ):
            uas.serve(name, service_class, handler)

    def _on_arming(self, request: srv.CommandBoolRequest) -> srv.CommandBoolResponse:
        return self._send(srv.CommandBoolResponse, _COMPONENT_ARM_DISARM, 1.0 if request.value else 0.0)

    def _on_command(self, request: srv.CommandLongRequest) -> srv.CommandLongResponse:
        params = [getattr(request, f"param{i}") for i in range(1, 8)]
        if not request.broadcast:
            return self._send(srv.CommandLongResponse, request.command, *params)
        if not _are_numbers(params):
            return srv.CommandLongResponse(success=False, result=RESULT_FAILED)
        message = common.MAVLink_command_long_message(*_BROADCAST, request.command, 0, *params)
        return srv.CommandLongResponse(success=self._client.send(message), result=RESULT_ACCEPTED)

    def _on_command_int(self, request: srv.CommandIntRequest) -> srv.CommandIntResponse:
        params = [request.param1, request.param2, request.param3, request.param4]
        if not _are_numbers([*params, request.z]):
            return srv.CommandIntResponse(success=False)
        target = self._client.target
        message = common.MAVLink_command_int_message(
            *(_BROADCAST if request.broadcast else (target.system_id, target.component_id)),
            request.frame,
            request.command,
            request.current,
            request.autocontinue,
            *params,
            request.x,
            request.y,
            request.z,
        )
        return srv.CommandIntResponse(success=self._client.send(message))

    def _on_set_home(self, request: srv.CommandHomeRequest) -> srv.CommandHomeResponse:
        here = 1.0 if request.current_gps else 0.0
        place = (request.latitude, request.longitude, request.altitude)
        return self._send(srv.CommandHomeResponse, _DO_SET_HOME, here, 0.0, 0.0, request.yaw, *place)

    def _on_takeoff(self, request: srv.CommandTOLRequest) -> srv.CommandTOLResponse:
        return self._send_at_place(_NAV_TAKEOFF, request.min_pitch, request)

    def _on_land(self, request: srv.CommandTOLRequest) -> srv.CommandTOLResponse:
        return self._send_at_place(_NAV_LAND, 0.0, request)

    def _send_at_place(
        self, command: int, param1: float, request: srv.CommandTOLRequest
    ) -> srv.CommandTOLResponse:
        place = (request.latitude, request.longitude, request.altitude)
        return self._send(srv.CommandTOLResponse, command, param1, 0.0, 0.0, request.yaw, *place)

    def _send(self, response_class: Any, command: int, *params: float) -> Any:
        """Send COMMAND_LONG, and wait for its answer."""
        try:
            result = self._client.command(command, *params)
        except ValueError as error:
            rospy.logwarn(f"Command {command} is refused: {error}.")
            return response_class(success=False, result=RESULT_FAILED)
        if result is None:
            rospy.logwarn(f"The flight controller did not answer command {command}.")
            return response_class(success=False, result=RESULT_FAILED)
        return response_class(success=result == RESULT_ACCEPTED, result=result)


def _are_numbers(params: Sequence[float]) -> bool:
    """Whether MAVLink can carry the parameters; NaN means "not given" to many commands."""
    if fit_float32(param for param in params if param == param):
        return True
    rospy.logwarn("A command is refused: a parameter is beyond 3.4e38.")
    return False
