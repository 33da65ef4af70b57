"""The topic ~decision: named velocities as arrows, for RViz and for other tools."""

from __future__ import annotations

from typing import Mapping

import rospy
from geometry_msgs.msg import Point
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from cepa.decision import Vector2

REFERENCE, OUTPUT, OWN = "v_ref", "v_out", "v_uav"
ORIGINAL, IMPROVED = "emergency original", "emergency improved"
COLOURS = {
    OWN: (0.65, 0.65, 0.65),
    REFERENCE: (0.25, 0.55, 1.0),
    OUTPUT: (1.0, 0.85, 0.2),
    ORIGINAL: (0.9, 0.1, 0.1),
    IMPROVED: (0.1, 0.85, 0.2),
}
"""Red and green are those of the thesis's figures 8.6 and 8.7."""

LIFETIME_S = 0.5
SHAFT_M, HEAD_M = 0.05, 0.12


def write(header: Header, velocities: Mapping[str, Vector2]) -> MarkerArray:
    """Return the message for velocities {name: (x, y)}, m/s in the frame of ``header``, the scan's.

    An arrow's length in m is the speed in m/s.
    """
    return MarkerArray(markers=[arrow(header, name, velocity) for name, velocity in velocities.items()])


def read(message: MarkerArray) -> dict[str, Vector2]:
    """Return the velocities {name: (x, y)} of a message, m/s."""
    return {
        marker.ns: (marker.points[1].x - marker.points[0].x, marker.points[1].y - marker.points[0].y)
        for marker in message.markers
        if marker.ns in COLOURS and len(marker.points) == 2
    }


def arrow(header: Header, name: str, velocity: Vector2, height_m: float = 0.0) -> Marker:
    """Return the arrow of one velocity from the origin of the frame of ``header``."""
    marker = Marker(ns=name, id=0, type=Marker.ARROW, action=Marker.ADD)
    marker.header.stamp, marker.header.frame_id = header.stamp, header.frame_id
    marker.pose.orientation.w = 1.0
    marker.points = [Point(0.0, 0.0, height_m), Point(velocity[0], velocity[1], height_m)]
    marker.scale.x, marker.scale.y = SHAFT_M, HEAD_M
    marker.color = ColorRGBA(*COLOURS[name], 1.0)
    marker.lifetime = rospy.Duration(LIFETIME_S)
    marker.frame_locked = True
    return marker
