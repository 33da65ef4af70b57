"""Lines of an errand without a way: RViz calls a line of one point an error, and shows the display in red."""

from types import SimpleNamespace

import numpy as np
import pytest

pytestmark = pytest.mark.ros
HERE_M, THERE_M = np.array([1.0, 2.0, 1.5]), np.array([4.0, 2.0, 1.5])


def shown(message):
    """The number of points of each line that RViz is asked to draw."""
    from visualization_msgs.msg import Marker

    lines = [each for each in message.markers if each.type in (Marker.LINE_STRIP, Marker.LINE_LIST)]
    return {each.ns: len(each.points) for each in lines if each.action == Marker.ADD}


@pytest.mark.parametrize("rest_m", [[], [THERE_M]], ids=["at its end", "on its way"])
def test_an_inspection_draws_no_line_of_one_point(rest_m):
    from inspection_ros.messages import markers_of
    from std_msgs.msg import Header

    queue = SimpleNamespace(tasks=[], done={}, left_out={})
    inspection = SimpleNamespace(queue=queue, task=None, rest_m=rest_m)
    assert shown(markers_of(inspection, HERE_M, Header())) == ({"way": 2} if rest_m else {})


@pytest.mark.parametrize("home_m", [[HERE_M], [HERE_M, THERE_M]], ids=["home", "away"])
def test_an_exploration_draws_no_line_of_one_point(home_m):
    from exploration_ros.exploration_messages import markers_of
    from std_msgs.msg import Header

    from exploration.msg import ExploreFeedback

    explored = SimpleNamespace(leftovers=[])
    exploration = SimpleNamespace(rest_m=[], home_way_m=np.array(home_m), explored=explored)
    message = markers_of(exploration, ExploreFeedback(), HERE_M, Header())
    assert shown(message) == ({"home": 2} if len(home_m) > 1 else {})
