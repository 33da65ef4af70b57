"""The healthy graph of the thesis's figure 5.2: which topic follows from which, and which are commands."""

from __future__ import annotations

import re
from dataclasses import dataclass


@dataclass(frozen=True)
class Follows:
    """Each message on `topic` follows from one on `source`."""

    topic: str
    source: str


CHAIN = (
    Follows("/scan/filtered", "/scan"),
    Follows("/scan/padded", "/scan/filtered"),
    Follows("/UAV/vel_setpoint/safe/body", "/scan/padded"),
    Follows("/UAV/vel_setpoint/final/body", "/UAV/vel_setpoint/safe/body"),
)
"""From the scan to the flown velocity, with the default names."""

FOLLOWED_SHARE = 0.8
"""A topic with less than this share of its source's messages loses some."""

RATES_HZ = {
    "/UAV/odometry": 20.0,
    "/UAV/ground_truth": 20.0,
    "/mavros/local_position/pose": 10.0,
    "/mavros/state": 0.5,
}
"""Least rates in the graph's time: at most half of the rates of simulator and PX4."""

LEAST_SETPOINT_RATE_HZ = 2.0
"""PX4 leaves OFFBOARD if setpoints have a lower rate."""

SETPOINTS = re.compile(r".*/mavros/setpoint_(raw|position|velocity)/.*|/mavros/setpoint_.*")

EXTERNAL_POSES = ("vision_pose/pose", "vision_pose/pose_cov", "odometry/out")
"""Topics of MAVROS. Their plugins are in the package mavros_extras."""

OPTIONAL_INPUTS = re.compile(
    r"/mavros/(setpoint_|vision_|distance_sensor/|(odometry/out|rc/override|home_position/set)$)"
    r"|/mavros/global_position/set_gp_origin$|/gazebo/set_model_(state|states)$"
    r"|/UAV/(pos_setpoint/final|use_pos_setpoint|vision_state|front)$"
    r"|/.*/working$"  # in lockstep the simulator hears it of each participant; only slow ones send it
    r"|/joy$|/explore/explore/status$|/inspect/survey/status$"  # what `pilot_orders` hears
    r"|/gridslam/map_id$"  # another SLAM may not tell it
    r"|/initialpose$|/clicked_point$"  # RViz's, when somebody clicks
    r"|/.*/cancel$"  # of an action: who sends goals need not cancel them
    r"|/gazebo/odometry_without_gnss$"  # `tools.launch` gives this name where lidar_odometry sends TF
)
"""Optional inputs for users. A publisher is not necessary."""

BESIDE_CLOUDS = {"/slam_octomap": ("/scan_in", "/range_down_in", "/range_up_in")}
"""Inputs that a node can do without, by their names before a remap. Another node may need such a name."""

VIEWERS = re.compile(r".*/(rviz|rqt\w*)$")
"""Nodes that only show. They end without a screen, or when somebody closes the window."""

_COMMANDS = re.compile(r".*(/vel_setpoint/|/pos_setpoint($|/)|/mavros/setpoint_|/cmd_vel)")


def is_command(topic: str) -> bool:
    """Return whether a topic carries commands. Two publishers at a time would contradict each other."""
    return bool(_COMMANDS.match(topic))


QUIET_TOPICS = re.compile(r"/rosout(_agg)?$|/statistics$|/diagnostics$|.*/parameter_(updates|descriptions)$")
"""Topics that every node has."""
