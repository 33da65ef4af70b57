"""The flight controller's MAVLink side: UDP ports for the offboard API and for ground stations.

Port conventions of PX4 SITL: the offboard API is bound to 14580 and talks to 14540 (MAVROS:
``udp://:14540@``), the ground station's to 18570 and talks to 14550. Any other client that sends a heartbeat
to either port is served as well. All times are simulation time.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import Callable

from pymavlink.dialects.v20 import common

from simulation_tools.mavlink import Address, wait_readable
from simulation_tools.px4.mavlink import telemetry
from simulation_tools.px4.mavlink.channel import Channel
from simulation_tools.px4.mavlink.external_estimates import ExternalEstimates
from simulation_tools.px4.mavlink.file_transfer import refuse_file_transfer
from simulation_tools.px4.mavlink.message_commands import MessageCommands
from simulation_tools.px4.mavlink.missions.protocol import MissionProtocol, UploadLock
from simulation_tools.px4.mavlink.missions.status import MissionStatus
from simulation_tools.px4.mavlink.parameter_protocol import ParameterProtocol
from simulation_tools.px4.mavlink.setpoint_messages import (
    SetpointError,
    from_attitude_target,
    from_global_target,
    from_local_target,
)
from simulation_tools.px4.modes import Result, Severity
from simulation_tools.px4.px4 import Px4
from simulation_tools.px4.setpoint import AttitudeSetpoint, Setpoint
from simulation_tools.px4_ports import GCS_PORT, MAVROS_PORT, own_ports

# The types of PX4's custom mode live in the upper bytes of custom_mode.
_MAIN_SHIFT, _SUB_SHIFT = 16, 24
_TEXT_CHUNK, _TEXT_MAX = 50, 126  # bytes of a STATUSTEXT, and of a text of PX4
NO_ANSWER = (255, 190)
"""System and component that a PING is for which only says: I am there. Nobody answers one for another."""
_ORDERS = "SET_MODE", "COMMAND_LONG", "COMMAND_INT"
_NOT_GIVEN = (0x7FF80000, 0x7FFFFFFF)  # latitude or longitude of COMMAND_INT


@dataclass
class LinkStatistics:
    """Counts of received messages."""

    messages: int = 0
    setpoints: int = 0
    refused_setpoints: int = 0
    bad_packets: int = 0


class MavlinkLink:
    """Connects a `Px4` with its clients. Not thread-safe: only the thread that steps the Px4 may call it.

    `on_setpoint` is called for each accepted setpoint with its `time_boot_ms`, `on_external_pose` for each
    external pose. `on_warning` is called once per kind of trouble, with a sentence.
    """

    def __init__(
        self,
        px4: Px4,
        offboard_port: int = MAVROS_PORT,
        gcs_port: int = GCS_PORT,
        host: str = "127.0.0.1",
        offboard_local_port: int | None = None,
        gcs_local_port: int | None = None,
    ) -> None:
        """Open both ports; raises LinkError when one is taken.

        offboard_port, gcs_port: where the clients listen; 0: answer only clients that send heartbeats.
        Local ports: by default PX4's, 14580 and 18570, moved by as much as the clients'; 0: a free one.
        """
        own_offboard_port, own_gcs_port = own_ports(offboard_port, gcs_port)
        if offboard_local_port is None:
            offboard_local_port = own_offboard_port
        if gcs_local_port is None:
            gcs_local_port = own_gcs_port
        self._px4 = px4
        self._time_us = 0
        self.statistics = LinkStatistics()
        self.on_setpoint: Callable[[int], None] = lambda time_boot_ms: None
        self.on_external_pose: Callable[[int], None] = lambda time_boot_ms: None
        self.on_warning: Callable[[str], None] = lambda sentence: None
        self._kept: deque[tuple[Channel, common.MAVLink_message, Address]] = deque()
        self._warned: set[str] = set()
        self._text_id = 0
        rates_hz = telemetry.OFFBOARD_RATES_HZ
        self.offboard = Channel(
            px4, host, offboard_local_port, offboard_port, rates_hz, True, "the offboard API"
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
        self._message_commands = MessageCommands(px4)
        self._parameter_protocol = ParameterProtocol(px4.parameters, self._say)
        self._answers = {
            "PARAM_REQUEST_READ": self._parameter_protocol.read,
            "PARAM_SET": self._parameter_protocol.set,
            "FILE_TRANSFER_PROTOCOL": refuse_file_transfer,
        }
        self._estimates = ExternalEstimates(px4, self._warn)
        lock = UploadLock()
        self._missions = {
            channel: MissionProtocol(px4.plan, lock, channel.codec.identity, self._say)
            for channel in self._channels
        }
        self._mission_status = MissionStatus(px4.plan, px4.mission)
        self._handlers = self._handlers_by_type()

    def _handlers_by_type(self) -> dict[str, Callable[[Channel, common.MAVLink_message, Address], None]]:
        return {
            "HEARTBEAT": self._heartbeat,
            "SET_POSITION_TARGET_LOCAL_NED": self._local_target,
            "SET_POSITION_TARGET_GLOBAL_INT": self._global_target,
            "SET_ATTITUDE_TARGET": self._attitude_target,
            "COMMAND_LONG": self._command_long,
            "COMMAND_INT": self._command_int,
            "SET_MODE": self._set_mode,
            "PARAM_REQUEST_LIST": self._param_list,
            "TIMESYNC": self._timesync,
            "PING": self._ping,
            "RC_CHANNELS_OVERRIDE": self._rc_override,
            **dict.fromkeys(self._answers, self._answer),
            **dict.fromkeys(self._estimates.handlers, self._estimate),
            **dict.fromkeys(self._missions[self.offboard].messages, self._mission),
        }

    def poll(self, time_us: int, until: Callable[[], bool] = lambda: False) -> None:
        """Handle every message that has arrived, without waiting.

        time_us: simulation time now. until: called after each datagram. If it returns True, the rest stays
        unread until the next call. So a simulator in lockstep reads no further than the setpoint that it
        waits for.
        """
        self._time_us = time_us
        while self._kept:
            self._handle(*self._kept.popleft())
            if until():
                return
        for channel in self._channels:
            for message, sender in channel.receive(until):
                self._handle(channel, message, sender)
        bad = sum(channel.codec.bad for channel in self._channels)
        if bad > self.statistics.bad_packets:
            self.statistics.bad_packets = bad
            self._warn("bad", "MAVLink: received data that is not a valid MAVLink 2 message; it is ignored")

    def take_orders(self, time_us: int) -> None:
        """Carry out the orders that have arrived, and keep all else for the next `poll`."""
        self._time_us = time_us
        for channel in self._channels:
            for received in channel.receive(lambda: False):
                if received[0].get_type() in _ORDERS:
                    self._handle(channel, *received)
                else:
                    self._kept.append((channel, *received))

    def _handle(self, channel: Channel, message: common.MAVLink_message, sender: Address) -> None:
        self.statistics.messages += 1
        handler = self._handlers.get(message.get_type())
        if handler is not None:
            handler(channel, message, sender)

    def send_due(self, time_us: int) -> None:
        """Send the streamed messages that are due at this simulation time."""
        status = list(self._mission_status.due(time_us))
        for channel in self._channels:
            channel.send_due(time_us)
            channel.send_to_peers(status)
            repeated = self._missions[channel].due(time_us)
            if repeated is not None:
                channel.reply(*repeated)

    def hold(self) -> None:
        """Keep streamed messages until `flush` from now on. Answers do not wait."""
        for channel in self._channels:
            channel.holds = True

    def flush(self) -> None:
        """Send the streamed messages that were kept."""
        for channel in self._channels:
            channel.flush()

    def wait(self, timeout_s: float) -> bool:
        """Wait, in wall time, until there is something to `poll`; returns whether there is."""
        return bool(self._kept) or wait_readable(self._sockets, timeout_s)

    def keep_alive(self) -> None:
        """Tell all clients that the flight controller is there, though simulation time stands still."""
        self.offboard.send_to_peers([common.MAVLink_ping_message(self._time_us, 0, *NO_ANSWER)])

    def reset(self) -> None:
        """Start again after simulation time has jumped back."""
        self._kept.clear()
        for channel in self._channels:
            channel.reset()
        self._mission_status.reset()

    def close(self) -> None:
        """Release the ports."""
        for channel in self._channels:
            channel.close()
        self._px4.on_statustext = lambda severity, text: None

    # Received messages

    def _heartbeat(self, channel: Channel, message: common.MAVLink_message, sender: Address) -> None:
        is_ground_station = message.type == common.MAV_TYPE_GCS
        channel.heard(sender, is_ground_station)
        if is_ground_station:
            self._px4.ground_station_heard()

    def _is_for_us(self, channel: Channel, message: common.MAVLink_message) -> bool:
        return message.target_system in (0, channel.codec.system_id) and message.target_component in (
            0,
            channel.codec.component_id,
        )

    def _local_target(self, channel: Channel, m: common.MAVLink_message, sender: Address) -> None:
        self._offer(channel, m, lambda: from_local_target(m))

    def _global_target(self, channel: Channel, m: common.MAVLink_message, sender: Address) -> None:
        origin, home = self._px4.origin, self._px4.home
        if home is None or not self._px4.has_gnss:
            self.statistics.refused_setpoints += 1  # without a position there is nothing to convert
            return
        self._offer(channel, m, lambda: from_global_target(m, origin, home.tolist()))

    def _attitude_target(self, channel: Channel, m: common.MAVLink_message, sender: Address) -> None:
        self._offer(channel, m, lambda: from_attitude_target(m))

    def _offer(
        self, channel: Channel, m: common.MAVLink_message, read: Callable[[], Setpoint | AttitudeSetpoint]
    ) -> None:
        """Pass a setpoint on, if the message holds one and is addressed to us."""
        try:
            if self._is_for_us(channel, m) and self._px4.offer_setpoint(read()):
                self.statistics.setpoints += 1
                self.on_setpoint(m.time_boot_ms)
                return
        except SetpointError as refusal:
            if str(refusal):
                self._warn(str(refusal), str(refusal))
                self._say(Severity.CRITICAL, str(refusal))
        self.statistics.refused_setpoints += 1

    def _command_is_for_us(self, channel: Channel, m: common.MAVLink_message) -> bool:
        """Unlike other messages, a command to all systems (0) counts only if it asks for identification."""
        to_all = m.target_system == 0 and m.command != common.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES
        return not to_all and self._is_for_us(channel, m)

    def _command_long(self, channel: Channel, m: common.MAVLink_message, sender: Address) -> None:
        if self._command_is_for_us(channel, m):
            params = (m.param1, m.param2, m.param3, m.param4, m.param5, m.param6, m.param7)
            self._command(channel, m, params, sender)

    def _command_int(self, channel: Channel, m: common.MAVLink_message, sender: Address) -> None:
        if self._command_is_for_us(channel, m):
            latitude, longitude = (math.nan if value in _NOT_GIVEN else 1e-7 * value for value in (m.x, m.y))
            params = (m.param1, m.param2, m.param3, m.param4, latitude, longitude, m.z)
            self._command(channel, m, params, sender)

    def _set_mode(self, channel: Channel, m: common.MAVLink_message, sender: Address) -> None:
        if m.target_system != channel.codec.system_id:
            return
        main, sub = m.custom_mode >> _MAIN_SHIFT & 0xFF, m.custom_mode >> _SUB_SHIFT & 0xFF
        command = common.MAV_CMD_DO_SET_MODE
        result = self._px4.command(command, (m.base_mode, main, sub, 0.0, 0.0, 0.0, 0.0))
        self._acknowledge(channel, command, result, m, sender)

    def _command(
        self, channel: Channel, m: common.MAVLink_message, params: tuple[float, ...], sender: Address
    ) -> None:
        """Carry out a command and acknowledge it. Then send the message that it asks for."""
        after = None
        if self._message_commands.handles(m.command):
            after, result = self._message_commands.handle(channel, m.command, params)
        else:
            result = self._px4.command(m.command, params)
        self._acknowledge(channel, m.command, result, m, sender)
        if after is not None:
            channel.reply(after, sender)

    @staticmethod
    def _acknowledge(
        channel: Channel, command: int, result: Result, m: common.MAVLink_message, sender: Address
    ) -> None:
        ack = common.MAVLink_command_ack_message(
            command, int(result), 0, 0, m.get_srcSystem(), m.get_srcComponent()
        )
        channel.reply(ack, sender)

    def _param_list(self, channel: Channel, m: common.MAVLink_message, sender: Address) -> None:
        if self._is_for_us(channel, m):
            for answer in self._parameter_protocol.list():
                channel.reply(answer, sender)

    def _answer(self, channel: Channel, m: common.MAVLink_message, sender: Address) -> None:
        answer = self._answers[m.get_type()](m) if self._is_for_us(channel, m) else None
        if answer is not None:
            channel.reply(answer, sender)

    def _rc_override(self, channel: Channel, m: common.MAVLink_message, sender: Address) -> None:
        """Warn once that there is no remote control here. Real PX4 would fly by it."""
        if self._is_for_us(channel, m):
            self._warn(
                "rc", "MAVLink: RC_CHANNELS_OVERRIDE is ignored; the PX4 stand-in has no remote control"
            )

    def _timesync(self, channel: Channel, m: common.MAVLink_message, sender: Address) -> None:
        answer = channel.clock.hear(m, self._time_us)
        if answer is not None:
            channel.reply(answer, sender)

    def _estimate(self, channel: Channel, m: common.MAVLink_message, sender: Address) -> None:
        stamp_us = self._estimates.handle(m, channel.clock, self._time_us)
        if m.get_type() != "DISTANCE_SENSOR":
            self.on_external_pose(stamp_us // 1000)

    def _ping(self, channel: Channel, m: common.MAVLink_message, sender: Address) -> None:
        if m.target_system == 0 and m.target_component == 0:
            source = (m.get_srcSystem(), m.get_srcComponent())
            channel.reply(common.MAVLink_ping_message(m.time_usec, m.seq, *source), sender)

    def _mission(self, channel: Channel, m: common.MAVLink_message, sender: Address) -> None:
        answer = self._missions[channel].handle(m, sender, self._time_us)
        if answer is not None:
            channel.reply(answer, sender)

    # Status texts

    def _say(self, severity: Severity, text: str) -> None:
        """Tell every ground station. A long text goes out in chunks with the same id."""
        self._text_id = self._text_id % 0xFFFF + 1
        data = text.encode("ascii", "replace")[:_TEXT_MAX]
        for chunk, start in enumerate(range(0, max(len(data), 1), _TEXT_CHUNK)):
            part = data[start : start + _TEXT_CHUNK]
            message = common.MAVLink_statustext_message(int(severity), part, self._text_id, chunk)
            for channel in self._channels:
                channel.send_to_ground_stations(message)

    def _warn(self, kind: str, sentence: str) -> None:
        if kind not in self._warned:
            self._warned.add(kind)
            self.on_warning(sentence)
