"""Camera, battery, disk and computer: each is passed in order, and fails when its thing is missing."""

from dataclasses import replace

import pytest

from doctor.preflight import carried
from doctor.preflight.standing import ODOMETRY
from doctor.snapshot import Graph, Node, Recording, Topic

POSES_S = tuple(1.7e9 + 0.1 * i for i in range(50))
MACHINE = carried.Machine("/data", 20e9, 600.0, 4, 2.0, shutter="")


def topic(name, *stamps_s):
    return Topic(name, "x", ("/node",), (), tuple(stamp + 0.1 for stamp in stamps_s), stamps_s)


TOPICS = (topic(ODOMETRY, *POSES_S), topic(carried.PICTURES, POSES_S[20]), topic(carried.BATTERY, POSES_S[0]))
GOOD = Graph(Recording({one.name: one for one in TOPICS}), (Node("/inspect"), Node("/record")))


def changed(*topics, without=()):
    found = {name: one for name, one in GOOD.recording.topics.items() if name not in without}
    found.update({one.name: one for one in topics})
    return replace(GOOD, recording=replace(GOOD.recording, topics=found))


def test_a_uav_in_order_passes_everything():
    """600 s of 10 MB, 4 GB of photographs and 1 GB: 11 GB of 20."""
    assert [str(one) for one in carried.check(GOOD, MACHINE) if not one.passed] == []


@pytest.mark.table(
    ("graph", "machine", "name", "words"),
    [
        (changed(without=(carried.PICTURES,)), {"shutter": None}, "camera", "nobody offers camera/shoot"),
        (changed(without=(carried.PICTURES,)), {}, "camera", "no picture came on /camera/image_raw"),
        (GOOD, {"shutter": "no card"}, "camera", "the shutter says: no card"),
        (changed(topic(carried.PICTURES, 12.0)), {}, "camera", "off the poses' times"),
        (changed(topic(carried.PICTURES, float("nan"))), {}, "camera", "the picture has no time"),
        (changed(without=(carried.BATTERY,)), {}, "battery", "nothing comes on /mavros/battery"),
        (GOOD, {"free_b": 10e9}, "disk", "10.0 GB are free in /data, and a flight of 600 s needs 11.0 GB"),
        (GOOD, {"free_cores": 0.9}, "computer", "0.9 of 4 cores are free"),
    ],
)
def test_what_is_missing_fails_its_check(graph, machine, name, words):
    verdicts = {one.name: one for one in carried.check(graph, replace(MACHINE, **machine))}
    assert not verdicts[name].passed
    assert words in verdicts[name].sentence
    assert [other for other in verdicts.values() if not other.passed] == [verdicts[name]]


def test_a_uav_without_camera_and_recorder_needs_neither():
    graph = replace(changed(without=(carried.PICTURES,)), nodes=())
    verdicts = carried.check(graph, replace(MACHINE, shutter=None, free_b=1.5e9))
    assert all(one.passed for one in verdicts)
