"""MAVROS's plugin `param`: the flight controller's parameters, and their copy below ~param."""

from __future__ import annotations

from typing import Any

import rospy
from mavros_msgs import srv
from mavros_msgs.msg import Param, ParamValue
from pymavlink.dialects.v20 import common
from std_msgs.msg import Header

from simulation_tools.mavlink import decode_text
from simulation_tools_ros.mavros.uas import Uas


class ParamPlugin:
    """Serves param/{get,set,pull,push}; publishes param/param_value.

    get and set always ask the flight controller. pull copies all its parameters to ~param. push sends the
    parameters in ~param to the flight controller.
    """

    def __init__(self, uas: Uas) -> None:
        self._uas = uas
        self._client = uas.client
        self._value = uas.advertise("param/param_value", Param)
        for name, service_class, handler in (
            ("param/get", srv.ParamGet, self._on_get),
            ("param/set", srv.ParamSet, self._on_set),
            ("param/pull", srv.ParamPull, self._on_pull),
            ("param/push", srv.ParamPush, self._on_push),
        ):
            uas.serve(name, service_class, handler)
        uas.client.on("PARAM_VALUE", self._on_value)

    def _on_value(self, message: common.MAVLink_message) -> None:
        if not self._value.wanted:
            return
        try:
            value = self._client.stack.from_wire(message.param_value, message.param_type)
        except ValueError:
            return
        self._value.publish(
            lambda: Param(
                header=Header(stamp=self._uas.now),
                param_id=decode_text(message.param_id),
                value=value_message(value),
                param_index=message.param_index,
                param_count=message.param_count,
            )
        )

    def _on_get(self, request: srv.ParamGetRequest) -> srv.ParamGetResponse:
        value = self._client.get_parameter(request.param_id)
        if value is None:
            return srv.ParamGetResponse(success=False)
        return srv.ParamGetResponse(success=True, value=value_message(value))

    def _on_set(self, request: srv.ParamSetRequest) -> srv.ParamSetResponse:
        success, value = self._set(request.param_id, value_of(request.value))
        return srv.ParamSetResponse(
            success=success, value=ParamValue() if value is None else value_message(value)
        )

    def _on_pull(self, _request: srv.ParamPullRequest) -> srv.ParamPullResponse:
        parameters = self._client.pull_parameters()
        if parameters:
            rospy.set_param("~param", parameters)
        return srv.ParamPullResponse(success=bool(parameters), param_received=len(parameters))

    def _on_push(self, _request: srv.ParamPushRequest) -> srv.ParamPushResponse:
        wanted = rospy.get_param("~param", {})
        if not isinstance(wanted, dict):
            rospy.logwarn("param/push: ~param holds no parameters.")
            return srv.ParamPushResponse(success=False)
        known = self._client.pull_parameters()
        unknown = sorted(set(wanted) - set(known))
        if unknown:
            rospy.logwarn(f"param/push: the flight controller has no parameter {', '.join(unknown)}.")
        # Send only values that differ.
        transferred = sum(
            known[name] == value or self._set(name, value)[0]
            for name, value in wanted.items()
            if name in known and self._is_number(name, value)
        )
        return srv.ParamPushResponse(success=bool(known), param_transfered=transferred)

    @staticmethod
    def _is_number(name: str, value: Any) -> bool:
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            return True
        rospy.logwarn(f"The parameter {name} is not set: {value!r} is not a number.")
        return False

    def _set(self, name: str, wanted: float) -> tuple[bool, float | None]:
        """Set a parameter.

        Return whether it has the wanted value, and its value (None without an answer). The flight controller
        decides on the type: a whole number may be the value of a float parameter.
        """
        known = self._client.get_parameter(name)
        if known is None:
            return False, None
        if isinstance(known, float):
            wanted = float(wanted)
        elif isinstance(wanted, float):
            rospy.logwarn(f"The parameter {name} is not set: it needs a whole number, not {wanted}.")
            return False, known
        try:
            value = self._client.set_parameter(name, wanted)
        except ValueError as error:
            rospy.logwarn(f"The parameter {name} is not set: {error}.")
            return False, known
        # A float comes back rounded to float32.
        success = value is not None and abs(value - wanted) <= 1e-6 * max(1.0, abs(wanted))
        return success, value


def value_message(value: float) -> ParamValue:
    """Return a parameter's value: an int goes to the integer field, a float to the real one."""
    return ParamValue(integer=value) if isinstance(value, int) else ParamValue(real=value)


def value_of(message: ParamValue) -> float:
    """Return the value of a ParamValue as MAVROS reads it: the integer unless it is zero."""
    if message.integer != 0:
        return int(message.integer)
    return float(message.real) if message.real != 0.0 else 0
