"""Findings are shown by their kind, and one that is gone is taken away."""

import pytest
from drawn_inspection import FINDINGS

pytestmark = pytest.mark.ros


def test_each_kind_is_a_marker_of_its_own_before_the_surface():
    from inspection_ros.finding_markers import OFF_SURFACE_M, finding_markers
    from visualization_msgs.msg import Marker

    crack, rust = finding_markers(FINDINGS, "map").markers
    assert [(each.ns, each.action, len(each.points)) for each in (crack, rust)] == [
        ("crack", Marker.ADD, 1), ("rust", Marker.ADD, 1),
    ]  # fmt: skip
    place = rust.points[0]  # on the port side, y = 1.5 m, which faces -y
    assert (place.x, place.y, place.z) == pytest.approx((0.5, 1.5 - OFF_SURFACE_M, 1.2))
    gone, _ = finding_markers(FINDINGS[:1], "map", ["crack", "rust"]).markers
    assert (gone.ns, gone.action) == ("crack", Marker.DELETE)
