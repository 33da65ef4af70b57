"""The healthy graph of the thesis's figure 5.2: which topic follows which, and who may command."""

from __future__ import annotations

import re
from dataclasses import dataclass


@dataclass(frozen=True)
class Follows:
    """Each message on `topic` is made from one on `source`."""

    topic: str
    source: str


CHAIN = (
    Follows("/scan/filtered", "/scan"),
    Follows("/scan/padded", "/scan/filtered"),
    Follows("/UAV/vel_setpoint/safe/body", "/scan/padded"),
    Follows("/UAV/vel_setpoint/final/body", "/UAV/vel_setpoint/safe/body"),
)
"""From the scan to the velocity that is flown, with the default names."""

FOLLOWED_SHARE = 0.8
"""A topic that has less than this share of the messages of its source loses some."""

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
"""Topics that a node of the stack offers to users; nobody need publish them."""

_COMMANDS = re.compile(r".*(/vel_setpoint/|/pos_setpoint($|/)|/mavros/setpoint_|/cmd_vel)")


def is_command(topic: str) -> bool:
    """Return whether a topic carries commands: two publishers at a time would contradict each other."""
    return bool(_COMMANDS.match(topic))


QUIET_TOPICS = re.compile(r"/rosout(_agg)?$|/statistics$|/diagnostics$|.*/parameter_(updates|descriptions)$")
"""Topics that every node has."""
