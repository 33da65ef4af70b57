"""The commands about messages: requests, intervals, capabilities. The link answers them itself."""

from __future__ import annotations

import math
from typing import Callable, Sequence

from pymavlink.dialects.v20 import common

from simulation_tools.px4.mavlink import telemetry
from simulation_tools.px4.mavlink.channel import Channel
from simulation_tools.px4.modes import Result
from simulation_tools.px4.px4 import Px4

# The message to send after the acknowledgement (None: nothing), and the acknowledgement's result.
Answer = tuple["common.MAVLink_message | None", Result]
_FIXED = {
    common.MAV_CMD_GET_HOME_POSITION: "HOME_POSITION",
    common.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES: "AUTOPILOT_VERSION",
    common.MAV_CMD_REQUEST_FLIGHT_INFORMATION: "FLIGHT_INFORMATION",
}


class MessageCommands:
    """Answers those commands for one flight controller."""

    def __init__(self, px4: Px4) -> None:
        self._px4 = px4
        self._handlers: dict[int, Callable[[Channel, Sequence[float]], Answer]] = {
            common.MAV_CMD_REQUEST_MESSAGE: self._request,
            common.MAV_CMD_SET_MESSAGE_INTERVAL: self._set_interval,
            common.MAV_CMD_GET_MESSAGE_INTERVAL: self._get_interval,
        }

    def handles(self, command: int) -> bool:
        """Whether a command is about messages."""
        return command in self._handlers or command in _FIXED

    def handle(self, channel: Channel, command: int, params: Sequence[float]) -> Answer:
        """Carry out one of the commands that `handles` names."""
        if command in _FIXED:
            return self._build(_FIXED[command])
        return self._handlers[command](channel, params)

    def _build(self, name: str) -> Answer:
        message = telemetry.build(name, self._px4, self._px4.status) if telemetry.can_build(name) else None
        return message, Result.DENIED if message is None else Result.ACCEPTED

    def _request(self, channel: Channel, params: Sequence[float]) -> Answer:
        return self._build(_message_name(params[0]))

    def _set_interval(self, channel: Channel, params: Sequence[float]) -> Answer:
        done = channel.set_interval(_message_name(params[0]), params[1])
        return None, Result.ACCEPTED if done else Result.FAILED

    def _get_interval(self, channel: Channel, params: Sequence[float]) -> Answer:
        """PX4 answers for any number. The interval of a message that it does not stream is 0."""
        number = int(params[0]) if math.isfinite(params[0]) and 0 <= params[0] < 65536 else None
        if number is None:
            return None, Result.DENIED
        interval_us = channel.interval_us(_message_name(number))
        return common.MAVLink_message_interval_message(number, interval_us), Result.ACCEPTED


def _message_name(number: float) -> str:
    """Return the MAVLink name of a message number; empty when it is none."""
    if not math.isfinite(number):
        return ""
    kind = common.mavlink_map.get(int(number))
    return kind.msgname if kind else ""
