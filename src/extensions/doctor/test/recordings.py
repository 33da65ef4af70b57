"""A graph and a recording that are well, made up by hand, and the same with something changed."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from doctor.snapshot import Autopilot, Graph, Launched, Node, Parameter, Recording, Scan, Topic, Transform

START_S, END_S = 10.0, 15.0


def times(rate_hz, until_s=END_S):
    return tuple(np.arange(START_S, until_s, 1.0 / rate_hz))


def topic(name, kind, publisher, rate_hz, subscribers=(), delay_s=0.01):
    received_s = times(rate_hz)
    return Topic(name, kind, (publisher,), subscribers, received_s, tuple(t - delay_s for t in received_s))


def edge(parent, child, publisher="/tf_publisher", **changes):
    seen_s = times(100)
    return replace(
        Transform(parent, child, publisher, False, seen_s, tuple(t - 0.01 for t in seen_s)), **changes
    )


def scan(**changes):
    ranges = np.array([math.inf, 1.0, 2.0, -math.inf, math.nan], np.float32)
    return replace(Scan("/scan", "hokuyo", -1.0, 1.0, 0.5, 0.1, 10.0, ranges), **changes)


TOPICS = [
    Topic(
        "/clock", "rosgraph_msgs/Clock", ("/gazebo",), ("/cepa",), times(100), (math.nan,) * len(times(100))
    ),
    topic("/scan", "sensor_msgs/LaserScan", "/gazebo", 40, ("/lidar_median_filter",)),
    topic("/scan/filtered", "sensor_msgs/LaserScan", "/lidar_median_filter", 40, ("/lidar_padding",)),
    topic("/scan/padded", "sensor_msgs/LaserScan", "/lidar_padding", 40, ("/cepa",)),
    topic("/UAV/odometry", "nav_msgs/Odometry", "/gazebo", 100, ("/cepa",)),
    topic(
        "/UAV/vel_setpoint/raw/body", "geometry_msgs/TwistStamped", "/position_controller", 100, ("/cepa",)
    ),
    topic("/UAV/vel_setpoint/safe/body", "geometry_msgs/TwistStamped", "/cepa", 40, ("/yaw_regulator",)),
    topic(
        "/UAV/vel_setpoint/final/body",
        "geometry_msgs/TwistStamped",
        "/yaw_regulator",
        40,
        ("/mavros_publisher",),
    ),
    topic("/mavros/setpoint_raw/local", "mavros_msgs/PositionTarget", "/mavros_publisher", 40, ("/mavros",)),
]
HEALTHY = Recording(
    {each.name: each for each in TOPICS},
    (edge("odom", "base_frame"), edge("base_frame", "world"), edge("base_frame", "hokuyo", static=True)),
    (scan(),),
    (Autopilot("/mavros/state", True, True, "OFFBOARD"),),
    times(100),
    END_S,
)
NODES = tuple(map(Node, sorted({name for each in TOPICS for name in (*each.publishers, *each.subscribers)})))
ALGORITHM = Parameter(
    "/cepa", "algorithm", -math.inf, math.inf, text_on_server="original", choices=("improved", "original")
)
WELL = Graph(
    HEALTHY,
    NODES,
    tuple(Launched(node.name) for node in NODES),
    (Parameter("/cepa", "r_ub", 0.1, 10.0, 1.2, 1.2), ALGORITHM),
    True,
    5.0,
)


def having(**changes):
    """Return the healthy graph with another recording."""
    return replace(WELL, recording=replace(HEALTHY, **changes))


def with_topic(name, **changes):
    changed = replace(HEALTHY.topics.get(name, Topic(name, "")), **changes)
    return having(topics={**HEALTHY.topics, name: changed})


def with_edge(parent, child, **changes):
    """Return the healthy graph with one edge of TF changed."""
    others = [one for one in HEALTHY.transforms if (one.parent, one.child) != (parent, child)]
    return having(transforms=(*others, edge(parent, child, **changes)))


def with_scan(**changes):
    return having(scans=(scan(**changes),))


def late(name, by_s):
    each = HEALTHY.topics[name]
    return with_topic(name, stamps_s=tuple(stamp_s - by_s for stamp_s in each.stamps_s))


def edge_late(by_s):
    return with_edge("odom", "base_frame", stamps_s=tuple(t - by_s for t in times(100)))


AUTOPILOT = HEALTHY.autopilots[0]
FINAL, SAFE, RAW = (f"/UAV/vel_setpoint/{name}/body" for name in ("final", "safe", "raw"))


VISION = "/mavros/vision_pose/pose_cov"


def bag_without(*names, **changes):
    """Return the healthy recording as a bag, which has no clock, without some topics."""
    topics = {name: each for name, each in HEALTHY.topics.items() if name not in ("/clock", *names)}
    return replace(HEALTHY, topics=topics, clock_s=(), **changes)
