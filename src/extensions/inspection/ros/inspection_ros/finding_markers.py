"""Findings as markers for RViz, with a namespace per kind."""

from __future__ import annotations

from typing import Sequence

import numpy as np
from geometry_msgs.msg import Point
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from inspection.findings.kinds import kind_of
from inspection.findings.merging import Finding

SIZE_M, OFF_SURFACE_M = 0.35, 0.1


def finding_markers(findings: Sequence[Finding], frame: str, shown_before: Sequence[str] = ()) -> MarkerArray:
    """Return a ball for each finding, before the surface. shown_before: kinds, of which none may be left."""
    markers = []
    for kind in sorted({each.kind for each in findings} | set(shown_before)):
        own = [each for each in findings if each.kind == kind]
        marker = Marker(header=Header(frame_id=frame), ns=kind, type=Marker.SPHERE_LIST)
        marker.action = Marker.ADD if own else Marker.DELETE
        marker.color = ColorRGBA(*kind_of(kind).rviz_colour, 1.0)
        marker.pose.orientation.w, marker.scale.x = 1.0, SIZE_M
        marker.scale.y = marker.scale.z = SIZE_M
        places_m = [np.array(each.position_m) + OFF_SURFACE_M * np.array(each.normal) for each in own]
        marker.points = [Point(*place_m.tolist()) for place_m in places_m]
        markers.append(marker)
    return MarkerArray(markers)
