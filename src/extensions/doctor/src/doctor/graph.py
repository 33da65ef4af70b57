"""Checks the nodes and topics of a running graph: dead nodes, missing publishers, rival commands."""

from __future__ import annotations

from dataclasses import replace
from typing import Iterable, Iterator

from doctor import clock, parameters, scans, transforms
from doctor.diagnosis import ERROR, NOTE, WARNING, Diagnosis
from doctor.expectations import (
    BESIDE_CLOUDS,
    CHAIN,
    EXTERNAL_POSES,
    FOLLOWED_SHARE,
    LEAST_SETPOINT_RATE_HZ,
    OPTIONAL_INPUTS,
    QUIET_TOPICS,
    RATES_HZ,
    SETPOINTS,
    VIEWERS,
    is_command,
)
from doctor.snapshot import Graph, Recording, Topic

OBEYING, LANDING = ("OFFBOARD", "GUIDED"), ("AUTO.LAND", "LAND")
"""Modes that follow setpoints; the mode at the end of every flight, while the publisher still streams."""

BUSY_SHARE = 0.3
BUSY_LOAD = 1.5
"""Programs for each processor. The graph of a flight alone asks for about one on two cores."""
BUSY_FACTOR = 0.9
"""Of the real-time factor that was asked for."""
LEAST_SPAN_S = 2.0
"""A shorter time is not enough for a rate."""


def check(graph: Graph) -> list[Diagnosis]:
    """Return all diagnoses about a running graph.

    What a busy machine may have made late is only a warning there, and the machine is to be freed first.
    """
    recording = graph.recording
    timely = [*rates(graph), *chain(recording)]
    if (
        graph.use_sim_time or not recording.clock_s
    ):  # else all stamps are from another clock, which is a diagnosis already
        timely += [*clock.stamps(recording), *transforms.times(recording)]
    if _busy(graph):
        timely = [
            replace(
                diagnosis,
                severity=WARNING if diagnosis.severity == ERROR else diagnosis.severity,
                remedy=f"The machine is busy: free it first. If it stays so: {diagnosis.remedy}",
            )
            for diagnosis in timely
        ]
    found = [
        diagnosis for one in (load, nodes, unheard, external_poses, clock.running) for diagnosis in one(graph)
    ]
    for one in (commands, autopilot, transforms.structure, scans.check):
        found += one(recording)
    return [*found, *timely, *parameters.check(graph.parameters)]


def load(graph: Graph) -> Iterator[Diagnosis]:
    """Note that the machine is busy: then delays and missing messages are not the nodes' fault."""
    if signs := _busy(graph):
        remedy = (
            "End other programs, or fly slower (real_time_factor:=0.5), and examine again; until then delays "
            "and rates tell little"
        )
        yield Diagnosis(NOTE, "machine", f"is busy: {', '.join(signs)}", remedy)


def _busy(graph: Graph) -> list[str]:
    """Return the signs of a machine that is busy; none: it is not."""
    signs = []
    if graph.waited_share > BUSY_SHARE:
        signs.append(f"the doctor waited {100.0 * graph.waited_share:.0f} % of its time for a processor")
    if graph.load > BUSY_LOAD:
        signs.append(f"{graph.load:.1f} programs want each processor")
    if graph.kept_factor < BUSY_FACTOR * graph.factor:
        signs.append(f"the real-time factor is {graph.kept_factor:.2f} of {graph.factor:g}")
    return signs


def nodes(graph: Graph) -> Iterator[Diagnosis]:
    """Check for dead nodes: known to the master or a roslaunch, and silent."""
    known = {node.name for node in graph.nodes}
    for node in graph.nodes:
        if not node.answers:
            yield Diagnosis(
                ERROR,
                node.name,
                "is registered with the master and does not answer",
                "rosnode cleanup, then start it again",
            )
    for launched in graph.launched:
        if not launched.running and VIEWERS.match(launched.name):
            what = "has ended, and nothing else needs it"
            remedy = "Nothing, if there is no screen, or if you closed its window"
            yield Diagnosis(NOTE, launched.name, what, remedy)
        elif not launched.running:
            yield Diagnosis(
                ERROR,
                launched.name,
                "was launched and has ended",
                "Read why in its log; start it by rosrun or launch again",
            )
        elif launched.name not in known:
            yield Diagnosis(
                WARNING,
                launched.name,
                "its process runs, but the master does not know it",
                "Wait if it is starting; else kill it, so that roslaunch starts it again",
            )
        if launched.starts > 1:
            what = f"has ended {launched.starts - 1} times and been started again"
            yield Diagnosis(WARNING, launched.name, what, "Read why in its log (~/.ros/log/latest)")


def unheard(graph: Graph) -> Iterator[Diagnosis]:
    """Check for topics with subscribers but no publisher: a wrong remap, or a missing node."""
    in_chain = {link.topic for link in CHAIN} | {link.source for link in CHAIN}
    for topic in graph.recording.topics.values():
        if topic.publishers or not topic.subscribers:
            continue
        if QUIET_TOPICS.match(topic.name) or OPTIONAL_INPUTS.match(topic.name) or topic.name == "/clock":
            continue
        if all(name.endswith("/mavros") for name in topic.subscribers):  # takes what anyone may send it
            continue
        if all(topic.name in BESIDE_CLOUDS.get(name, ()) for name in topic.subscribers):
            continue
        what = f"{_names_in_words(topic.subscribers)} subscribes, but nobody publishes"
        remedy = "Start who publishes it, or remap the listener to what is there (rostopic list)"
        yield Diagnosis(ERROR if topic.name in in_chain else NOTE, topic.name, what, remedy)


