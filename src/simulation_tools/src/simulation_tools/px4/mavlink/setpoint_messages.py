"""MAVLink's SET_*_TARGET messages as setpoints: frames and type masks as PX4 reads them."""

from __future__ import annotations

import math
from typing import Sequence

from pymavlink.dialects.v20 import common

from simulation_tools.autopilot import Px4Error
from simulation_tools.bounds import MAX_MAGNITUDE
from simulation_tools.geodesy import GeodeticOrigin
from simulation_tools.geometry import Vector3
from simulation_tools.px4.setpoint import NAN, UNSET, AttitudeSetpoint, Setpoint

_FORCE_SET, _YAW_IGNORE, _YAW_RATE_IGNORE = 512, 1024, 2048
_ATTITUDE_IGNORE, _THROTTLE_IGNORE = 128, 64


class SetpointError(Px4Error):
    """A message is not a setpoint. The text is PX4's status text for ground stations; empty: no text."""


def from_local_target(m: common.MAVLink_set_position_target_local_ned_message) -> Setpoint:
    """Read SET_POSITION_TARGET_LOCAL_NED in LOCAL_NED or BODY_NED; raises SetpointError."""
    body = m.coordinate_frame == common.MAV_FRAME_BODY_NED
    if not body and m.coordinate_frame != common.MAV_FRAME_LOCAL_NED:
        raise SetpointError(
            f"SET_POSITION_TARGET_LOCAL_NED coordinate frame {m.coordinate_frame} unsupported"
        )
    position = UNSET if body else _unmasked((m.x, m.y, m.z), m.type_mask)
    return _setpoint(m, position, body, "SET_POSITION_TARGET_LOCAL_NED")


def from_global_target(
    m: common.MAVLink_set_position_target_global_int_message, origin: GeodeticOrigin, home: Sequence[float]
) -> Setpoint:
    """Read SET_POSITION_TARGET_GLOBAL_INT, altitude over sea or over home (NED); raises SetpointError.

    If any axis of the position is masked, the whole position is ignored.
    """
    position = UNSET
    if not m.type_mask & 0b111:
        down = {
            common.MAV_FRAME_GLOBAL_INT: origin.altitude_m - m.alt,
            common.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT: home[2] - m.alt,
        }.get(m.coordinate_frame)
        if down is None:
            raise SetpointError(
                f"SET_POSITION_TARGET_GLOBAL_INT invalid coordinate frame {m.coordinate_frame}"
            )
        latitude, longitude = 1e-7 * m.lat_int, 1e-7 * m.lon_int
        if abs(latitude) > 90.0 or abs(longitude) > 180.0:
            raise SetpointError("SET_POSITION_TARGET_GLOBAL_INT invalid latitude or longitude")
        position = (*origin.to_local(latitude, longitude), _sane(down))
    return _setpoint(m, position, False, "SET_POSITION_TARGET_GLOBAL_INT")


def from_attitude_target(m: common.MAVLink_set_attitude_target_message) -> AttitudeSetpoint:
    """Read SET_ATTITUDE_TARGET; raises SetpointError for a quaternion that is not a rotation."""
    norm = math.sqrt(sum(component * component for component in m.q))
    use_attitude = not m.type_mask & _ATTITUDE_IGNORE
    if use_attitude and not 1e-3 < norm < 1e3:  # true for NaN, too
        raise SetpointError("")
    return AttitudeSetpoint(
        attitude=tuple(component / norm for component in m.q) if use_attitude else None,
        rates=_unmasked((m.body_roll_rate, m.body_pitch_rate, m.body_yaw_rate), m.type_mask),
        thrust=NAN if m.type_mask & _THROTTLE_IGNORE else m.thrust,
        time_boot_ms=m.time_boot_ms,
    )


def _setpoint(m: common.MAVLink_message, position: Vector3, body: bool, name: str) -> Setpoint:
    """Read the common fields of both position messages; raises SetpointError."""
    mask = m.type_mask
    acceleration = _unmasked((m.afx, m.afy, m.afz), mask >> 6, together=body)
    if mask & _FORCE_SET and acceleration != UNSET:
        raise SetpointError(f"{name} force not supported")
    return Setpoint(
        position=position,
        velocity=_unmasked((m.vx, m.vy, m.vz), mask >> 3, together=body),
        acceleration=acceleration,
        yaw=_heading(m.yaw, mask & _YAW_IGNORE),
        yaw_rate=_heading(m.yaw_rate, mask & _YAW_RATE_IGNORE),
        body=body,
        time_boot_ms=m.time_boot_ms,
    )


def _unmasked(values: Vector3, mask: int, together: bool = False) -> Vector3:
    """Replace values that the mask's lowest bits ignore by NaN; together: one ignored value makes all NaN."""
    if together and mask & 0b111:
        return UNSET
    x, y, z = (NAN if mask >> i & 1 else _sane(value) for i, value in enumerate(values))
    return x, y, z


def _heading(value: float, is_masked: int) -> float:
    """Return a yaw or its rate. NaN asks for none, as a mask does."""
    return NAN if is_masked or math.isnan(value) else _sane(value)


def _sane(value: float) -> float:
    """Return a number that can be a length, speed or angle of a world; raises SetpointError, with NaN too."""
    if not abs(value) <= MAX_MAGNITUDE:
        raise SetpointError("")
    return value
