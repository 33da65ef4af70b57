"""Checks a bag: its messages like those of a running graph, its gaps, and the nodes that can use it."""

from __future__ import annotations

from typing import Iterator

from doctor import clock, graph, parameters, scans, transforms
from doctor.diagnosis import ERROR, NOTE, WARNING, Diagnosis
from doctor.expectations import QUIET_TOPICS, SETPOINTS
from doctor.snapshot import Parameter, Recording

GAP_FACTOR, LEAST_GAP_S, LEAST_RATE_HZ = 10.0, 0.5, 4.0
"""A gap lasts at least this many of the topic's usual steps, and this many seconds."""

EVENTS = ("gazebo_msgs/ContactsState",)
"""Types whose messages come only during an event."""

SCAN, VELOCITY, ODOMETRY = "sensor_msgs/LaserScan", "geometry_msgs/TwistStamped", "nav_msgs/Odometry"


def check(recording: Recording, described: tuple[Parameter, ...] = ()) -> list[Diagnosis]:
    """Return all diagnoses about a bag."""
    found: list[Diagnosis] = []
    for one in (contents, gaps, graph.commands, graph.chain, graph.autopilot, clock.stamps):
        found += one(recording)
    found += [*transforms.structure(recording), *transforms.times(recording)]
    found += [*scans.check(recording), *playable(recording)]
    return found + list(parameters.check(described))


def contents(recording: Recording) -> Iterator[Diagnosis]:
    """Check whether the bag holds anything."""
    if not any(topic.received_s for topic in recording.topics.values()):
        yield Diagnosis(
            ERROR, "bag", "holds no messages", "Record again, with topics that are published (rostopic list)"
        )


def gaps(recording: Recording) -> Iterator[Diagnosis]:
    """Check for gaps in otherwise regular topics."""
    for topic in recording.topics.values():
        if topic.type in EVENTS or len(topic.received_s) < 20:
            continue
        if QUIET_TOPICS.match(topic.name) or SETPOINTS.match(topic.name):
            continue
        steps_s = [later - earlier for earlier, later in zip(topic.received_s, topic.received_s[1:])]
        usual_s, (longest_s, at) = (
            sorted(steps_s)[len(steps_s) // 2],
            max((s, i) for i, s in enumerate(steps_s)),
        )
        steady = sorted(steps_s)[int(0.99 * (len(steps_s) - 1))] < 3.0 * max(usual_s, 1e-3)
        if steady and usual_s < 1.0 / LEAST_RATE_HZ and longest_s > max(GAP_FACTOR * usual_s, LEAST_GAP_S):
            usual = f"comes every {1e3 * usual_s:.0f} ms"
            yield Diagnosis(
                WARNING,
                topic.name,
                f"{usual}, but not for {longest_s:.2f} s from {topic.received_s[at]:.2f} s on",
                "Its node died or was paused there, or the disk was too slow (rosbag --buffsize)",
            )


def playable(recording: Recording) -> Iterator[Diagnosis]:
    """Check which inputs of CEPA and gridslam the bag lacks."""
    have = {topic.type for topic in recording.of_type(SCAN, VELOCITY, ODOMETRY)}
    for type_name, what in ((SCAN, "scans"), (VELOCITY, "a reference velocity"), (ODOMETRY, "odometry")):
        if type_name not in have:
            remedy = f"Record a topic of {type_name} as well"
            yield Diagnosis(NOTE, "cepa", f"cannot be fed from this bag: it has no {what}", remedy)
    if SCAN not in have:
        yield Diagnosis(
            NOTE, "gridslam", "cannot be fed from this bag: it has no scans", f"Record a topic of {SCAN}"
        )
    elif not any(_reaches_odometry(scan.frame, recording) for scan in recording.scans):
        what = "cannot be fed from this bag: TF does not lead from the scans' frame to a frame that moves"
        yield Diagnosis(
            NOTE, "gridslam", what, "Record /tf and /tf_static, with odom -> base and base -> lidar"
        )
    if "/clock" in recording.topics and recording.topics["/clock"].received_s:
        yield Diagnosis(
            NOTE, "/clock", "is in the bag", "Play it without --clock, which would make a second one"
        )


def _reaches_odometry(frame: str, recording: Recording) -> bool:
    """Return whether one of the edges above a frame is not static."""
    edge_of = {edge.child: edge for edge in recording.transforms}
    frame, moved, steps = frame.lstrip("/"), False, 0
    while frame in edge_of and steps <= len(edge_of):
        moved = moved or not edge_of[frame].static
        frame, steps = edge_of[frame].parent, steps + 1
    return moved
