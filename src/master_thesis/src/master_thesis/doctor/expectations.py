"""What the graph of the thesis's figure 5.2 looks like when it is well: who follows whom, who may command."""

from __future__ import annotations

import re
from dataclasses import dataclass


@dataclass(frozen=True)
class Follows:
    """Messages on `topic` are made of those on `source`, one for one."""

    topic: str
    source: str


CHAIN = (
    Follows("/scan/filtered", "/scan"),
    Follows("/scan/padded", "/scan/filtered"),
    Follows("/UAV/vel_setpoint/safe/body", "/scan/padded"),
    Follows("/UAV/vel_setpoint/final/body", "/UAV/vel_setpoint/safe/body"),
)
"""From the scan to what the publisher flies, as launched with the default names."""

FOLLOWED_SHARE = 0.8
"""A topic that follows another one by less than this part of its messages loses some."""

RATES_HZ = {
    "/UAV/odometry": 20.0,
    "/UAV/ground_truth": 20.0,
    "/mavros/local_position/pose": 10.0,
    "/mavros/state": 0.5,
}
"""Least rates in the graph's own time, half of what simulator and PX4 send or less."""

LEAST_SETPOINT_RATE_HZ = 2.0
"""PX4 leaves OFFBOARD when setpoints come more rarely."""

SETPOINTS = re.compile(r".*/mavros/setpoint_(raw|position|velocity)/.*|/mavros/setpoint_.*")

OPTIONAL_INPUTS = re.compile(
    r"/mavros/setpoint_|/UAV/pos_setpoint/final$|/UAV/use_pos_setpoint$|/gazebo/set_model_(state|states)$"
)
"""Topics that a node of the stack offers to whoever wants to use them."""

_COMMANDS = re.compile(r".*(/vel_setpoint/|/pos_setpoint($|/)|/mavros/setpoint_|/cmd_vel)")


def is_command(topic: str) -> bool:
    """Tell whether a topic carries commands, of which two sources at a time would pull in two directions."""
    return bool(_COMMANDS.match(topic))


QUIET_TOPICS = re.compile(r"/rosout(_agg)?$|/statistics$|/diagnostics$|.*/parameter_(updates|descriptions)$")
"""Topics that every node has, and that say nothing about what it does."""
