"""The topic ~decision: named velocities as arrows, paths and what moves, for RViz and for other tools."""

from __future__ import annotations

from typing import Mapping

import numpy as np
import rospy
from geometry_msgs.msg import Point
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from cepa.decision import Vector2
from cepa.dynamic.report import View

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

PREDICTED, BRAKING, MOVER = "predicted path", "braking path", "mover"
PATH_COLOURS = {PREDICTED: (1.0, 0.85, 0.2), BRAKING: (0.95, 0.35, 0.15), MOVER: (0.85, 0.35, 0.85)}

LIFETIME_S = 0.5
SHAFT_M, HEAD_M = 0.05, 0.12


def write(header: Header, velocities: Mapping[str, Vector2]) -> MarkerArray:
    """Return the message for velocities {name: (x, y)}, m/s in the frame of ``header``, the scan's.

    An arrow's length in m is the speed in m/s.
    """
    return MarkerArray(markers=[arrow(header, name, velocity) for name, velocity in velocities.items()])


def write_view(header: Header, view: View) -> list[Marker]:
    """Return what `Dynamic` foresees: two paths, and cylinders that move; their point is their velocity."""
    markers = []
    for name, path in ((PREDICTED, view.predicted_m), (BRAKING, view.braking_m)):
        marker = _marker(header, name, Marker.LINE_STRIP)
        marker.points = [Point(*place) for place in path.tolist()]
        if len(path) < 2:  # RViz calls such a line an error, and shows the display's name in red
            marker.action = Marker.DELETE
        marker.scale.x = SHAFT_M
        marker.color = ColorRGBA(*PATH_COLOURS[name], 1.0)
        markers.append(marker)
    for number, (x, y, vx, vy, radius) in enumerate(view.movers.tolist()):
        marker = _marker(header, MOVER, Marker.CYLINDER)
        marker.id = number
        marker.pose.position.x, marker.pose.position.y = x, y
        marker.points = [Point(vx, vy, 0.0)]
        marker.scale.x = marker.scale.y = 2.0 * radius
        marker.scale.z = SHAFT_M
        marker.color = ColorRGBA(*PATH_COLOURS[MOVER], 0.5)
        markers.append(marker)
    return markers


def read_path(message: MarkerArray, name: str) -> np.ndarray:
    """Return a path (n, 3) of a message, m; (0, 3) if it has none."""
    points = [(p.x, p.y, p.z) for marker in message.markers if marker.ns == name for p in marker.points]
    return np.array(points).reshape(-1, 3)


def read_movers(message: MarkerArray) -> np.ndarray:
    """Return what moves in a message (n, 5): position, velocity and radius, m and m/s."""
    movers = [
        (m.pose.position.x, m.pose.position.y, m.points[0].x, m.points[0].y, 0.5 * m.scale.x)
        for m in message.markers
        if m.ns == MOVER and m.points
    ]
    return np.array(movers).reshape(-1, 5)


def read(message: MarkerArray) -> dict[str, Vector2]:
    """Return the velocities {name: (x, y)} of a message, m/s."""
    return {
        marker.ns: (marker.points[1].x - marker.points[0].x, marker.points[1].y - marker.points[0].y)
        for marker in message.markers
        if marker.ns in COLOURS and len(marker.points) == 2
    }


def arrow(header: Header, name: str, velocity: Vector2, height_m: float = 0.0) -> Marker:
    """Return the arrow of one velocity from the origin of the frame of ``header``."""
    marker = _marker(header, name, Marker.ARROW)
    marker.points = [Point(0.0, 0.0, height_m), Point(velocity[0], velocity[1], height_m)]
    marker.scale.x, marker.scale.y = SHAFT_M, HEAD_M
    marker.color = ColorRGBA(*COLOURS[name], 1.0)
    return marker


def _marker(header: Header, name: str, kind: int) -> Marker:
    marker = Marker(ns=name, id=0, type=kind, action=Marker.ADD)
    marker.header.stamp, marker.header.frame_id = header.stamp, header.frame_id
    marker.pose.orientation.w = 1.0
    marker.lifetime = rospy.Duration(LIFETIME_S)
    marker.frame_locked = True
    return marker
