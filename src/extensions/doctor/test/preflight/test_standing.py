"""Each check of the standing UAV is passed by a graph in order, and failed when its thing is missing."""

from dataclasses import replace

import numpy as np
import pytest

from doctor.preflight import standing
from doctor.preflight.verdict import FAILED, FINE, Verdict, exit_code
from doctor.snapshot import Autopilot, Graph, Recording, Scan, Topic, Transform

TIMES_S = tuple(1.7e9 + np.arange(0.0, 3.0, 0.025))
FCU = {"COM_OF_LOSS_T": 1.0}


def topic(name, times_s=TIMES_S, publisher="/node", late_s=0.01):
    return Topic(name, "x", (publisher,), (), tuple(time + late_s for time in times_s), times_s)


def scan(ranges):
    return Scan("/scan", "hokuyo", -1.0, 1.0, 0.5, 0.1, 10.0, np.array(ranges, np.float32))


GOOD = Graph(
    Recording(
        {
            name: topic(name)
            for name in (standing.SCAN, standing.PADDED, standing.ODOMETRY, standing.SAFE, standing.FINAL)
        },
        (
            Transform("odom", "base_frame", "/tf_publisher"),
            Transform("base_frame", "hokuyo", "/tf_publisher"),
        ),
        (scan([np.inf, 1.0, 2.0, 3.0, np.nan]),),
        (Autopilot("/mavros/state", True, False, "POSCTL"),),
        (),
        TIMES_S[-1],
    ),
    use_sim_time=False,
)


def changed(topics=(), without=(), **recording):
    found = {name: one for name, one in GOOD.recording.topics.items() if name not in without}
    found.update({one.name: one for one in topics})
    return replace(GOOD, recording=replace(GOOD.recording, topics=found, **recording))


def test_a_graph_in_order_passes_everything():
    verdicts = standing.check(GOOD, FCU)
    assert [str(verdict) for verdict in verdicts if not verdict.passed] == []
    assert len({verdict.name for verdict in verdicts}) == 9
    assert exit_code(verdicts) == FINE


SLOW_S = TIMES_S[::40]
VISION = topic(standing.VISION, SLOW_S)
FAULTS = {
    "clock stands": (replace(GOOD, use_sim_time=True), "clock", "every node's time stands still"),
    "simulator's clock": (changed(clock_s=(1.0, 2.0)), "clock", "a node publishes /clock"),
    "no MAVROS": (changed(autopilots=()), "flight controller", "nothing comes on /mavros/state"),
    "no cable": (
        changed(autopilots=(Autopilot("/mavros/state", False, False, ""),)),
        "flight controller",
        "not connected",
    ),
    "armed": (
        changed(autopilots=(Autopilot("/mavros/state", True, True, "OFFBOARD"),)),
        "flight controller",
        "it is armed",
    ),
    "no lidar": (changed(without=("/scan",), scans=()), "lidar", "nothing comes on /scan"),
    "slow lidar": (changed([topic("/scan", SLOW_S)]), "lidar", "only 1.0 messages a second"),
    "covered lidar": (changed(scans=(scan([0.0] * 5),)), "lidar", "only 0 % of the beams"),
    "lidar's clock": (changed([topic("/scan", late_s=0.6)]), "lidar", "are 0.6 s old"),
    "no odometry": (changed(without=(standing.ODOMETRY,)), "odometry", "nothing comes on /UAV/odometry"),
    "no frame of the lidar": (
        changed(transforms=GOOD.recording.transforms[:1]),
        "frames",
        "TF does not lead from base_frame to hokuyo",
    ),
    "no frame of the UAV": (
        changed(transforms=GOOD.recording.transforms[1:]),
        "frames",
        "TF does not lead from odom to base_frame",
    ),
    "MAVROS's TF": (
        changed(transforms=(*GOOD.recording.transforms, Transform("odom", "base_frame", "/mavros"))),
        "frames",
        "base_frame is published by /mavros as child of odom and /tf_publisher",
    ),
    "no filter": (changed(without=(standing.PADDED,)), "avoidance", "0 messages a second on /scan/padded"),
    "no cepa": (changed(without=(standing.SAFE,)), "avoidance", "0 messages a second on"),
    "other stamps": (
        changed([topic(standing.SAFE, tuple(time + 0.001 for time in TIMES_S))]),
        "avoidance",
        "only 0 % of CEPA's commands carry the stamp of a scan",
    ),
    "two commanders": (
        changed([replace(topic(standing.FINAL), publishers=("/a", "/b"))]),
        "commands",
        "/a and /b both publish",
    ),
    "no regulator": (changed(without=(standing.FINAL,)), "commands", "nothing comes on"),
    "slow poses": (changed([VISION]), "external poses", "1 poses a second"),
}


@pytest.mark.table(("graph", "name", "words"), FAULTS.values())
def test_what_is_missing_fails_its_check(graph, name, words):
    verdicts = {verdict.name: verdict for verdict in standing.check(graph, FCU)}
    assert str(verdicts[name]).startswith(f"failed  {name}: ")
    assert words in verdicts[name].sentence
    assert exit_code(list(verdicts.values())) == FAILED


@pytest.mark.table(
    ("parameters", "words"),
    [
        ({}, "cannot be read"),
        ({"COM_OF_LOSS_T": 5.0}, "flies on for 5 s"),
        ({"COM_OF_LOSS_T": float("nan")}, "flies on for nan s"),
        ({"GUID_TIMEOUT": 3.0}, "ArduPilot flies on for 3 s"),
    ],
)
def test_a_late_failsafe_fails(parameters, words):
    verdict = standing.failsafe(GOOD, parameters)
    assert not verdict.passed
    assert words in verdict.sentence


def test_ardupilot_passes_by_its_own_parameter():
    verdict = standing.failsafe(GOOD, {"GUID_TIMEOUT": 1.0})
    assert verdict.passed
    assert verdict.sentence == "ArduPilot notices missing setpoints after 1 s"


def test_a_verdict_is_one_line():
    assert str(Verdict("lidar", "it turns")) == "passed  lidar: it turns."
    assert str(Verdict("lidar", "it stands", "Turn it")) == "failed  lidar: it stands. -> Turn it."
