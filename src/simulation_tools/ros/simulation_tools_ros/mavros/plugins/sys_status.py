"""MAVROS's plugin `sys_status`: connection, state, mode, battery and status texts."""

from __future__ import annotations

import math
from collections import deque

import rospy
from diagnostic_msgs.msg import DiagnosticArray
from mavros_msgs import srv
from mavros_msgs.msg import EstimatorStatus, ExtendedState, State, StatusText, SysStatus
from pymavlink.dialects.v20 import common
from sensor_msgs.msg import BatteryState
from std_msgs.msg import Header

from simulation_tools.mavlink import decode_text
from simulation_tools_ros.mavros import diagnostics as diagnose
from simulation_tools_ros.mavros.battery import battery_message, system_battery_message
from simulation_tools_ros.mavros.uas import Heard, Uas

DIAGNOSTICS_PERIOD_S = 1.0
_HEARTBEATS_KEPT = 10
_ARMED, _GUIDED, _MANUAL = 128, 8, 64
_SET_MESSAGE_INTERVAL, _ACCEPTED = 511, 0


class SysStatusPlugin:
    """Publishes state (latched), extended_state, sys_status, battery, estimator_status, statustext/recv.

    It also publishes /diagnostics. Serves set_mode, set_stream_rate, set_message_interval. Parameter:
    ~conn/heartbeat_rate.
    """

    def __init__(self, uas: Uas) -> None:
        self._uas = uas
        self._client = uas.client
        self._heartbeats_s: deque[float] = deque(maxlen=_HEARTBEATS_KEPT)
        self._heartbeat_count = 0
        self._published_state: tuple | None = None
        self._heard: Heard | None = None  # belongs to the next two fields
        self._sys_status = None
        self._battery_status = None
        self._advertise()
        for name, handler in (
            ("HEARTBEAT", self._on_heartbeat),
            ("EXTENDED_SYS_STATE", self._on_extended_state),
            ("SYS_STATUS", self._on_sys_status),
            ("BATTERY_STATUS", self._on_battery),
            ("ESTIMATOR_STATUS", self._on_estimator),
            ("STATUSTEXT", self._on_status_text),
        ):
            uas.client.on(name, handler)
        uas.serve("set_mode", srv.SetMode, self._on_set_mode)
        uas.serve("set_stream_rate", srv.StreamRate, self._on_stream_rate)
        uas.serve("set_message_interval", srv.MessageInterval, self._on_message_interval)
        self._publish_state()
        uas.every(1.0 / max(float(rospy.get_param("~conn/heartbeat_rate", 1.0)), 0.1), self._send_heartbeat)
        uas.every(DIAGNOSTICS_PERIOD_S, self._publish_diagnostics)

    def _advertise(self) -> None:
        advertise = self._uas.advertise
        self._state = advertise("state", State, latch=True)
        self._extended_state = advertise("extended_state", ExtendedState)
        self._status = advertise("sys_status", SysStatus)
        self._battery = advertise("battery", BatteryState)
        self._estimator = advertise("estimator_status", EstimatorStatus)
        self._status_text = advertise("statustext/recv", StatusText)
        self._diagnostics = rospy.Publisher("/diagnostics", DiagnosticArray, queue_size=10)

    # Connection and state

    def _send_heartbeat(self, _now_s: float) -> None:
        self._client.send_heartbeat()
        self._publish_state(only_changes=True)

    def _on_heartbeat(self, message: common.MAVLink_message) -> None:
        self._forget_if_reset()
        self._uas.heard.heartbeat = message
        self._heartbeat_count += 1
        self._heartbeats_s.append(rospy.get_time())
        self._publish_state()

    def _publish_state(self, only_changes: bool = False) -> None:
        """Publish the state with each heartbeat, and when the heartbeats stop."""
        message = self._state_message()
        content = (message.connected, message.armed, message.mode, message.system_status)
        if only_changes and content == self._published_state:
            return
        was_connected = bool(self._published_state and self._published_state[0])
        self._published_state = content
        if message.connected and not was_connected:
            rospy.loginfo("Connected to the flight controller.")
            self._uas.connected()
        elif was_connected and not message.connected:
            rospy.logerr("The flight controller's heartbeats have stopped.")
        self._state.publish(lambda: message)

    def _state_message(self) -> State:
        message = State(header=Header(stamp=self._uas.now), connected=self._client.connected)
        heartbeat = self._uas.heard.heartbeat
        if heartbeat is not None:
            message.armed = bool(heartbeat.base_mode & _ARMED)
            message.guided = bool(heartbeat.base_mode & _GUIDED)
            message.manual_input = bool(heartbeat.base_mode & _MANUAL)
            message.mode = self._client.stack.mode_name(heartbeat.custom_mode)
            message.system_status = heartbeat.system_status
        return message

    def _on_extended_state(self, message: common.MAVLink_message) -> None:
        self._extended_state.publish(
            lambda: ExtendedState(self._header(), message.vtol_state, message.landed_state)
        )

    # Health

    def _on_sys_status(self, message: common.MAVLink_message) -> None:
        self._forget_if_reset()
        self._sys_status = message
        self._status.publish(lambda: sys_status_message(message, self._header()))
        if self._battery_status is None:
            self._battery.publish(lambda: system_battery_message(message, self._header()))

    def _on_battery(self, message: common.MAVLink_message) -> None:
        self._forget_if_reset()
        if message.id == 0:
            self._battery_status = message
        self._battery.publish(lambda: battery_message(message, self._header()))

    def _on_estimator(self, message: common.MAVLink_message) -> None:
        self._estimator.publish(
            lambda: EstimatorStatus(self._header(), *(bool(message.flags >> bit & 1) for bit in range(12)))
        )

    def _publish_diagnostics(self, _now_s: float) -> None:
        now_s = rospy.get_time()
        statuses = (
            diagnose.connection(self._client),
            diagnose.heartbeats(self._uas.heard.heartbeat, self._heartbeat_count, self._heartbeats_s, now_s),
            diagnose.system(self._sys_status),
            diagnose.battery(self._sys_status),
        )
        self._diagnostics.publish(diagnose.array(statuses, self._client, rospy.get_rostime()))

    def _on_status_text(self, message: common.MAVLink_message) -> None:
        text = StatusText(self._header(), message.severity, decode_text(message.text))
        log = rospy.logerr if text.severity <= StatusText.ERROR else rospy.loginfo
        log(f"FCU: {text.text}")
        self._status_text.publish(lambda: text)

    # Requests

    def _on_set_mode(self, request: srv.SetModeRequest) -> srv.SetModeResponse:
        custom: int | None = 0
        if request.custom_mode:
            custom = self._client.stack.custom_mode(request.custom_mode)
        if custom is None:
            rospy.logerr(f"{self._client.stack.name} has no mode {request.custom_mode!r}.")
            return srv.SetModeResponse(mode_sent=False)
        self._client.set_mode(request.base_mode, custom)
        return srv.SetModeResponse(mode_sent=True)

    def _on_stream_rate(self, request: srv.StreamRateRequest) -> srv.StreamRateResponse:
        rospy.logwarn_once(
            "PX4 does not act on set_stream_rate (REQUEST_DATA_STREAM): use set_message_interval."
        )
        target = self._client.target
        self._client.send(
            common.MAVLink_request_data_stream_message(
                target.system_id,
                target.component_id,
                request.stream_id,
                request.message_rate,
                int(request.on_off),
            )
        )
        return srv.StreamRateResponse()

    def _on_message_interval(self, request: srv.MessageIntervalRequest) -> srv.MessageIntervalResponse:
        """Unlike MAVROS, return PX4's own answer: false for a message that it does not stream."""
        rate_hz = request.message_rate
        if not math.isfinite(rate_hz):
            rospy.logwarn(f"set_message_interval is refused: {rate_hz} is not a rate.")
            return srv.MessageIntervalResponse(success=False)
        interval_us = 1e6 / rate_hz if rate_hz > 0.0 else -1.0 if rate_hz < 0.0 else 0.0
        result = self._client.command(_SET_MESSAGE_INTERVAL, float(request.message_id), min(interval_us, 1e9))
        if result != _ACCEPTED:
            why = "does not answer" if result is None else f"refuses (MAV_RESULT {result})"
            rospy.logwarn(f"set_message_interval: the flight controller {why} message {request.message_id}.")
        return srv.MessageIntervalResponse(success=result == _ACCEPTED)

    def _forget_if_reset(self) -> None:
        if self._heard is not self._uas.heard:
            self._heard = self._uas.heard
            self._heartbeats_s.clear()
            self._sys_status = self._battery_status = None

    def _header(self) -> Header:
        return Header(stamp=self._uas.now)


def sys_status_message(status: common.MAVLink_message, header: Header) -> SysStatus:
    """SYS_STATUS to SysStatus."""
    return SysStatus(
        header=header,
        sensors_present=status.onboard_control_sensors_present,
        sensors_enabled=status.onboard_control_sensors_enabled,
        sensors_health=status.onboard_control_sensors_health,
        load=status.load,
        voltage_battery=status.voltage_battery,
        current_battery=status.current_battery,
        battery_remaining=status.battery_remaining,
        drop_rate_comm=status.drop_rate_comm,
        errors_comm=status.errors_comm,
        errors_count1=status.errors_count1,
        errors_count2=status.errors_count2,
        errors_count3=status.errors_count3,
        errors_count4=status.errors_count4,
    )
