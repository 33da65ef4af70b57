"""The checks of what a longer flight needs: camera, battery, room on the disk, and time to compute."""

from __future__ import annotations

import math
from dataclasses import dataclass

from doctor.preflight.standing import LATE_S, ODOMETRY
from doctor.preflight.verdict import Verdict
from doctor.snapshot import Graph, Topic

PICTURES, BATTERY = "/camera/image_raw", "/mavros/battery"
RECORDER, INSPECT = "/record", "/inspect"
RECORDED_B_S = 10e6
"""Of a Puck's clouds: 300,000 points a second of 32 bytes; all else is little beside them."""
PHOTOGRAPHS_B = 4e9
"""400 photographs of 20 megapixels, 10 MB each."""
KEPT_FREE_B = 1e9
FREE_SHARE = 0.25
"""Of the cores, while all nodes run: in flight there is more to plan, and a computer gets hot."""


@dataclass(frozen=True)
class Machine:
    """What the companion computer has left.

    folder, free_b: where recordings and photographs go, and the room there. time_s: of the flight. cores,
    free_cores: how many there are, and how many would count for a new program. shutter: what a call of
    camera/shoot said; empty: it opened; None: there is no such service.
    """

    folder: str
    free_b: float
    time_s: float
    cores: int
    free_cores: float
    shutter: str | None = None


def check(graph: Graph, machine: Machine) -> list[Verdict]:
    """Return all verdicts."""
    return [camera(graph, machine), battery(graph), disk(graph, machine), computer(machine)]


def camera(graph: Graph, machine: Machine) -> Verdict:
    """Check that a picture comes when the shutter opens, and that its time is one of the poses'."""
    topic = _topic(graph, PICTURES)
    inspects = _runs(graph, INSPECT)
    if machine.shutter is None and not topic.publishers:
        if not inspects:
            return Verdict("camera", "there is none, and inspect does not run")
        return Verdict("camera", "inspect runs, and nobody offers camera/shoot", "Start your camera's node")
    if machine.shutter:
        return Verdict("camera", f"the shutter says: {machine.shutter}", "Look at the camera and its node")
    if not topic.received_s:
        what = f"no picture came on {PICTURES}"
        return Verdict("camera", what, "Look at the camera's cable, and whether its node takes pictures")
    stamps, poses = topic.stamps_s, _topic(graph, ODOMETRY).stamps_s
    if not poses:
        return Verdict("camera", "a picture came, and no pose to compare its time with", f"See {ODOMETRY}")
    off_s = max(min(poses) - stamps[-1], stamps[-1] - max(poses), 0.0)
    if not off_s <= LATE_S:  # true for NaN: a picture without a stamp
        what = (
            "the picture has no time"
            if math.isnan(off_s)
            else f"its time is {off_s:.1f} s off the poses' times"
        )
        return Verdict(
            "camera", what, "Give pictures the stamp of the shutter, by the same clock as the scans"
        )
    return Verdict("camera", "a picture came, and its time is among the poses' times")


def battery(graph: Graph) -> Verdict:
    """Check that the flight controller tells of its battery."""
    if _topic(graph, BATTERY).received_s:
        return Verdict("battery", f"{BATTERY} tells its charge")
    what = f"nothing comes on {BATTERY}, so nobody lands the UAV in time"
    return Verdict("battery", what, "Calibrate the power module in the flight controller (PX4: BAT1_SOURCE)")


def disk(graph: Graph, machine: Machine) -> Verdict:
    """Check that recordings and photographs of a whole flight have room."""
    needed_b = KEPT_FREE_B
    needed_b += RECORDED_B_S * machine.time_s if _runs(graph, RECORDER) else 0.0
    needed_b += PHOTOGRAPHS_B if _runs(graph, INSPECT) else 0.0
    what = f"{1e-9 * machine.free_b:.1f} GB are free in {machine.folder}"
    if machine.free_b < needed_b:
        what += f", and a flight of {machine.time_s:.0f} s needs {1e-9 * needed_b:.1f} GB"
        return Verdict("disk", what, "Delete old recordings, or give real.launch bags:= on another disk")
    return Verdict("disk", f"{what}, enough for {machine.time_s:.0f} s")


def computer(machine: Machine) -> Verdict:
    """Check that cores are free while all nodes run."""
    what = f"{machine.free_cores:.1f} of {machine.cores} cores are free while all nodes run"
    if machine.free_cores < FREE_SHARE * machine.cores:
        return Verdict(
            "computer", what, "End other programs, take a coarser resolution, or a faster computer"
        )
    return Verdict("computer", what)


def _topic(graph: Graph, name: str) -> Topic:
    return graph.recording.topics.get(name, Topic(name, ""))


def _runs(graph: Graph, node: str) -> bool:
    return any(one.name == node and one.answers for one in graph.nodes)
