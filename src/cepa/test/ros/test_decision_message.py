"""What `dynamic` foresees, as markers: RViz calls a line of one point an error, and says so in red."""

import numpy as np
import pytest

pytest.importorskip("cepa_ros.decision_message", reason="the workspace is not built, or not sourced")

from cepa_ros.decision_message import write_view
from std_msgs.msg import Header
from visualization_msgs.msg import Marker

from cepa.dynamic.report import View


@pytest.mark.parametrize(("points", "action"), [(0, Marker.DELETE), (1, Marker.DELETE), (2, Marker.ADD)])
def test_a_path_is_drawn_only_if_it_has_two_points(points, action):
    path_m, nothing = np.arange(3.0 * points).reshape(-1, 3), np.zeros((0, 3))
    view = View(path_m, path_m, nothing, np.zeros(0, bool), np.zeros((0, 5)))
    assert [each.action for each in write_view(Header(), view)] == [action, action]
