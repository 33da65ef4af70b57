"""ROS parameters as this package's nodes read them."""

from __future__ import annotations

import rosgraph
import rospy


def text(name: str, default: str) -> str:
    """Return one of the node's private parameters as text."""
    return str(rospy.get_param(f"~{name}", default))


def all_parameters() -> dict:
    """Return the parameters of all nodes, by node."""
    # Not rospy.get_param: its cache takes the root for what rospy itself has asked for
    parameters = rosgraph.Master(rospy.get_name()).getParam("/")
    parameters.pop("roslaunch", None)  # its own addresses
    return {name: value for name, value in parameters.items() if isinstance(value, dict)}
