"""MAVROS's plugin `setpoint_raw`."""

from __future__ import annotations

from typing import Any

from geometry_msgs.msg import Point, Quaternion, Vector3
from mavros_msgs.msg import AttitudeTarget, GlobalPositionTarget, PositionTarget
from pymavlink.dialects.v20 import common
from std_msgs.msg import Header

from simulation_tools.mavros.conversions import attitude_target, global_target, position_target
from simulation_tools.ned_frames import attitude_to_enu, enu_to_ned, flu_to_frd, yaw_to_ned
from simulation_tools_ros.mavros.uas import Uas, number, stamp_from_ms


class SetpointRawPlugin:
    """Takes setpoint_raw/{local,global,attitude}; publishes PX4's targets: target_{local,global,attitude}.

    Parameter: ~setpoint_raw/thrust_scaling, factor of a thrust before it is clipped to 0..1.
    """

    def __init__(self, uas: Uas) -> None:
        self._uas = uas
        self._thrust_scaling = number("~setpoint_raw/thrust_scaling", 1.0)
        uas.subscribe("setpoint_raw/local", PositionTarget, self._on_local)
        uas.subscribe("setpoint_raw/global", GlobalPositionTarget, self._on_global)
        uas.subscribe("setpoint_raw/attitude", AttitudeTarget, self._on_attitude)
        self._local = uas.advertise("setpoint_raw/target_local", PositionTarget)
        self._global = uas.advertise("setpoint_raw/target_global", GlobalPositionTarget)
        self._attitude = uas.advertise("setpoint_raw/target_attitude", AttitudeTarget)
        client = uas.client
        client.on("POSITION_TARGET_LOCAL_NED", lambda m: self._local.publish(lambda: local_message(m)))
        client.on("POSITION_TARGET_GLOBAL_INT", lambda m: self._global.publish(lambda: global_message(m)))
        client.on("ATTITUDE_TARGET", lambda m: self._attitude.publish(lambda: attitude_message(m)))

    def _on_local(self, message: PositionTarget) -> None:
        self._uas.send_setpoint(
            "setpoint_raw/local",
            message.header,
            lambda ms: position_target(
                self._uas.client.target,
                ms,
                message.coordinate_frame,
                message.type_mask,
                _xyz(message.position),
                *_motion(message),
            ),
        )

    def _on_global(self, message: GlobalPositionTarget) -> None:
        place = (message.latitude, message.longitude, message.altitude)
        self._uas.send_setpoint(
            "setpoint_raw/global",
            message.header,
            lambda ms: global_target(
                self._uas.client.target,
                ms,
                message.coordinate_frame,
                message.type_mask,
                place,
                *_motion(message),
            ),
        )

    def _on_attitude(self, message: AttitudeTarget) -> None:
        q, w = message.orientation, message.body_rate
        thrust = self._thrust_scaling * message.thrust
        self._uas.send_setpoint(
            "setpoint_raw/attitude",
            message.header,
            lambda ms: attitude_target(
                self._uas.client.target, ms, message.type_mask, (q.x, q.y, q.z, q.w), (w.x, w.y, w.z), thrust
            ),
        )


def local_message(target: common.MAVLink_message) -> PositionTarget:
    """POSITION_TARGET_LOCAL_NED to PositionTarget, ENU; NaN where PX4 follows nothing."""
    return PositionTarget(
        header=Header(stamp=stamp_from_ms(target.time_boot_ms)),
        coordinate_frame=target.coordinate_frame,
        type_mask=target.type_mask,
        position=Point(*enu_to_ned((target.x, target.y, target.z))),
        **_motion_enu(target),
    )


def global_message(target: common.MAVLink_message) -> GlobalPositionTarget:
    """POSITION_TARGET_GLOBAL_INT to GlobalPositionTarget, ENU; the altitude as PX4 sends it."""
    return GlobalPositionTarget(
        header=Header(stamp=stamp_from_ms(target.time_boot_ms)),
        coordinate_frame=target.coordinate_frame,
        type_mask=target.type_mask,
        latitude=1e-7 * target.lat_int,
        longitude=1e-7 * target.lon_int,
        altitude=target.alt,
        **_motion_enu(target),
    )


def attitude_message(target: common.MAVLink_message) -> AttitudeTarget:
    """ATTITUDE_TARGET to AttitudeTarget: FLU in ENU, rates FLU."""
    rates = (target.body_roll_rate, target.body_pitch_rate, target.body_yaw_rate)
    return AttitudeTarget(
        header=Header(stamp=stamp_from_ms(target.time_boot_ms)),
        type_mask=target.type_mask,
        orientation=Quaternion(*attitude_to_enu(target.q)),
        body_rate=Vector3(*flu_to_frd(rates)),
        thrust=target.thrust,
    )


def _motion_enu(target: common.MAVLink_message) -> dict:
    """Return the common fields of both position targets."""
    return {
        "velocity": Vector3(*enu_to_ned((target.vx, target.vy, target.vz))),
        "acceleration_or_force": Vector3(*enu_to_ned((target.afx, target.afy, target.afz))),
        "yaw": yaw_to_ned(target.yaw),
        "yaw_rate": -target.yaw_rate,
    }


def _motion(message: Any) -> tuple:
    """Return the common fields of both position setpoints, as arguments of the conversions."""
    velocity, acceleration = _xyz(message.velocity), _xyz(message.acceleration_or_force)
    return velocity, acceleration, message.yaw, message.yaw_rate


def _xyz(vector: Any) -> tuple[float, float, float]:
    return vector.x, vector.y, vector.z
