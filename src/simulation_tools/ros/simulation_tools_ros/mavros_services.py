"""MAVROS's services: commands, modes and parameters, each in a thread of its own, waiting in wall time."""

from __future__ import annotations

import rospy
from mavros_msgs.srv import (
    CommandBool,
    CommandBoolResponse,
    CommandLong,
    CommandLongResponse,
    CommandTOL,
    CommandTOLResponse,
    ParamGet,
    ParamGetResponse,
    ParamPull,
    ParamPullResponse,
    ParamSet,
    ParamSetResponse,
    SetMode,
    SetModeResponse,
)

from simulation_tools.mavros.client import FcuClient, custom_mode
from simulation_tools_ros import mavros_messages as convert

COMPONENT_ARM_DISARM, NAV_LAND, NAV_TAKEOFF = 400, 21, 22
RESULT_ACCEPTED, RESULT_FAILED = 0, 4


class MavrosServices:
    """The services; a result is the flight controller's MAV_RESULT, 4 (failed) when it does not answer."""

    def __init__(self, client: FcuClient) -> None:
        self._client = client
        for name, service_class, handler in (
            ("cmd/arming", CommandBool, self._on_arming),
            ("cmd/command", CommandLong, self._on_command),
            ("cmd/takeoff", CommandTOL, lambda r: self._on_takeoff_or_land(NAV_TAKEOFF, r)),
            ("cmd/land", CommandTOL, lambda r: self._on_takeoff_or_land(NAV_LAND, r)),
            ("set_mode", SetMode, self._on_set_mode),
            ("param/get", ParamGet, self._on_param_get),
            ("param/set", ParamSet, self._on_param_set),
            ("param/pull", ParamPull, self._on_param_pull),
        ):
            rospy.Service("~" + name, service_class, handler)

    def _command(self, response_class, command: int, *params: float):
        try:
            result = self._client.command(command, *params)
        except ValueError as error:
            rospy.logwarn(f"Command {command} is refused: {error}.")
            return response_class(success=False, result=RESULT_FAILED)
        if result is None:
            rospy.logwarn(f"The flight controller did not answer command {command}.")
            return response_class(success=False, result=RESULT_FAILED)
        return response_class(success=result == RESULT_ACCEPTED, result=result)

    def _on_arming(self, request) -> CommandBoolResponse:
        return self._command(CommandBoolResponse, COMPONENT_ARM_DISARM, 1.0 if request.value else 0.0)

    def _on_command(self, request) -> CommandLongResponse:
        params = (getattr(request, f"param{i}") for i in range(1, 8))
        return self._command(CommandLongResponse, request.command, *params)

    def _on_takeoff_or_land(self, command: int, request) -> CommandTOLResponse:
        return self._command(
            CommandTOLResponse,
            command,
            request.min_pitch,
            0.0,
            0.0,
            request.yaw,
            request.latitude,
            request.longitude,
            request.altitude,
        )

    def _on_set_mode(self, request) -> SetModeResponse:
        custom = 0
        if request.custom_mode:
            custom = custom_mode(request.custom_mode)
            if custom is None:
                rospy.logerr(f"PX4 has no mode {request.custom_mode!r}.")
                return SetModeResponse(mode_sent=False)
        self._client.set_mode(request.base_mode, custom)
        return SetModeResponse(mode_sent=True)

    def _on_param_get(self, request) -> ParamGetResponse:
        value = self._client.get_parameter(request.param_id)
        if value is None:
            return ParamGetResponse(success=False)
        return ParamGetResponse(success=True, value=convert.param_value_message(value))

    def _on_param_set(self, request) -> ParamSetResponse:
        """The type is the flight controller's: a whole number may stand for a float parameter."""
        wanted = convert.param_value_of(request.value)
        known = self._client.get_parameter(request.param_id)
        if known is None:
            return ParamSetResponse(success=False)
        if isinstance(known, float):
            wanted = float(wanted)
        elif isinstance(wanted, float):
            return ParamSetResponse(success=False, value=convert.param_value_message(known))
        try:
            value = self._client.set_parameter(request.param_id, wanted)
        except ValueError as error:
            rospy.logwarn(f"The parameter {request.param_id} is not set: {error}.")
            return ParamSetResponse(success=False, value=convert.param_value_message(known))
        if value is None:
            return ParamSetResponse(success=False)
        # A float comes back as the float32 it was sent as.
        success = abs(value - wanted) <= 1e-6 * max(1.0, abs(wanted))
        return ParamSetResponse(success=success, value=convert.param_value_message(value))

    def _on_param_pull(self, _request) -> ParamPullResponse:
        count = len(self._client.pull_parameters())
        return ParamPullResponse(success=count > 0, param_received=count)
