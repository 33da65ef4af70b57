"""The doctor's judgement of graphs and bags made up by hand: one that is well, and one fault at a time."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from master_thesis.doctor import bag, graph
from master_thesis.doctor.finding import BROKEN, ERROR, FINE, NOTE, WARNING, exit_code
from master_thesis.doctor.snapshot import (
    Autopilot,
    Graph,
    Launched,
    Node,
    Parameter,
    Recording,
    Scan,
    Topic,
    Transform,
)

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


def test_a_graph_that_is_well_has_no_finding():
    assert graph.check(WELL) == []
    assert exit_code([]) == FINE


def test_a_bag_that_is_well_has_no_finding():
    topics = {
        name: replace(each, subscribers=()) for name, each in HEALTHY.topics.items() if name != "/clock"
    }
    assert bag.check(replace(HEALTHY, topics=topics, clock_s=())) == []


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


HOLE = tuple(t for t in times(100) if not 12.0 < t < 12.8)
LOOP = (edge("a", "b"), edge("b", "c"), edge("c", "a"))
AUTOPILOT = HEALTHY.autopilots[0]
FINAL, SAFE, RAW = (f"/UAV/vel_setpoint/{name}/body" for name in ("final", "safe", "raw"))

BROKEN_GRAPHS = {
    # nodes
    "hung node": (replace(WELL, nodes=(*NODES, Node("/ghost", False))), ERROR, "/ghost", "does not answer"),
    "dead node": (replace(WELL, launched=(Launched("/cepa", False),)), ERROR, "/cepa", "has ended"),
    "respawned node": (
        replace(WELL, launched=(Launched("/cepa", True, 3),)),
        WARNING,
        "/cepa",
        "ended 2 times",
    ),
    "unknown to the master": (
        replace(WELL, launched=(Launched("/late"),)),
        WARNING,
        "/late",
        "does not know it",
    ),
    # topics
    "nobody publishes": (
        with_topic("/scan", publishers=(), received_s=()),
        ERROR,
        "/scan",
        "nobody publishes",
    ),
    "wrong remap": (with_topic("/sacn", subscribers=("/mine",)), NOTE, "/sacn", "/mine listens"),
    "silence": (with_topic("/UAV/odometry", received_s=()), ERROR, "/UAV/odometry", "nothing came"),
    "slow": (with_topic("/UAV/odometry", received_s=times(4)), WARNING, "/UAV/odometry", "4.0 Hz"),
    "half of the scans": (with_topic("/scan/padded", received_s=times(20)), WARNING, "/scan/padded", "50 %"),
    "no answers": (with_topic(SAFE, received_s=()), ERROR, SAFE, "makes nothing of it"),
    "two commanders": (with_topic(FINAL, publishers=("/a", "/b")), ERROR, FINAL, "/a and /b both"),
    # autopilot
    "no autopilot": (
        having(autopilots=(replace(AUTOPILOT, connected=False),)),
        ERROR,
        "/mavros/state",
        "hears no",
    ),
    "hold": (
        having(autopilots=(replace(AUTOPILOT, mode="AUTO.LOITER"),)),
        NOTE,
        "/mavros/state",
        "AUTO.LOITER",
    ),
    "rare setpoints": (
        with_topic("/mavros/setpoint_raw/local", received_s=times(1.5)),
        ERROR,
        "/mavros/state",
        "1.5 Hz",
    ),
    # clock
    "no clock": (with_topic("/clock", publishers=()), ERROR, "/clock", "nobody publishes"),
    "paused": (having(clock_s=(10.0, 10.0)), WARNING, "/clock", "stands still"),
    "paused from the start": (having(clock_s=()), WARNING, "/clock", "stands still"),
    "wall time": (replace(WELL, use_sim_time=False), ERROR, "/use_sim_time", "is false"),
    "two clocks": (with_topic("/clock", publishers=("/gazebo", "/play")), ERROR, "/clock", "to and fro"),
    "clock back": (having(clock_s=(10.0, 11.0, 2.0, 14.0)), WARNING, "/clock", "went back 1 times"),
    "another clock": (late("/scan", -1.7e9), ERROR, "/scan", "another clock"),
    "old stamps": (late("/scan", 2.0), WARNING, "/scan", "2.0 s old"),
    "future stamps": (late("/scan", -1.0), WARNING, "/scan", "in the future"),
    "stamps back": (
        with_topic(RAW, stamps_s=(14.0, 13.9), received_s=(14.0, 14.1)),
        WARNING,
        RAW,
        "go back 1",
    ),
    # TF
    "two parents": (
        having(transforms=(*HEALTHY.transforms, edge("map", "base_frame"))),
        ERROR,
        "frame base_frame",
        "has 2 parents",
    ),
    "two publishers": (
        having(transforms=(*HEALTHY.transforms, edge("odom", "base_frame", publisher="/b"))),
        ERROR,
        "tf odom -> base_frame",
        "/b and /tf_publisher",
    ),
    "two pieces": (having(transforms=(*HEALTHY.transforms, edge("x", "y"))), ERROR, "tf", "in 2 pieces"),
    "a loop": (having(transforms=LOOP), ERROR, "frame", "its own ancestor"),
    "not a rotation": (
        with_edge("odom", "base_frame", broken=True),
        ERROR,
        "tf odom -> base_frame",
        "unit length",
    ),
    "hole": (
        with_edge("odom", "base_frame", received_s=HOLE, stamps_s=HOLE),
        WARNING,
        "tf odom -> base_frame",
        "hole of 0.8",
    ),
    "tf future": (edge_late(-3.0), ERROR, "tf odom -> base_frame", "into the future"),
    "tf old": (edge_late(3.0), ERROR, "tf odom -> base_frame", "3.0 s late"),
    "tf ended": (
        with_edge("odom", "base_frame", received_s=times(100, 12.0), stamps_s=times(100, 12.0)),
        ERROR,
        "tf odom -> base_frame",
        "has not come for 3.0 s",
    ),
    "tf back": (
        with_edge("odom", "base_frame", received_s=(14.8, 14.9), stamps_s=(14.8, 14.7)),
        WARNING,
        "tf odom -> base_frame",
        "go back",
    ),
    "tf repeats": (
        with_edge("odom", "base_frame", received_s=(14.9,) * 60, stamps_s=(14.9,) * 60),
        NOTE,
        "tf odom -> base_frame",
        "same stamp",
    ),
    # scans
    "unknown frame": (with_scan(frame="laser"), ERROR, "/scan", '"laser" is not in TF'),
    "beams missing": (with_scan(ranges=np.ones(3)), ERROR, "/scan", "3 ranges"),
    "one beam more": (with_scan(ranges=np.ones(6)), WARNING, "/scan", "make 5 beams"),
    "no increment": (with_scan(angle_increment=0.0), ERROR, "/scan", "0 rad apart"),
    "no angle": (with_scan(angle_min=math.nan), ERROR, "/scan", "no numbers"),
    "limits turned": (with_scan(range_min=11.0), ERROR, "/scan", "leave nothing"),
    "zeros": (with_scan(ranges=np.array([0.0, 1.0, 1.0, 1.0, 0.05])), WARNING, "/scan", "40.0 %"),
    "too far": (with_scan(ranges=np.array([65.0, 1.0, 1.0, 1.0, 1.0])), WARNING, "/scan", "above range_max"),
    "range_max for nothing": (with_scan(ranges=np.full(5, 10.0)), NOTE, "/scan", "range_max itself"),
    "blind": (with_scan(ranges=np.full(5, math.nan)), ERROR, "/scan", "NaN in every beam"),
    "covered": (with_scan(ranges=np.full(5, -math.inf)), ERROR, "/scan", "covers the lidar"),
    # parameters
    "out of range": (
        replace(WELL, parameters=(Parameter("/cepa", "r_ub", 0.1, 10.0, 99.0, 1.2),)),
        ERROR,
        "/cepa/r_ub",
        "99 on the parameter server",
    ),
    "no number": (  # YAML takes 1e9 for a word; it wants 1.0e9
        replace(WELL, parameters=(Parameter("/cepa", "r_ub", 0.1, 10.0, None, 1.2, "1e9"),)),
        ERROR,
        "/cepa/r_ub",
        'is "1e9" on the parameter server, and must be a number from 0.1 to 10',
    ),
    "no choice": (
        replace(WELL, parameters=(replace(ALGORITHM, text_on_server="banana"),)),
        ERROR,
        "/cepa/algorithm",
        'is "banana" on the parameter server, and must be improved or original',
    ),
    "does not reach the node": (
        replace(WELL, parameters=(Parameter("/cepa", "r_ub", 0.1, 10.0, 2.0, 1.2),)),
        WARNING,
        "/cepa/r_ub",
        "uses 1.2",
    ),
}


@pytest.mark.parametrize("case", BROKEN_GRAPHS)
def test_what_is_broken_is_found(case):
    broken, severity, where, what = BROKEN_GRAPHS[case]
    found = graph.check(broken)
    assert any(
        one.severity == severity and one.where.startswith(where) and what in one.what and one.remedy
        for one in found
    ), found
    assert exit_code(found) == (BROKEN if severity == ERROR else FINE), found


def bag_without(*names, **changes):
    topics = {name: each for name, each in HEALTHY.topics.items() if name not in ("/clock", *names)}
    return replace(HEALTHY, topics=topics, clock_s=(), **changes)


ODD = tuple(t for t in times(40) if not 12.0 < t < 13.0)
BROKEN_BAGS = {
    "empty": (Recording(), ERROR, "bag", "no messages"),
    "no scans": (bag_without("/scan", "/scan/filtered", "/scan/padded"), NOTE, "gridslam", "no scans"),
    "no velocity": (bag_without(RAW, SAFE, FINAL), NOTE, "cepa", "reference velocity"),
    "no odometry": (bag_without("/UAV/odometry"), NOTE, "cepa", "no odometry"),
    "no tf": (bag_without(transforms=HEALTHY.transforms[2:]), NOTE, "gridslam", "TF does not lead"),
    "clock inside": (HEALTHY, NOTE, "/clock", "is in the bag"),
    "hole": (
        replace(
            HEALTHY, topics={"/scan": Topic("/scan", "sensor_msgs/LaserScan", ("/gazebo",), (), ODD, ODD)}
        ),
        WARNING,
        "/scan",
        "every 25 ms, but not for 1.0",
    ),
    "stamps back": (
        replace(
            HEALTHY,
            topics={RAW: replace(HEALTHY.topics[RAW], received_s=(14.0, 14.1), stamps_s=(14.0, 13.9))},
        ),
        WARNING,
        RAW,
        "go back",
    ),
}


@pytest.mark.parametrize("case", BROKEN_BAGS)
def test_what_is_broken_in_a_bag_is_found(case):
    recording, severity, where, what = BROKEN_BAGS[case]
    found = bag.check(recording)
    assert any(one.severity == severity and one.where == where and what in one.what for one in found), found


def test_padded_beams_and_free_space_are_no_fault():
    """NaN of the padding and +inf of the open field are what REP-117 means them to be."""
    open_field = scan(ranges=np.array([math.nan, math.inf, math.inf, math.inf, math.nan]))
    assert graph.check(having(scans=(open_field,))) == []


def test_a_wrong_clock_is_told_once_not_of_every_topic():
    found = graph.check(replace(late("/scan", -1.7e9), use_sim_time=False))
    assert [one.where for one in found] == ["/use_sim_time"]


def test_a_flight_that_lands_and_contacts_with_the_ground_are_no_fault():
    landing = replace(AUTOPILOT, armed=False, mode="AUTO.LAND")
    assert graph.check(having(autopilots=(landing,))) == []
    touches = Topic("/UAV/collision", "gazebo_msgs/ContactsState", ("/gazebo",), (), ODD, ODD)
    topics = {name: each for name, each in HEALTHY.topics.items() if name != "/clock"}
    assert bag.check(replace(HEALTHY, topics={**topics, touches.name: touches}, clock_s=())) == []