def external_poses(graph: Graph) -> Iterator[Diagnosis]:
    """Check whether MAVROS takes the poses by which the UAV flies without GNSS."""
    for state in graph.recording.autopilots:
        mavros = state.topic[: -len("/state")]
        for name in EXTERNAL_POSES:
            topic = graph.recording.topics.get(f"{mavros}/{name}")
            if topic is None or not topic.publishers or mavros in topic.subscribers:
                continue
            what = f"{_names_in_words(topic.publishers)} publishes poses, and {mavros} does not take them"
            yield Diagnosis(ERROR, topic.name, what, "Install mavros_extras and start MAVROS again")


def rates(graph: Graph) -> Iterator[Diagnosis]:
    """Check rates against the least that the stack needs. While time stands still there are none."""
    span_s = _span_s(graph)
    for name, least_hz in RATES_HZ.items():
        topic = graph.recording.topics.get(name)
        if topic is None or not topic.publishers or span_s < LEAST_SPAN_S:
            continue
        rate_hz = len(topic.received_s) / span_s
        if not topic.received_s:
            what = f"nothing came in {span_s:.0f} s from {_names_in_words(topic.publishers)}"
            yield Diagnosis(ERROR, name, what, "Is that node hung? rosnode kill it, and it is started again")
        elif rate_hz < least_hz / 2.0:
            what = f"{rate_hz:.1f} Hz, and at least {least_hz:g} are expected"
            yield Diagnosis(WARNING, name, what, "Look at the load of the machine (top)")


def chain(recording: Recording) -> Iterator[Diagnosis]:
    """Check whether each step from scan to velocity answers its input."""
    for link in CHAIN:
        source, topic = recording.topics.get(link.source), recording.topics.get(link.topic)
        if source is None or topic is None or not topic.publishers or len(source.received_s) < 10:
            continue
        share = len(topic.received_s) / len(source.received_s)
        if not topic.received_s:
            yield Diagnosis(
                ERROR,
                link.topic,
                f"{link.source} has messages, but {_names_in_words(topic.publishers)} does not answer them",
                "Read the node's warnings: rostopic echo /rosout",
            )
        elif share < FOLLOWED_SHARE:
            what = (
                f"has {100.0 * share:.0f} % of the messages of {link.source}, of which it is made one for one"
            )
            yield Diagnosis(
                WARNING,
                link.topic,
                what,
                "The node is too slow or refuses messages: look at its load and at /rosout",
            )


def commands(recording: Recording) -> Iterator[Diagnosis]:
    """Check whether two nodes publish the same command.

    Of the goal's publishers, one that also hears it gives way to the others (`SetpointSender`).
    """
    for topic in recording.topics.values():
        goal = topic.name.endswith("pos_setpoint")
        speakers = sorted(set(topic.publishers) - set(topic.subscribers if goal else ()))
        if is_command(topic.name) and len(speakers) > 1:
            what = f"{' and '.join(speakers)} both publish commands"
            yield Diagnosis(
                WARNING if goal else ERROR, topic.name, what, "Keep one of them, end the other: rosnode kill"
            )


def autopilot(recording: Recording) -> Iterator[Diagnosis]:
    """Check MAVROS's link, and whether the flight controller follows the setpoints."""
    rate = max(
        (_rate_hz(topic) for topic in recording.topics.values() if SETPOINTS.match(topic.name)), default=0.0
    )
    for state in recording.autopilots:
        if not state.connected:
            yield Diagnosis(
                ERROR,
                state.topic,
                "MAVROS hears no flight controller",
                "Check fcu_url and that the flight controller (or gazebo) runs",
            )
        elif state.armed and state.mode == "OFFBOARD" and 0.0 < rate < LEAST_SETPOINT_RATE_HZ:
            what = f"setpoints come at {rate:.1f} Hz, and PX4 needs more than {LEAST_SETPOINT_RATE_HZ:g}"
            yield Diagnosis(ERROR, state.topic, what, "Look at mavros_publisher and the load of the machine")
        elif rate > 0.0 and state.mode not in LANDING and not (state.armed and state.mode in OBEYING):
            armed = "armed" if state.armed else "disarmed"
            what = f"setpoints come, but the flight controller is {armed} in {state.mode}"
            yield Diagnosis(
                NOTE, state.topic, what, "rosservice call /mavros_publisher/restart takes off again"
            )


def _names_in_words(nodes: Iterable[str]) -> str:
    return ", ".join(sorted(set(nodes))) or "nobody"


def _span_s(graph: Graph) -> float:
    """Return how long the graph was observed, on its own clock."""
    ticks = graph.recording.clock_s
    if not graph.use_sim_time:
        return graph.wall_s
    return ticks[-1] - ticks[0] if ticks else 0.0


def _rate_hz(topic: Topic) -> float:
    """Return a topic's mean rate by the times of arrival."""
    if len(topic.received_s) < 2 or topic.received_s[-1] <= topic.received_s[0]:
        return 0.0
    return (len(topic.received_s) - 1) / (topic.received_s[-1] - topic.received_s[0])
