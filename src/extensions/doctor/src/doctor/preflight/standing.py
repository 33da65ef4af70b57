"""The checks while the UAV stands, disarmed, and all nodes run: whether each link of the chain answers."""

from __future__ import annotations

from typing import Callable, Mapping

import numpy as np

from doctor.preflight.verdict import Verdict
from doctor.snapshot import Graph, Topic

SCAN, PADDED = "/scan", "/scan/padded"
ODOMETRY = "/UAV/odometry"
SAFE, FINAL = "/UAV/vel_setpoint/safe/body", "/UAV/vel_setpoint/final/body"
STATE, VISION = "/mavros/state", "/mavros/vision_pose/pose_cov"
ODOM_FRAME, BASE_FRAME = "odom", "base_frame"
SCAN_LEAST_HZ, ODOMETRY_LEAST_HZ, COMMAND_LEAST_HZ = 5.0, 10.0, 5.0
"""PX4 leaves OFFBOARD below 2 Hz. The slowest of the thesis's lidars turns at 10 Hz."""
ANSWERED_SHARE = 0.8
"""Of the scans; some come while the listener begins or ends."""
LATE_S = 0.3
SEEN_SHARE = 0.05
"""Of the beams; a UAV in the open sees nothing with most of them."""
STREAM_TIMEOUT_MOST_S = 1.0
STREAM_TIMEOUTS = {"COM_OF_LOSS_T": "PX4", "GUID_TIMEOUT": "ArduPilot"}
"""Parameter of the flight controller, and which one has it: time without setpoints until it notices, s."""
Check = Callable[[Graph, Mapping[str, float]], Verdict]


def check(graph: Graph, parameters: Mapping[str, float]) -> list[Verdict]:
    """Return all verdicts, in the order in which to mend. parameters: those of the flight controller."""
    return [one(graph, parameters) for one in CHECKS]


def clock(graph: Graph, _: Mapping[str, float]) -> Verdict:
    """Check that all nodes use the wall clock, or that a simulator's clock runs."""
    ticks = len(graph.recording.clock_s)
    if graph.use_sim_time and not ticks:
        what = "/use_sim_time is true, and no /clock comes, so that every node's time stands still"
        return Verdict("clock", what, "rosparam delete /use_sim_time, and start the nodes anew")
    if ticks and not graph.use_sim_time:
        what = "a node publishes /clock, as a simulator or a bag does"
        return Verdict("clock", what, "End that node")
    return Verdict("clock", "simulated time runs" if ticks else "all nodes use the wall clock")


def flight_controller(graph: Graph, _: Mapping[str, float]) -> Verdict:
    """Check that MAVROS has its flight controller, and that this one is disarmed."""
    name = "flight controller"
    state = next((one for one in graph.recording.autopilots if one.topic == STATE), None)
    if state is None:
        return Verdict(
            name, f"nothing comes on {STATE}", "Start MAVROS, for example with fcu_url:=/dev/ttyTHS1:921600"
        )
    if not state.connected:
        return Verdict(
            name, "MAVROS is not connected", "Look at the cable, fcu_url and the baud rate of both ends"
        )
    if state.armed:
        return Verdict(name, "it is armed", "Disarm it, and start real.launch with fly:=false on the bench")
    return Verdict(name, f"MAVROS is connected, the UAV is disarmed, mode {state.mode}")


def failsafe(_: Graph, parameters: Mapping[str, float]) -> Verdict:
    """Check how soon the flight controller notices that setpoints are missing."""
    name, one = "failsafe", next((one for one in STREAM_TIMEOUTS if one in parameters), None)
    if one is None:
        known = " and ".join(f"{one} of {who}" for one, who in STREAM_TIMEOUTS.items())
        what = f"{known} cannot be read, so nobody knows when a loss of the setpoints is noticed"
        return Verdict(name, what, "Wait until MAVROS has read all parameters, and try again")
    who, timeout_s = STREAM_TIMEOUTS[one], parameters[one]
    if not timeout_s <= STREAM_TIMEOUT_MOST_S:  # true for NaN, too
        what = f"{who} flies on for {timeout_s:g} s after the last setpoint"
        return Verdict(name, what, f"Set {one} to {STREAM_TIMEOUT_MOST_S:g} s or less")
    return Verdict(name, f"{who} notices missing setpoints after {timeout_s:g} s")


