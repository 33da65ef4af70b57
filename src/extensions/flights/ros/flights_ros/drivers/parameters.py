"""The parameters of all nodes, for a run's result.json."""

from __future__ import annotations

from typing import Any

import rosgraph
import rospy


def all_parameters() -> dict[str, dict[str, Any]]:
    """Return the parameters of all nodes, by node."""
    # Not rospy.get_param, because its cache may hold only a part of the tree.
    parameters = rosgraph.Master(rospy.get_name()).getParam("/")
    parameters.pop("roslaunch", None)  # ROS's own addresses
    return {name: value for name, value in parameters.items() if isinstance(value, dict)}
