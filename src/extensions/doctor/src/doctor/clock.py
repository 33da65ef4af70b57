"""Checks the clock, and whether messages carry its stamps."""

from __future__ import annotations

import math
from typing import Iterable, Iterator, Sequence

from doctor.diagnosis import ERROR, WARNING, Diagnosis
from doctor.expectations import QUIET_TOPICS, SETPOINTS
from doctor.snapshot import Graph, Recording, Topic

LATE_S, EARLY_S = 1.0, 0.1
"""A stamp that is older on arrival is useless. A stamp this far ahead is from another clock."""
ANOTHER_CLOCK_S = 3600.0


def running(graph: Graph) -> Iterator[Diagnosis]:
    """Check /clock against /use_sim_time."""
    topic = graph.recording.topics.get("/clock")
    speakers = sorted(set(topic.publishers)) if topic else []
    ticks = graph.recording.clock_s
    if graph.use_sim_time and not speakers:
        remedy = "Start the simulator (or rosbag play --clock), or: rosparam set use_sim_time false"
        yield Diagnosis(
            ERROR, "/clock", "use_sim_time is true and nobody publishes a clock: time stands at 0", remedy
        )
    elif graph.use_sim_time and (not ticks or ticks[-1] <= ticks[0]):
        remedy = f"rosservice call {speakers[0]}/unpause_physics, or look at its load"
        yield Diagnosis(WARNING, "/clock", f"stands still: {speakers[0]} is paused, or hangs", remedy)
    elif speakers and not graph.use_sim_time:
        remedy = (
            "rosparam set use_sim_time true, and start the other nodes again: they read it at their start"
        )
        yield Diagnosis(
            ERROR,
            "/use_sim_time",
            f"is false while {speakers[0]} publishes /clock: nodes run on wall time",
            remedy,
        )
    if len(speakers) > 1:
        remedy = "Keep one of them, end the other: rosnode kill"
        yield Diagnosis(
            ERROR, "/clock", f"{' and '.join(speakers)} publish it: time jumps to and fro", remedy
        )
    backwards = sum(later < earlier for earlier, later in zip(ticks, ticks[1:]))
    if backwards and len(speakers) < 2:
        yield Diagnosis(
            WARNING,
            "/clock",
            f"went back {backwards} times",
            "A reset or a looping bag: nodes clear their state each time",
        )


def stamps(recording: Recording) -> Iterator[Diagnosis]:
    """Check the messages' stamps: from this clock, neither late nor early, never going back."""
    for topic in recording.topics.values():
        if topic.name in ("/tf", "/tf_static") or QUIET_TOPICS.match(topic.name):
            continue  # transforms.py checks it
        times = _times(topic)
        if times:
            yield from _ages(topic.name, *_age_and_early(times), recording.is_simulated)
        if times and not SETPOINTS.match(topic.name):  # these have a scan's stamp, or at a hover the present
            yield from _order(topic.name, len(set(topic.publishers)), [stamp_s for _, _, stamp_s in times])


def is_right(node: str, recording: Recording) -> bool:
    """Return whether a node stamps what it alone publishes by this clock. False also if it stamps nothing."""
    own = [_times(topic) for topic in recording.topics.values() if set(topic.publishers) == {node}]
    stamped = [_age_and_early(times) for times in own if times]
    return bool(stamped) and all(
        early_s <= EARLY_S and age_s <= ANOTHER_CLOCK_S for age_s, early_s in stamped
    )


def _times(topic: Topic) -> list[tuple[float, float, float]]:
    """Return of each stamped message: when it was received, at the latest, and its stamp, s."""
    received = zip(topic.received_s, topic.latest_s or topic.received_s, topic.stamps_s)
    return [times for times in received if times[2] > 0.0 and not math.isnan(times[0])]


def _age_and_early(times: Sequence[tuple[float, float, float]]) -> tuple[float, float]:
    """Return how old stamps are when they come, and how far ahead, s."""
    age_s = median(received_s - stamp_s for received_s, _, stamp_s in times)
    return age_s, median(stamp_s - latest_s for _, latest_s, stamp_s in times)


def median(values: Iterable[float]) -> float:
    """Return the value in the middle, of two the greater one."""
    ordered = sorted(values)
    return ordered[len(ordered) // 2]


def _ages(name: str, age_s: float, early_s: float, is_simulated: bool) -> Iterator[Diagnosis]:
    if abs(age_s) > ANOTHER_CLOCK_S:
        remedy = "Its node was started before use_sim_time was set, or stamps by itself: start it again"
        yield Diagnosis(
            ERROR, name, "is stamped by another clock (wall time among simulated, or the reverse)", remedy
        )
    elif age_s > LATE_S:
        yield Diagnosis(
            WARNING,
            name,
            f"its stamps are {age_s:.1f} s old when they arrive",
            "Look at the load, and at queue sizes",
        )
    elif early_s > EARLY_S:
        yield Diagnosis(WARNING, name, f"its stamps are {early_s:.2f} s in the future", ahead(is_simulated))


def ahead(is_simulated: bool) -> str:
    """Return what to do about stamps in the future."""
    if is_simulated:
        return "Its node adds to the stamp, or its clock is not /clock: look where it takes the stamp from"
    return "Compare the clocks of the machines (chrony)"


def _order(name: str, publishers: int, stamps_s: list[float]) -> Iterator[Diagnosis]:
    backwards = sum(later < earlier for earlier, later in zip(stamps_s, stamps_s[1:]))
    if backwards and publishers < 2:
        remedy = "Several sources under one name, or a clock that was reset: look at who publishes"
        yield Diagnosis(WARNING, name, f"its stamps go back {backwards} times", remedy)
