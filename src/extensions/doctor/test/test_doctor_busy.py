"""The doctor on a busy machine: what is taken in late is no fault of the nodes."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace as Message

import pytest
from recordings import SAFE, WELL, edge_late, with_topic

from doctor import bag, graph
from doctor.diagnosis import ERROR, NOTE, WARNING

recorder = pytest.importorskip("doctor_ros.recorder")

NODES = {"/scan": "/gazebo", "/imu": "/mavros", "/UAV/odometry": "/other", "/camera": "/camera_driver"}


def at(stamp_s: float) -> Message:
    return Message(to_sec=lambda: stamp_s)


def stamped(stamp_s: float) -> Message:
    return Message(header=Message(stamp=at(stamp_s), frame_id="odom"))


def transforms(stamp_s: float) -> Message:
    edge = stamped(stamp_s)
    edge.child_frame_id = "base_frame"
    edge.transform = Message(translation=Message(x=0, y=0, z=0), rotation=Message(x=0, y=0, z=0, w=1))
    return Message(transforms=[edge])


def heard(clock_late_s: float, ahead_s: dict[str, float]):
    """Return a recorder that heard 5 s of four nodes at 10 Hz, and /clock later than all others.

    ahead_s: by which a topic's stamps are in the future.
    """
    found = recorder.Recorder()
    events = [(1.0 + 0.01 * tick + clock_late_s, "/clock", 1.0 + 0.01 * tick) for tick in range(500)]
    for topic in (*NODES, "/tf"):
        events += [(1.0 + 0.1 * k, topic, 1.0 + 0.1 * k + ahead_s.get(topic, 0.0)) for k in range(1, 50)]
    now_s = math.nan
    for wall_s, topic, stamp_s in sorted(events):
        if topic == "/clock":
            now_s = stamp_s
            found.hear(
                topic, "rosgraph_msgs/Clock", "/gazebo", Message(clock=at(stamp_s)), now_s, False, wall_s
            )
        elif topic == "/tf":
            found.hear(
                topic, "tf2_msgs/TFMessage", "/tf_publisher", transforms(stamp_s), now_s, False, wall_s
            )
        else:
            found.hear(topic, "any/Stamped", NODES[topic], stamped(stamp_s), now_s, False, wall_s)
    return found


def in_the_future(diagnoses) -> list[str]:
    return sorted(one.where for one in diagnoses if "future" in one.what)


@pytest.mark.table("clock_late_s", [0.0, 0.3])
@pytest.mark.table(
    ("ahead_s", "expected"),
    [({}, []), ({"/camera": 1.5}, ["/camera"]), ({"/tf": 1.5}, ["tf odom -> base_frame"])],
)
def test_a_clock_that_is_heard_late_makes_no_stamp_early(clock_late_s, ahead_s, expected):
    found = heard(clock_late_s, ahead_s)
    live = found.recording(6.0, {topic: [node] for topic, node in NODES.items()}, {}, {})
    told = graph.check(replace(WELL, recording=live))
    assert in_the_future(told) == expected
    assert all("chrony" not in one.remedy for one in told)  # one machine's simulated time needs no such thing


@pytest.mark.table("clock_late_s", [0.0, 0.28])
@pytest.mark.table(("ahead_s", "expected"), [({}, []), ({"/camera": 1.5}, ["/camera"])])
def test_so_does_none_in_a_bag_whose_recorder_heard_it_late(clock_late_s, ahead_s, expected):
    assert in_the_future(bag.check(heard(clock_late_s, ahead_s).recording(6.0))) == expected


def test_a_clock_of_another_machine_is_found_on_wall_time():
    found = recorder.Recorder()
    for topic, node in NODES.items():
        for k in range(50):
            now_s = 1.7e9 + 0.1 * k
            found.hear(topic, "any/Stamped", node, stamped(now_s + 0.5), now_s)
    diagnoses = bag.check(found.recording(1.7e9 + 5.0))
    assert in_the_future(diagnoses) == sorted(NODES)
    assert "chrony" in diagnoses[0].remedy


BUSY = 0.6


@pytest.mark.table(
    "late", [edge_late(3.0), with_topic(SAFE, received_s=()), with_topic("/UAV/odometry", received_s=())]
)
def test_delays_on_a_busy_machine_are_warnings(late):
    assert ERROR in {one.severity for one in graph.check(late)}
    found = graph.check(replace(late, waited_share=BUSY))
    assert {one.severity for one in found} == {NOTE, WARNING}
    (note,) = (one for one in found if one.severity == NOTE)
    assert (note.where, note.what) == (
        "machine",
        "is busy: the doctor waited 60 % of its time for a processor",
    )


@pytest.mark.parametrize(
    ("signs", "told"),
    [({"load": 2.4}, "2.4 programs"), ({"factor": 1.0, "wall_s": 100.0}, "real-time factor is 0.")],
)
def test_a_load_or_a_slow_clock_is_told_before_any_node_is_blamed(signs, told):
    late = replace(edge_late(3.0), **signs)
    found = graph.check(late)
    (note,) = (one for one in found if one.where == "machine")
    assert told in note.what
    (edge,) = (one for one in found if "late" in one.what)
    assert edge.severity == WARNING
    assert edge.remedy.startswith("The machine is busy: free it first.")


def test_a_simulator_that_is_asked_to_be_slow_is_no_busy_machine():
    kept = replace(WELL, wall_s=100.0).kept_factor
    assert not [
        one for one in graph.check(replace(WELL, wall_s=100.0, factor=kept)) if one.where == "machine"
    ]


def test_a_publisher_that_hovers_between_scans_is_no_fault():
    """Its setpoints have the scan's stamp; at a hover without scans they have the present, which is later."""
    name = "/mavros/setpoint_raw/local"
    assert graph.check(with_topic(name, stamps_s=(14.0, 13.98, 14.1) * 20, received_s=(14.1,) * 60)) == []


def test_a_publisher_that_was_started_again_under_a_new_name_is_no_second_one():
    found = recorder.Recorder()
    for k in range(100):
        now_s = 1.7e9 + 0.1 * k
        node = "/controller_1_17" if k < 50 else "/controller_2_99"
        found.hear("/UAV/vel_setpoint/raw/body", "any/Stamped", node, stamped(now_s), now_s)
    told = [one.what for one in bag.check(found.recording(1.7e9 + 10.0))]
    assert not [what for what in told if "both publish" in what], told
