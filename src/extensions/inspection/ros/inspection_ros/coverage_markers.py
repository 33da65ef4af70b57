"""Coverage on the surface as markers for RViz."""

from __future__ import annotations

import numpy as np
from geometry_msgs.msg import Point
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from inspection.flight.live_coverage import LiveCoverage
from inspection.survey.surface.mesh_file import reference_of

SHOWN, OPEN, OTHER = (
    ColorRGBA(0.15, 0.75, 0.25, 0.9),
    ColorRGBA(0.2, 0.45, 1.0, 0.12),
    ColorRGBA(0.9, 0.2, 0.1, 0.35),
)
"""What is open is almost clear, so that one sees into the room."""
WORDS_ABOVE_M = 1.0


def coverage_markers(coverage: LiveCoverage, frame: str) -> MarkerArray:
    """Return the patches: photographed (green), open (blue), not in the plan (red); and the areas."""
    header, squares = Header(frame_id=frame), coverage.squares_m()
    shown, is_open = coverage.shown, coverage.planned & ~coverage.shown
    groups = (("photographed", SHOWN, shown), ("open", OPEN, is_open), ("other", OTHER, ~(shown | is_open)))
    markers = [_patches(header, name, colour, squares[those]) for name, colour, those in groups]
    words = Marker(header=header, ns="words", type=Marker.TEXT_VIEW_FACING)
    words.color.a = 1.0
    words.pose.position = Point(
        *squares[..., :2].mean(axis=(0, 1)).tolist(), squares[..., 2].max() + WORDS_ABOVE_M
    )
    words.pose.orientation.w, words.scale.z = 1.0, 0.6
    areas = coverage.so_far
    of = reference_of(coverage.patches.names)
    words.text = f"{areas.shown_m2:.0f} of {areas.planned_m2:.0f} m² of the {of} photographed"
    return MarkerArray([*markers, words])


def _patches(header: Header, name: str, colour: ColorRGBA, squares: np.ndarray) -> Marker:
    """Return two triangles for each of the squares (n, 4, 3)."""
    marker = Marker(header=header, ns=name, type=Marker.TRIANGLE_LIST, color=colour)
    marker.action = Marker.ADD if len(squares) else Marker.DELETE
    marker.pose.orientation.w = marker.scale.x = marker.scale.y = marker.scale.z = 1.0
    marker.points = [Point(*corner) for corner in squares[:, (0, 1, 2, 0, 2, 3)].reshape(-1, 3).tolist()]
    return marker
