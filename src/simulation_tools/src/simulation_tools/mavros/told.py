"""MAVROS's conversions of what a client tells: scans, motion capture, texts, sticks, gimbals."""

from __future__ import annotations

import math
from typing import NamedTuple, Sequence

from pymavlink.dialects.v20 import common

from simulation_tools.bounds import fit_float32
from simulation_tools.mavros.conversions import Target, require_finite
from simulation_tools.ned_frames import attitude_to_ned, enu_to_ned

SECTORS = 72
"""Of OBSTACLE_DISTANCE."""
UNKNOWN_CM = 65535
FRAMES = {
    "GLOBAL": common.MAV_FRAME_GLOBAL,
    "LOCAL_NED": common.MAV_FRAME_LOCAL_NED,
    "BODY_FRD": common.MAV_FRAME_BODY_FRD,
}
"""Of OBSTACLE_DISTANCE, by MAVROS's names. The angles of GLOBAL begin in the north."""
TEXT_BYTES = 50
"""Of STATUSTEXT."""
_INT16 = range(-(2**15), 2**15)


class Scan(NamedTuple):
    """A sensor_msgs/LaserScan: ranges in m, by REP-117, clockwise from angle_min, rad."""

    ranges: Sequence[float]
    angle_min: float
    increment: float
    range_min: float
    range_max: float


def obstacle_distance(time_us: int, scan: Scan, frame: int) -> common.MAVLink_message:
    """Build OBSTACLE_DISTANCE as MAVROS does: where beams share a sector, the nearest counts.

    Raises ValueError, one sentence, for angles or limits that are no numbers.
    """
    numbers = (scan.angle_min, scan.increment, scan.range_min, scan.range_max)
    if not (math.isfinite(scan.angle_min + scan.increment) and all(one == one for one in numbers)):
        raise ValueError("its angles or its limits are no numbers")
    beams = len(scan.ranges)
    share = max(beams / SECTORS, 1.0)
    distances = [UNKNOWN_CM] * SECTORS
    for sector in range(min(beams, SECTORS)):
        first = math.floor(sector * share)
        last = min(max(math.ceil((sector + 1) * share), first + 1), beams)
        for distance_m in scan.ranges[first:last]:
            distances[sector] = min(distances[sector], _centimetres(distance_m))
    increment_deg = math.degrees(scan.increment) * share
    return common.MAVLink_obstacle_distance_message(
        time_us,
        common.MAV_DISTANCE_SENSOR_LASER,
        distances,
        min(int(abs(increment_deg) + 0.5), 255),
        _centimetres(scan.range_min),
        _centimetres(scan.range_max),
        increment_deg,
        math.degrees(scan.angle_min),
        frame,
    )


def _centimetres(distance_m: float) -> int:
    """Return a distance in cm; `UNKNOWN_CM` for one that is none, or too far."""
    cm = 100.0 * distance_m
    return int(cm) if 0.0 <= cm < UNKNOWN_CM else UNKNOWN_CM


def mocap_estimate(
    time_us: int, position: Sequence[float], orientation_xyzw: Sequence[float]
) -> common.MAVLink_message:
    """Build ATT_POS_MOCAP from a pose of FLU in ENU.

    Raises ValueError, one sentence, for a number beyond float32 or a quaternion of length 0.
    """
    length = math.sqrt(sum(one * one for one in orientation_xyzw))
    if not fit_float32((*position, *orientation_xyzw)) or not length > 0.0:
        raise ValueError("it holds a number beyond MAVLink's, or a quaternion of length 0")
    x, y, z, w = (one / length for one in orientation_xyzw)
    return common.MAVLink_att_pos_mocap_message(time_us, attitude_to_ned((x, y, z, w)), *enu_to_ned(position))


def status_text(severity: int, text: str) -> common.MAVLink_message:
    """Build STATUSTEXT; a longer text is cut.

    Raises ValueError, one sentence, for a severity that MAVLink does not know.
    """
    if not common.MAV_SEVERITY_EMERGENCY <= severity <= common.MAV_SEVERITY_DEBUG:
        raise ValueError(f"its severity is {severity}, not 0 to 7")
    return common.MAVLink_statustext_message(severity, text.encode("utf-8")[:TEXT_BYTES])


def manual_control(
    target: Target, sticks: tuple[float, float, float, float], buttons: int
) -> common.MAVLink_message:
    """Build MANUAL_CONTROL. sticks: x, y, z and r as MAVLink has them, -1000 to 1000; they are not scaled.

    Raises ValueError, one sentence, for a number that is none or that MAVLink cannot hold.
    """
    if not all(math.isfinite(one) and int(one) in _INT16 for one in sticks):
        raise ValueError(f"one of x, y, z and r is not within {_INT16[0]} to {_INT16[-1]}")
    x, y, z, r = map(int, sticks)
    return common.MAVLink_manual_control_message(target.system_id, x, y, z, r, buttons)


def mount_control(
    target: Target, mode: int, pitch_roll_yaw: Sequence[float], place: Sequence[float]
) -> common.MAVLink_message:
    """Build the command DO_MOUNT_CONTROL.

    pitch_roll_yaw: degrees, or degrees/s, by mode. place: altitude, m, latitude and longitude, 1e-7 degrees.
    Raises ValueError, one sentence, for a number that is none.
    """
    require_finite((*pitch_roll_yaw, *place))
    command = common.MAV_CMD_DO_MOUNT_CONTROL
    return common.MAVLink_command_long_message(
        target.system_id, target.component_id, command, 0, *pitch_roll_yaw, *place, mode
    )
