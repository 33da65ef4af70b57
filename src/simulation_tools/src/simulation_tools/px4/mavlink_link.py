"""The flight controller's MAVLink side: UDP ports for the offboard API and for ground stations.

Port conventions of PX4 SITL: the offboard API is bound to 14580 and talks to 14540 (MAVROS:
``udp://:14540@``), the ground station's to 18570 and talks to 14550. Any other client that sends a heartbeat
to either port is served as well. The clock of everything is simulation time.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Callable

from pymavlink.dialects.v20 import common

from simulation_tools.mavlink import (
    GCS_PORT_STEP,
    OFFBOARD_PORT_STEP,
    Address,
    decode_text,
    parameter_from_wire,
    parameter_to_wire,
    wait_readable,
)
from simulation_tools.px4 import telemetry
from simulation_tools.px4.autopilot import Px4Error
from simulation_tools.px4.mavlink_channel import Channel
from simulation_tools.px4.modes import Result, Severity
from simulation_tools.px4.px4 import Px4
from simulation_tools.px4.setpoint import NAN, UNSET, AttitudeSetpoint, Setpoint

_FORCE_SET = 512
_ATTITUDE_IGNORE, _THROTTLE_IGNORE = 128, 64
# The types of PX4's custom mode live in the upper bytes of custom_mode.
_MAIN_SHIFT, _SUB_SHIFT = 16, 24


@dataclass
class LinkStatistics:
    """What has come in so far."""

    messages: int = 0
    setpoints: int = 0
    refused_setpoints: int = 0
    bad_packets: int = 0


class MavlinkLink:
    """Connects a `Px4` with its clients. Not thread-safe: the thread that steps the Px4 calls it.

    `on_setpoint` is called at the receipt of each setpoint that counts, with its `time_boot_ms`.
    `on_warning` is called once per kind of trouble, with a sentence.
    """

    def __init__(
        self,
        px4: Px4,
        offboard_port: int = 14540,
        gcs_port: int = 14550,
        host: str = "127.0.0.1",
        offboard_local_port: int | None = None,
        gcs_local_port: int | None = None,
    ) -> None:
        """Open both ports; raises LinkError when one is taken.

        offboard_port, gcs_port: where the clients listen; 0: nowhere, answer those who send heartbeats.
        Local ports: by default as far from the clients' as PX4's, 14580 and 18570; 0 takes a free one.
        """
        if offboard_local_port is None:
            offboard_local_port = offboard_port + OFFBOARD_PORT_STEP if offboard_port else 0
        if gcs_local_port is None:
            gcs_local_port = gcs_port + GCS_PORT_STEP if gcs_port else 0
        self._px4 = px4
        self._time_us = 0
        self.statistics = LinkStatistics()
        self.on_setpoint: Callable[[int], None] = lambda time_boot_ms: None
        self.on_warning: Callable[[str], None] = lambda sentence: None
        self._warned: set[str] = set()
        self.offboard = Channel(
            px4,
            host,
            offboard_local_port,
            offboard_port,
            telemetry.OFFBOARD_RATES_HZ,
            True,
            "the offboard API",
        )
        try:
            self.ground = Channel(
                px4, host, gcs_local_port, gcs_port, telemetry.GROUND_RATES_HZ, False, "ground stations"
            )
        except Exception:
            self.offboard.close()
            raise
        self._channels = (self.offboard, self.ground)
        self._sockets = [channel.socket for channel in self._channels]
        px4.on_statustext = self._say
        self._handlers = {
            "HEARTBEAT": self._heartbeat,
            "SET_POSITION_TARGET_LOCAL_NED": self._position_target,
            "SET_ATTITUDE_TARGET": self._attitude_target,
            "COMMAND_LONG": self._command_long,
            "COMMAND_INT": self._command_int,
            "SET_MODE": self._set_mode,
            "PARAM_REQUEST_LIST": self._param_list,
            "PARAM_REQUEST_READ": self._param_read,
            "PARAM_SET": self._param_set,
            "TIMESYNC": self._timesync,
            "MISSION_REQUEST_LIST": self._mission_list,
        }

    def poll(self, time_us: int, until: Callable[[], bool] = lambda: False) -> None:
        """Handle every message that is there, without waiting. time_us: simulation time now.

        until: asked after each datagram; when it says so the rest stays unread until the next call. That is
        how a simulator in lockstep takes in no more than what led to the setpoint it waits for.
        """
        self._time_us = time_us
        for channel in self._channels:
            for message, sender in channel.receive(until):
                self.statistics.messages += 1
                handler = self._handlers.get(message.get_type())
                if handler is not None:
                    handler(channel, message, sender)
        bad = sum(channel.codec.bad for channel in self._channels)
        if bad > self.statistics.bad_packets:
            self.statistics.bad_packets = bad
            self._warn("bad", "MAVLink: received data that is no valid MAVLink 2 message; it is ignored")

    def send_due(self, time_us: int) -> None:
        """Send what the streams' rates ask for at this simulation time."""
        for channel in self._channels:
            channel.send_due(time_us)

    def wait(self, timeout_s: float) -> bool:
        """Wait, in wall time, until there is something to `poll`; returns whether there is."""
        return wait_readable(self._sockets, timeout_s)

    def reset(self) -> None:
        """Simulation time has jumped back."""
        for channel in self._channels:
            channel.reset()

    def close(self) -> None:
        """Release the ports."""
        for channel in self._channels:
            channel.close()
        self._px4.on_statustext = lambda severity, text: None

    # Incoming messages

    def _heartbeat(self, channel: Channel, message, sender: Address) -> None:
        is_ground_station = message.type == common.MAV_TYPE_GCS
        channel.heard(sender, is_ground_station)
        if is_ground_station:
            self._px4.ground_station_heard()

    def _is_for_us(self, channel: Channel, message) -> bool:
        return message.target_system in (0, channel.codec.system_id) and message.target_component in (
            0,
            channel.codec.component_id,
        )

    def _position_target(self, channel: Channel, m, sender: Address) -> None:
        fields = (m.x, m.y, m.z, m.vx, m.vy, m.vz, m.afx, m.afy, m.afz, m.yaw, m.yaw_rate)
        if not self._is_for_us(channel, m) or not all(map(math.isfinite, fields)):
            self.statistics.refused_setpoints += 1
            return
        body = m.coordinate_frame == common.MAV_FRAME_BODY_NED
        if not body and m.coordinate_frame != common.MAV_FRAME_LOCAL_NED:
            self.statistics.refused_setpoints += 1
            text = f"SET_POSITION_TARGET_LOCAL_NED coordinate frame {m.coordinate_frame} unsupported"
            self._warn(text, text)
            self._say(Severity.CRITICAL, text)
            return
        mask = m.type_mask
        acceleration = _unmasked(fields[6:9], mask >> 6, together=body)
        if mask & _FORCE_SET and acceleration != UNSET:
            self.statistics.refused_setpoints += 1
            self._say(Severity.CRITICAL, "SET_POSITION_TARGET_LOCAL_NED force not supported")
            return
        self._offer(
            Setpoint(
                position=UNSET if body else _unmasked(fields[0:3], mask),
                velocity=_unmasked(fields[3:6], mask >> 3, together=body),
                acceleration=acceleration,
                yaw=NAN if mask & 1024 else m.yaw,
                yaw_rate=NAN if mask & 2048 else m.yaw_rate,
                body=body,
                time_boot_ms=m.time_boot_ms,
            )
        )

    def _attitude_target(self, channel: Channel, m, sender: Address) -> None:
        norm = math.sqrt(sum(component * component for component in m.q))
        use_attitude = not m.type_mask & _ATTITUDE_IGNORE
        if not self._is_for_us(channel, m) or (use_attitude and not 1e-3 < norm < 1e3):
            self.statistics.refused_setpoints += 1
            return
        rates = (m.body_roll_rate, m.body_pitch_rate, m.body_yaw_rate)
        self._offer(
            AttitudeSetpoint(
                attitude=tuple(component / norm for component in m.q) if use_attitude else None,
                rates=_unmasked(rates, m.type_mask),
                thrust=NAN if m.type_mask & _THROTTLE_IGNORE else m.thrust,
                time_boot_ms=m.time_boot_ms,
            )
        )

    def _offer(self, setpoint: Setpoint | AttitudeSetpoint) -> None:
        if self._px4.offer_setpoint(setpoint):
            self.statistics.setpoints += 1
            self.on_setpoint(setpoint.time_boot_ms)
        else:
            self.statistics.refused_setpoints += 1

    def _command_long(self, channel: Channel, m, sender: Address) -> None:
        if self._is_for_us(channel, m):
            params = (m.param1, m.param2, m.param3, m.param4, m.param5, m.param6, m.param7)
            self._command(channel, m, params, sender)

    def _command_int(self, channel: Channel, m, sender: Address) -> None:
        if self._is_for_us(channel, m):
            params = (m.param1, m.param2, m.param3, m.param4, 1e-7 * m.x, 1e-7 * m.y, m.z)
            self._command(channel, m, params, sender)

    def _set_mode(self, channel: Channel, m, sender: Address) -> None:
        if m.target_system not in (0, channel.codec.system_id):
            return
        main, sub = m.custom_mode >> _MAIN_SHIFT & 0xFF, m.custom_mode >> _SUB_SHIFT & 0xFF
        command = common.MAV_CMD_DO_SET_MODE
        result = self._px4.command(command, (m.base_mode, main, sub, 0.0, 0.0, 0.0, 0.0))
        self._acknowledge(channel, command, result, m, sender)

    def _command(self, channel: Channel, m, params: tuple[float, ...], sender: Address) -> None:
        """Carry out a command and acknowledge it; those about messages are the link's own."""
        handler = {
            common.MAV_CMD_REQUEST_MESSAGE: self._request_message,
            common.MAV_CMD_SET_MESSAGE_INTERVAL: self._set_message_interval,
            common.MAV_CMD_GET_MESSAGE_INTERVAL: self._get_message_interval,
            common.MAV_CMD_GET_HOME_POSITION: self._get_home,
            common.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES: self._get_capabilities,
        }.get(m.command)
        if handler is not None:
            after, result = handler(channel, params)
        else:
            after, result = None, self._px4.command(m.command, params)
        self._acknowledge(channel, m.command, result, m, sender)
        if after is not None:
            channel.reply(after, sender)

    @staticmethod
    def _acknowledge(channel: Channel, command: int, result: Result, m, sender: Address) -> None:
        ack = common.MAVLink_command_ack_message(
            command, int(result), 0, 0, m.get_srcSystem(), m.get_srcComponent()
        )
        channel.reply(ack, sender)

    def _request_message(self, channel: Channel, params: tuple[float, ...]):
        name = _message_name(params[0])
        message = telemetry.build(name, self._px4, self._px4.status) if telemetry.can_build(name) else None
        return message, Result.DENIED if message is None else Result.ACCEPTED

    def _set_message_interval(self, channel: Channel, params: tuple[float, ...]):
        done = channel.set_interval(_message_name(params[0]), params[1])
        return None, Result.ACCEPTED if done else Result.FAILED

    def _get_message_interval(self, channel: Channel, params: tuple[float, ...]):
        interval_us = channel.interval_us(_message_name(params[0]))
        if interval_us is None:
            return None, Result.FAILED
        return common.MAVLink_message_interval_message(int(params[0]), interval_us or -1), Result.ACCEPTED

    def _get_home(self, channel: Channel, params: tuple[float, ...]):
        message = telemetry.build("HOME_POSITION", self._px4, self._px4.status)
        return message, Result.DENIED if message is None else Result.ACCEPTED

    def _get_capabilities(self, channel: Channel, params: tuple[float, ...]):
        return telemetry.build("AUTOPILOT_VERSION", self._px4, self._px4.status), Result.ACCEPTED

    # Parameters, time and missions

    def _param_list(self, channel: Channel, m, sender: Address) -> None:
        if self._is_for_us(channel, m):
            for name in self._px4.parameters:
                channel.reply(self._param_value(name), sender)

    def _param_read(self, channel: Channel, m, sender: Address) -> None:
        parameters = self._px4.parameters
        name = parameters.name_at(m.param_index) if m.param_index >= 0 else decode_text(m.param_id)
        if self._is_for_us(channel, m) and name is not None and name in parameters:
            channel.reply(self._param_value(name), sender)

    def _param_set(self, channel: Channel, m, sender: Address) -> None:
        name = decode_text(m.param_id)
        if not self._is_for_us(channel, m) or name not in self._px4.parameters:
            return
        try:
            self._px4.parameters.set(name, parameter_from_wire(m.param_value, m.param_type))
        except (Px4Error, ValueError) as error:
            self._say(Severity.ERROR, f"parameter {name}: {error}")
        channel.reply(self._param_value(name), sender)

    def _param_value(self, name: str) -> common.MAVLink_message:
        parameters = self._px4.parameters
        is_integer = parameters.spec(name).is_integer
        return common.MAVLink_param_value_message(
            name.encode("ascii"),
            parameter_to_wire(parameters[name], is_integer),
            common.MAV_PARAM_TYPE_INT32 if is_integer else common.MAV_PARAM_TYPE_REAL32,
            len(parameters),
            parameters.index_of(name),
        )

    def _timesync(self, channel: Channel, m, sender: Address) -> None:
        if m.tc1 == 0:
            channel.reply(common.MAVLink_timesync_message(1000 * self._time_us, m.ts1), sender)

    def _mission_list(self, channel: Channel, m, sender: Address) -> None:
        if self._is_for_us(channel, m):
            count = common.MAVLink_mission_count_message(
                m.get_srcSystem(), m.get_srcComponent(), 0, m.mission_type
            )
            channel.reply(count, sender)

    # Words

    def _say(self, severity: Severity, text: str) -> None:
        """Tell every ground station; 50 bytes is all that one STATUSTEXT holds."""
        message = common.MAVLink_statustext_message(int(severity), text.encode("ascii", "replace")[:50])
        for channel in self._channels:
            channel.send_to_ground_stations(message)

    def _warn(self, kind: str, sentence: str) -> None:
        if kind not in self._warned:
            self._warned.add(kind)
            self.on_warning(sentence)


def _unmasked(values: tuple[float, ...], mask: int, together: bool = False) -> tuple[float, ...]:
    """Replace what the mask's lowest bits ignore by NaN; together: all of it when one is ignored."""
    if together and mask & 0b111:
        return UNSET
    return tuple(NAN if mask >> i & 1 else value for i, value in enumerate(values))


def _message_name(number: float) -> str:
    """Return the MAVLink name of a message number; empty when it is none."""
    if not math.isfinite(number):
        return ""
    kind = common.mavlink_map.get(int(number))
    return kind.msgname if kind else ""
