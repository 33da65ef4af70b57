"""The messages of the node test."""

from __future__ import annotations

import math

import numpy as np
from geometry_msgs.msg import TransformStamped
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage

BEAMS = 360
ROOM_XY = (5.0, 3.0)
"""m: half the sizes of a room about the origin."""


def transform(parent, child, stamp, pose=(0.0, 0.0, 0.0), z=0.0):
    """A transform in the plane, as a TFMessage."""
    message = TransformStamped(child_frame_id=child)
    message.header.stamp, message.header.frame_id = stamp, parent
    t, q = message.transform.translation, message.transform.rotation
    t.x, t.y, t.z = (*pose[:2], z)
    q.z, q.w = math.sin(pose[2] / 2.0), math.cos(pose[2] / 2.0)
    return TFMessage([message])


def room_scan(stamp, pose, frame="laser", beams=BEAMS, **changes):
    """A full turn about ``pose`` in the middle of the room's four walls."""
    scan = LaserScan(range_min=0.1, range_max=20.0)
    scan.header.stamp, scan.header.frame_id = stamp, frame
    scan.angle_min, scan.angle_increment = -math.pi, 2.0 * math.pi / beams
    scan.angle_max = scan.angle_min + (beams - 1) * scan.angle_increment
    bearings = pose[2] + scan.angle_min + scan.angle_increment * np.arange(beams)
    scan.ranges = np.minimum(
        _to_walls(pose[0], np.cos(bearings), ROOM_XY[0]), _to_walls(pose[1], np.sin(bearings), ROOM_XY[1])
    )
    for name, value in changes.items():
        setattr(scan, name, value)
    return scan


def _to_walls(place, directions, half):
    """Distance along each beam to the wall at +half or -half of one axis."""
    with np.errstate(divide="ignore"):
        return np.where(directions > 0.0, half - place, -half - place) / directions