def lidar(graph: Graph, _: Mapping[str, float]) -> Verdict:
    """Check that scans come, in time, and show something."""
    complaint = _stream(
        graph, SCAN, SCAN_LEAST_HZ, "Start the lidar's driver, and look at its address and power"
    )
    if complaint is not None:
        return Verdict("lidar", *complaint)
    scans = [scan for scan in graph.recording.scans if scan.topic == SCAN]
    ranges = np.concatenate([scan.ranges for scan in scans])
    limits = np.concatenate(
        [np.tile((scan.range_min, scan.range_max), (len(scan.ranges), 1)) for scan in scans]
    )
    with np.errstate(invalid="ignore"):
        seen = np.mean((ranges >= limits[:, 0]) & (ranges <= limits[:, 1]))
    if not seen >= SEEN_SHARE:  # true for NaN: scans without beams
        what = f"only {100 * np.nan_to_num(seen):.0f} % of the beams see something"
        return Verdict("lidar", what, "Put the UAV where walls are, and look whether the lidar is covered")
    return Verdict(
        "lidar", f"{_rate_hz(graph, SCAN):.0f} scans a second, {100 * seen:.0f} % of the beams see something"
    )


def frames(graph: Graph, _: Mapping[str, float]) -> Verdict:
    """Check that TF leads from odom through base_frame to the lidar, with one publisher for each frame."""
    recording = graph.recording
    publishers: dict[str, set[str]] = {}
    parents: dict[str, str] = {}
    for edge in recording.transforms:
        publishers.setdefault(edge.child, set()).add(f"{edge.publisher} as child of {edge.parent}")
        parents[edge.child] = edge.parent
    for frame in sorted(publishers):
        if len(publishers[frame]) > 1:
            who = " and ".join(sorted(publishers[frame]))
            return Verdict(
                "frames", f"{frame} is published by {who}", "Leave one; MAVROS's tf/send must be false"
            )
    scan_frame = next((scan.frame for scan in recording.scans if scan.topic == SCAN), "hokuyo")
    for frame, above, remedy in (
        (
            scan_frame,
            BASE_FRAME,
            "Give the driver the frame_id of a frame in your SDF, and that SDF as model:=",
        ),
        (
            BASE_FRAME,
            ODOM_FRAME,
            f"Publish {ODOMETRY}; tf_publisher, or lidar_odometry without GNSS, makes the frame",
        ),
    ):
        if above not in _above(frame, parents):
            return Verdict("frames", f"TF does not lead from {above} to {frame}", remedy)
    return Verdict("frames", f"TF leads from {ODOM_FRAME} through {BASE_FRAME} to {scan_frame}")


def odometry(graph: Graph, _: Mapping[str, float]) -> Verdict:
    """Check that odometry comes, and in time."""
    remedy = "Relay /mavros/local_position/odom, or start lidar_odometry; ask PX4 for a higher rate"
    complaint = _stream(graph, ODOMETRY, ODOMETRY_LEAST_HZ, remedy)
    if complaint is not None:
        return Verdict("odometry", *complaint)
    return Verdict("odometry", f"{_rate_hz(graph, ODOMETRY):.0f} poses a second")


