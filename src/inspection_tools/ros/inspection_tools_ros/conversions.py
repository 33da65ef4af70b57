"""Converts messages to the library's types. Every fault of a message gives an error of one sentence."""

from __future__ import annotations

import math

from geometry_msgs.msg import Pose, TwistStamped
from sensor_msgs.msg import LaserScan

from inspection_tools.errors import PoseError, ScanError, VelocityError
from inspection_tools.geometry import Quaternion, Vector3, normalised
from inspection_tools.position_controller import FARTHEST_M
from inspection_tools.scan import ScanGeometry
from node_tools.conversions import xyz, xyzw

GREATEST_SPEED_M_S = 1e6


def scan_geometry(scan: LaserScan) -> ScanGeometry:
    """Return the geometry of a sensor_msgs/LaserScan whose array lengths agree with its angles.

    A full turn may lack the beam at angle_max, which equals that at angle_min (Velodyne's driver does this).

    Raises:
        ScanError: no beams, impossible angles, or lengths that disagree.
    """
    beams = len(scan.ranges)
    geometry = ScanGeometry(beams, scan.angle_min, scan.angle_increment)
    steps = (scan.angle_max - scan.angle_min) / scan.angle_increment
    fits = abs(steps - (beams - 1)) < 0.5
    fits_open_turn = geometry.closes_circle and abs(steps - beams) < 0.5
    if not (fits or fits_open_turn):
        raise ScanError(
            f"The scan has {beams} ranges, but its angles ask for {steps + 1.0:.0f}; check the driver."
        )
    if len(scan.intensities) not in (0, beams):
        raise ScanError(
            f"The scan has {len(scan.intensities)} intensities for {beams} ranges; give none or as many."
        )
    return geometry


def pose_of(pose: Pose) -> tuple[Vector3, Quaternion]:
    """Return position (x, y, z) and unit quaternion (x, y, z, w) of a geometry_msgs/Pose.

    Raises:
        PoseError: not finite, farther away than anything flies, or without an orientation.
    """
    position_m = xyz(pose.position)
    if not all(math.isfinite(coordinate) for coordinate in position_m):
        raise PoseError("The pose has a position that is not finite.")
    if max(map(abs, position_m)) > FARTHEST_M:
        raise PoseError(f"The pose has a position beyond {FARTHEST_M:g} m; check its source.")
    return position_m, normalised(xyzw(pose.orientation))


def body_velocity_of(command: TwistStamped, base_frame: str) -> Vector3:
    """Return the linear velocity (x, y, z) of a geometry_msgs/TwistStamped in the body frame.

    Raises:
        VelocityError: as ``velocity_of``, or in another frame (none at all means the body frame).
    """
    frame = command.header.frame_id.lstrip("/")
    if frame not in ("", base_frame):
        raise VelocityError(f'The velocity is in frame "{frame}"; only "{base_frame}" is understood here.')
    return velocity_of(command)


def velocity_of(command: TwistStamped) -> Vector3:
    """Return the linear velocity (x, y, z) of a geometry_msgs/TwistStamped, in its own frame.

    Raises:
        VelocityError: not finite, or faster than anything flies.
    """
    velocity = xyz(command.twist.linear)
    if not all(math.isfinite(component) for component in velocity):
        raise VelocityError("The velocity has a component that is not finite.")
    if max(map(abs, velocity)) > GREATEST_SPEED_M_S:
        raise VelocityError(
            f"The velocity has a component beyond {GREATEST_SPEED_M_S:.0e} m/s; check its source."
        )
    return velocity
