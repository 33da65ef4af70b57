"""MAVROS's entries in /diagnostics, by its names. Message classes only: no node, no rospy."""

from __future__ import annotations

from typing import Sequence

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from genpy import Time
from pymavlink.dialects.v20 import common
from std_msgs.msg import Header

from simulation_tools.mavros.client import FcuClient
from simulation_tools.mavros.stacks import stack_of

OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR
_LOWEST_HZ, _LOWEST_BATTERY = 0.2, 0.15


def array(statuses: Sequence[DiagnosticStatus], client: FcuClient, stamp: Time) -> DiagnosticArray:
    """Return the message; each entry carries the flight controller's address."""
    for status in statuses:
        status.hardware_id = client.url
    return DiagnosticArray(Header(stamp=stamp), list(statuses))


def connection(client: FcuClient) -> DiagnosticStatus:
    """Whether the flight controller is there."""
    level, text = (OK, "connected") if client.connected else (ERROR, "not connected")
    values = {"Received packets": client.packets, "Parse errors": client.bad_packets}
    return _status("FCU connection", level, text, values)


def heartbeats(
    heartbeat: common.MAVLink_message, count: int, arrivals_s: Sequence[float], now_s: float
) -> DiagnosticStatus:
    """Report the rate of heartbeats. arrivals_s: ROS time of the newest ones; now_s: ROS time now."""
    window_s = now_s - arrivals_s[0] if arrivals_s else 0.0
    rate_hz = len(arrivals_s) / window_s if window_s > 0.0 else 0.0
    values = {"Heartbeats since startup": count, "Frequency (Hz)": f"{rate_hz:.3f}"}
    if heartbeat is None:
        return _status("Heartbeat", ERROR, "No events recorded.", values)
    values.update({"Vehicle type": heartbeat.type, "Autopilot type": heartbeat.autopilot})
    mode = stack_of(heartbeat.autopilot).mode_name(heartbeat.custom_mode)
    values.update({"Mode": mode, "System status": heartbeat.system_status})
    level, text = (OK, "Normal") if rate_hz >= _LOWEST_HZ else (WARN, "Frequency too low.")
    return _status("Heartbeat", level, text, values)


def system(status: common.MAVLink_message) -> DiagnosticStatus:
    """SYS_STATUS's sensors (None: not heard yet)."""
    if status is None:
        return _status("System", WARN, "No SYS_STATUS yet", {})
    present, enabled, health = (
        getattr(status, f"onboard_control_sensors_{what}") for what in ("present", "enabled", "health")
    )
    values = {
        "Sensor present": f"0x{present:08X}",
        "Sensor enabled": f"0x{enabled:08X}",
        "Sensor health": f"0x{health:08X}",
        "CPU Load (%)": f"{0.1 * status.load:.1f}",
        "Drop rate (%)": f"{0.01 * status.drop_rate_comm:.1f}",
    }
    ill = enabled & ~health
    level, text = (ERROR, "Sensor health") if ill else (OK, "Normal")
    return _status("System", level, text, values)


def battery(status: common.MAVLink_message) -> DiagnosticStatus:
    """SYS_STATUS's battery (None: not heard yet)."""
    if status is None or status.battery_remaining < 0:
        return _status("Battery", WARN, "No data", {})
    values = {
        "Voltage": f"{1e-3 * status.voltage_battery:.2f}",
        "Current": f"{1e-2 * status.current_battery:.1f}",
        "Remaining": f"{status.battery_remaining:.1f}",
    }
    low = 1e-2 * status.battery_remaining <= _LOWEST_BATTERY
    level, text = (WARN, "Low voltage") if low else (OK, "Normal")
    return _status("Battery", level, text, values)


def _status(name: str, level: int, text: str, values: dict) -> DiagnosticStatus:
    return DiagnosticStatus(
        level=level,
        name=f"mavros: {name}",
        message=text,
        values=[KeyValue(key, str(value)) for key, value in values.items()],
    )