def avoidance(graph: Graph, _: Mapping[str, float]) -> Verdict:
    """Check that filters and CEPA answer the scans, each with its stamp."""
    name, scans = "avoidance", _rate_hz(graph, SCAN)
    for topic, nodes in ((PADDED, "lidar_median_filter and lidar_padding"), (SAFE, "cepa")):
        rate = _rate_hz(graph, topic)
        if not scans or rate < ANSWERED_SHARE * scans:
            what = f"{rate:.0f} messages a second on {topic}, from {scans:.0f} scans"
            return Verdict(name, what, f"Look at the words of {nodes}, and at the load of this computer")
    stamps = set(_topic(graph, SCAN).stamps_s)
    answers = _topic(graph, SAFE).stamps_s
    share = np.mean([stamp in stamps for stamp in answers])
    if share < ANSWERED_SHARE:
        what = f"only {100 * share:.0f} % of CEPA's commands carry the stamp of a scan"
        return Verdict(name, what, f"Look who else publishes on {SAFE} or {SCAN}")
    return Verdict(name, f"CEPA answers {_rate_hz(graph, SAFE):.0f} scans a second")


def commands(graph: Graph, _: Mapping[str, float]) -> Verdict:
    """Check the last topic before `mavros_publisher`: one publisher, often enough."""
    publishers = _topic(graph, FINAL).publishers
    if len(publishers) > 1:
        what = f"{' and '.join(publishers)} both publish on {FINAL}"
        return Verdict("commands", what, "End one of them")
    remedy = "Look whether yaw_regulator runs and gets its pose"
    complaint = _stream(graph, FINAL, COMMAND_LEAST_HZ, remedy)
    if complaint is not None:
        return Verdict("commands", *complaint)
    return Verdict("commands", f"{_rate_hz(graph, FINAL):.0f} velocities a second reach mavros_publisher")


def vision(graph: Graph, _: Mapping[str, float]) -> Verdict:
    """Without GNSS, check that the flight controller gets a pose for each scan."""
    if not _topic(graph, VISION).publishers:
        return Verdict("external poses", f"the UAV flies by GNSS, because no node publishes {VISION}")
    rate, scans = _rate_hz(graph, VISION), _rate_hz(graph, SCAN)
    if rate < max(ANSWERED_SHARE * scans, 1.0):
        what = f"{rate:.0f} poses a second on {VISION}, from {scans:.0f} scans"
        return Verdict("external poses", what, "Look at /UAV/vision_state and at lidar_odometry")
    return Verdict("external poses", f"{rate:.0f} poses a second")


CHECKS: tuple[Check, ...] = (
    clock,
    flight_controller,
    failsafe,
    lidar,
    odometry,
    frames,
    avoidance,
    commands,
    vision,
)


def _topic(graph: Graph, name: str) -> Topic:
    return graph.recording.topics.get(name, Topic(name, ""))


def _rate_hz(graph: Graph, name: str) -> float:
    """Return messages per second of the graph's own clock."""
    received_s = np.array(_topic(graph, name).received_s)
    received_s = received_s[np.isfinite(received_s)]
    if len(received_s) < 2 or received_s[-1] <= received_s[0]:
        return 0.0
    return (len(received_s) - 1) / float(received_s[-1] - received_s[0])


def _stream(graph: Graph, name: str, least_hz: float, remedy: str) -> tuple[str, str] | None:
    """Return what is wrong with a topic's rate or stamps, and the remedy."""
    topic, rate = _topic(graph, name), _rate_hz(graph, name)
    if not topic.received_s:
        return f"nothing comes on {name}", remedy
    if rate < least_hz:
        return f"only {rate:.1f} messages a second come on {name}; {least_hz:g} are needed", remedy
    late_s = float(np.nanmedian(np.subtract(topic.received_s, topic.stamps_s)))
    if abs(late_s) > LATE_S:
        how = "old" if late_s > 0.0 else "ahead"
        what = f"messages on {name} are {abs(late_s):.1f} s {how}"
        return what, "Synchronise the clocks of all machines (chrony), and look at the load of this one"
    return None


def _above(frame: str, parents: Mapping[str, str]) -> list[str]:
    """Return the frames above a frame; a circle ends it."""
    found: list[str] = []
    while frame in parents and parents[frame] not in found:
        frame = parents[frame]
        found.append(frame)
    return found
