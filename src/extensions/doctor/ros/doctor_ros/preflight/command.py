"""Checks the graph of a real UAV on the bench, propellers off, before its first take-off.

Without an option it checks all links of the chain while the UAV stands. Then do by hand what --board,
--turn and --carry say. Each check prints one sentence.
Exit code 0: all are passed; 1: one has failed; 2: none was possible.
"""

from __future__ import annotations

import argparse
import os
import shutil
import sys
from pathlib import Path
from typing import Sequence

import rosgraph
import rospy
from mavros_msgs.srv import ParamGet

from doctor.preflight import by_hand, carried, standing
from doctor.preflight.verdict import NOT_CHECKED, Verdict, exit_code
from doctor_ros import live
from doctor_ros.preflight.hearing import answers, odometry, views
from doctor_ros.preflight.shutter import Shutter
from flights.errors import FlightsError
from flights.launch_arguments.machine_pace import own_free_cores
from node_tools.services import ServiceCall

PARAMETER_PATIENCE_S = 3.0
NEAR_PARAMETER, NEAR_M = "/cepa/r_lb", 0.5
STANDING_S, BY_HAND_S = 5.0, 30.0
OPENED_AFTER_S = 1.0
"""The shutter, after the listening has begun."""
FLIGHT_S = 600.0


def main() -> int:
    """Check, print the verdicts, and return the exit code."""
    given = _arguments()
    try:
        verdicts = _verdicts(given)
    except FlightsError as error:
        print(f"preflight: {error}", file=sys.stderr)
        return NOT_CHECKED
    for verdict in verdicts:
        print(verdict, flush=True)
    return exit_code(verdicts)


def _verdicts(given: argparse.Namespace) -> Sequence[Verdict]:
    if given.board:
        near_m = float(rosgraph.Master("/preflight").getParam(NEAR_PARAMETER)) if _has_near() else NEAR_M
        print(
            f"Hold a board nearer than {near_m:g} m to the lidar, from one side after another ...", flush=True
        )
        return [by_hand.board(answers(given.listen or BY_HAND_S), near_m)]
    if given.turn:
        print("Turn the UAV by hand, slowly, by a right angle or more, and hold it still ...", flush=True)
        return [by_hand.turn(*views(given.listen or BY_HAND_S))]
    if given.carry:
        print(
            "Carry the UAV by hand at 1 m/s or faster, ahead and then sideways, with its front "
            "at a right angle to the x axis of odom ...",
            flush=True,
        )
        return [by_hand.carry(odometry(given.listen or BY_HAND_S))]
    shutter = Shutter()
    shutter.open_after(OPENED_AFTER_S)
    graph = live.look(given.listen or STANDING_S)
    standing_verdicts = standing.check(graph, _flight_controllers_parameters())
    return [*standing_verdicts, *carried.check(graph, _machine(shutter.said))]


def _machine(shutter: str | None) -> carried.Machine:
    asked = rospy.get_param("/preflight", {})
    folder = Path(str(asked.get("folder", "."))).expanduser()
    there = next(one for one in (folder, *folder.resolve().parents) if one.is_dir())
    return carried.Machine(
        folder=str(folder),
        free_b=float(shutil.disk_usage(there).free),
        time_s=float(asked.get("time", FLIGHT_S)),
        cores=len(os.sched_getaffinity(0)),
        free_cores=own_free_cores(),
        shutter=shutter,
    )


def _has_near() -> bool:
    try:
        return bool(rosgraph.Master("/preflight").hasParam(NEAR_PARAMETER))
    except OSError:
        return False  # no master; the listener says so


def _flight_controllers_parameters() -> dict[str, float]:
    """Return the one of `standing.STREAM_TIMEOUTS` that this flight controller has; empty: none is known."""
    get = ServiceCall("/mavros/param/get", ParamGet, PARAMETER_PATIENCE_S, wait_s=PARAMETER_PATIENCE_S)
    for name in standing.STREAM_TIMEOUTS:
        try:
            reply = get(name)
        except (rospy.ROSException, rospy.ServiceException):
            continue
        if reply.success:
            return {name: reply.value.real or float(reply.value.integer)}
    return {}


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="rosrun doctor preflight",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    what = parser.add_mutually_exclusive_group()
    what.add_argument(
        "--board", action="store_true", help="hold a board before the lidar: does CEPA give way?"
    )
    what.add_argument("--turn", action="store_true", help="turn the UAV by hand: is the lidar mirrored?")
    what.add_argument(
        "--carry", action="store_true", help="carry the UAV by hand: does odometry's velocity fit its places?"
    )
    parser.add_argument(
        "--listen", type=float, metavar="SECONDS", help="how long to listen (default 5; by hand 30)"
    )
    given = parser.parse_args()
    if given.listen is not None and not 0.5 <= given.listen <= 600.0:
        parser.error(f"--listen: give seconds, from 0.5 to 600, not {given.listen:g}")
    return given
