"""The doctor's judgement of graphs made up by hand: one that is well, and one fault at a time."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from recordings import (
    ALGORITHM,
    AUTOPILOT,
    FINAL,
    HEALTHY,
    NODES,
    RAW,
    SAFE,
    VISION,
    WELL,
    edge,
    edge_late,
    having,
    late,
    scan,
    times,
    topic,
    with_edge,
    with_scan,
    with_topic,
)

from doctor import graph
from doctor.diagnosis import BROKEN, ERROR, FINE, NOTE, WARNING, exit_code
from doctor.snapshot import Launched, Node, Parameter


def test_a_graph_that_is_well_has_no_finding():
    assert graph.check(WELL) == []
    assert exit_code([]) == FINE


@pytest.mark.table(
    "topic",
    [
        "/mavros/vision_pose/pose",
        "/mavros/rc/override",
        "/mavros/distance_sensor/sonar_1_sub",
        "/mavros/manual_control/send",
        "/mavros/mocap/pose",
    ],
)
def test_an_input_that_mavros_can_do_without_is_no_finding(topic):
    assert graph.check(with_topic(topic, subscribers=("/mavros",))) == []
    assert [found.where for found in graph.check(with_topic("/mavros/state", subscribers=("/mine",)))]


@pytest.mark.table("topic", ["/joy", "/explore/explore/status", "/inspect/survey/status"])
def test_what_pilot_orders_can_do_without_is_no_finding(topic):
    assert graph.check(with_topic(topic, subscribers=("/pilot_orders",))) == []


@pytest.mark.table(
    ("topic", "node"),
    [
        ("/initialpose", "/gridslam"),
        ("/clicked_point", "/inspect"),
        ("/gazebo/odometry_without_gnss", "/tf_publisher"),
        ("/explore/explore/cancel", "/explore"),
        ("/scan_in", "/slam_octomap"),
    ],
)
def test_what_a_healthy_flight_lacks_is_no_finding(topic, node):
    assert graph.check(with_topic(topic, subscribers=(node,))) == []


def test_cepa_cannot_do_without_the_scans_that_the_map_of_voxels_can():
    (found,) = graph.check(with_topic("/scan_in", subscribers=("/slam_octomap", "/cepa")))
    assert (found.severity, found.where) == (NOTE, "/scan_in")


@pytest.mark.table("name", ["/rviz", "/two/rqt_reconfigure"])
def test_a_window_that_has_ended_is_no_error(name):
    (found,) = graph.check(replace(WELL, launched=(Launched(name, False),)))
    assert (found.severity, found.where) == (NOTE, name)
    assert exit_code([found]) == FINE


@pytest.mark.table("topic", ["/experiment/working", "/slam_octomap/working"])
def test_in_lockstep_a_participant_need_not_say_that_it_still_works(topic):
    assert graph.check(with_topic(topic, subscribers=("/gazebo",))) == []
    acknowledged = with_topic(topic.replace("working", "processed"), subscribers=("/gazebo",))
    assert [found.where for found in graph.check(acknowledged)]


def test_of_goals_those_contradict_whose_senders_do_not_hear_each_other():
    both = ("/experiment", "/pilot_orders")
    heard = with_topic("/UAV/pos_setpoint", publishers=both, subscribers=(*both, "/position_controller"))
    assert graph.check(heard) == []
    unheard = with_topic("/UAV/pos_setpoint", publishers=both, subscribers=("/position_controller",))
    assert ["/experiment and /pilot_orders both" in found.what for found in graph.check(unheard)] == [True]


def test_external_poses_that_mavros_takes_are_no_finding():
    poses = {"publishers": ("/vision_pose_publisher",), "subscribers": ("/mavros_publisher", "/mavros")}
    assert graph.check(with_topic(VISION, **poses)) == []


HOLE = tuple(t for t in times(100) if not 12.0 < t < 12.8)
LOOP = (edge("a", "b"), edge("b", "c"), edge("c", "a"))

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
    "wrong remap": (with_topic("/sacn", subscribers=("/mine",)), NOTE, "/sacn", "/mine subscribes"),
    "silence": (with_topic("/UAV/odometry", received_s=()), ERROR, "/UAV/odometry", "nothing came"),
    "slow": (with_topic("/UAV/odometry", received_s=times(4)), WARNING, "/UAV/odometry", "4.0 Hz"),
    "half of the scans": (with_topic("/scan/padded", received_s=times(20)), WARNING, "/scan/padded", "50 %"),
    "no answers": (with_topic(SAFE, received_s=()), ERROR, SAFE, "does not answer them"),
    "two commanders": (with_topic(FINAL, publishers=("/a", "/b")), ERROR, FINAL, "/a and /b both"),
    "MAVROS without mavros_extras": (
        with_topic(VISION, publishers=("/vision_pose_publisher",), subscribers=("/mavros_publisher",)),
        ERROR,
        VISION,
        "/mavros does not take them",
    ),
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
    "cut off as velodyne_laserscan does": (with_scan(angle_max=1.8), WARNING, "/scan", "make 7 beams"),
    "one beam more": (with_scan(ranges=np.ones(6)), WARNING, "/scan", "make 5 beams"),
    "no increment": (with_scan(angle_increment=0.0), ERROR, "/scan", "0 rad apart"),
    "no angle": (with_scan(angle_min=math.nan), ERROR, "/scan", "no numbers"),
    "limits turned": (with_scan(range_min=11.0), ERROR, "/scan", "leave nothing"),
    "zeros": (with_scan(ranges=np.array([0.0, 1.0, 1.0, 1.0, 0.05])), WARNING, "/scan", "40.0 %"),
    "too far": (with_scan(ranges=np.array([65.0, 1.0, 1.0, 1.0, 1.0])), WARNING, "/scan", "above range_max"),
    "range_max for nothing": (
        with_scan(ranges=np.full(21, 10.0), angle_increment=0.1),
        NOTE,
        "/scan",
        "100 % of its ranges are exactly 10 m",
    ),
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


@pytest.mark.table("case", BROKEN_GRAPHS)
def test_what_is_broken_is_found(case):
    broken, severity, where, what = BROKEN_GRAPHS[case]
    found = graph.check(broken)
    assert any(
        one.severity == severity and one.where.startswith(where) and what in one.what and one.remedy
        for one in found
    ), found
    assert exit_code(found) == (BROKEN if severity == ERROR else FINE), found


def test_padded_beams_and_free_space_are_no_fault():
    """NaN of the padding and +inf of the open field are what REP-117 means them to be."""
    open_field = scan(ranges=np.array([math.nan, math.inf, math.inf, math.inf, math.nan]))
    assert graph.check(having(scans=(open_field,))) == []


def test_a_transform_that_amcl_dates_ahead_is_no_wrong_clock():
    pose = topic("/amcl_pose", "geometry_msgs/PoseWithCovarianceStamped", "/amcl", 10)
    ahead = edge("map", "odom", "/amcl", stamps_s=tuple(t + 0.5 for t in times(100)))
    amcl = having(topics={**HEALTHY.topics, pose.name: pose}, transforms=(*HEALTHY.transforms, ahead))
    assert [one.severity for one in graph.check(amcl)] == [NOTE]


def test_who_takes_over_a_transform_is_no_rival():
    first, then = (tuple(t for t in times(100) if (t < 12.0) == early) for early in (True, False))
    taken = [
        edge("odom", "base_frame", name, received_s=stamps_s, stamps_s=stamps_s)
        for name, stamps_s in (("/odometry_1_17", first), ("/odometry_2_99", then))
    ]
    others = [one for one in HEALTHY.transforms if one.child != "base_frame"]
    assert not [one for one in graph.check(having(transforms=(*others, *taken))) if "both" in one.what]


def test_a_wrong_clock_is_told_once_not_of_every_topic():
    found = graph.check(replace(late("/scan", -1.7e9), use_sim_time=False))
    assert [one.where for one in found] == ["/use_sim_time"]


def test_a_flight_that_lands_is_no_fault():
    landing = replace(AUTOPILOT, armed=False, mode="AUTO.LAND")
    assert graph.check(having(autopilots=(landing,))) == []
