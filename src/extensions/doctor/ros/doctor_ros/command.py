"""Finds what is wrong with an installation, a running graph (--live) or a bag (--bag FILE).

Each diagnosis is one line: severity, place, fault, remedy. Exit code 0: no error; 1: at least one error; 2:
the examination was not possible.
"""

from __future__ import annotations

import argparse
import importlib
import math
import sys
from pathlib import Path
from typing import Sequence

from doctor import diagnosis
from doctor.diagnosis import Diagnosis
from flights.errors import FlightsError

Examined = tuple[Sequence[Diagnosis], str]
"""The diagnoses, and what was examined."""


def main() -> int:
    """Examine and print the diagnoses; return the exit code."""
    arguments = _arguments()
    try:
        if arguments.bag:
            diagnoses, examined = _bag(arguments.bag)
        elif arguments.live:
            diagnoses, examined = _live(arguments.listen)
        else:
            diagnoses, examined = _installation()
    except FlightsError as error:
        print(f"doctor: {error}", file=sys.stderr)
        return diagnosis.NOT_EXAMINED
    print((diagnosis.as_json if arguments.json else diagnosis.as_text)(diagnoses, examined))
    return diagnosis.exit_code(diagnoses)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="rosrun doctor doctor", description=(__doc__ or "").splitlines()[0])
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--live", action="store_true", help="examine the running graph of ROS_MASTER_URI")
    what.add_argument("--bag", type=Path, metavar="FILE", help="examine a recorded bag")
    parser.add_argument(
        "--listen",
        type=_seconds,
        default=5.0,
        metavar="SECONDS",
        help="seconds to listen, with --live (default 5)",
    )
    parser.add_argument("--json", action="store_true", help="print the findings as JSON")
    return parser.parse_args()


def _seconds(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0.5 <= value <= 3600.0:
        raise argparse.ArgumentTypeError(f"give seconds, from 0.5 to 3600, not {text!r}")
    return value


def _installation() -> Examined:
    from doctor import installation, machine
    from doctor.upstream_messages import UPSTREAM_MD5SUMS

    root = next(
        (folder for folder in Path(__file__).resolve().parents if (folder / "bringup.sh").exists()), None
    )
    if root is None:
        raise FlightsError("This package does not lie in its workspace, so there is nothing to compare with.")
    found = {name: md5sum for name in UPSTREAM_MD5SUMS for md5sum in _md5sum(name)}
    return installation.check(machine.look_at(root, UPSTREAM_MD5SUMS, found)), f"the installation in {root}"


def _md5sum(name: str) -> list[str]:
    """Return the md5sum of a message or service type as Python finds it, or nothing."""
    package, kind = name.split("/")
    for module in ("msg", "srv"):
        try:
            return [getattr(importlib.import_module(f"{package}.{module}"), kind)._md5sum]
        except (ImportError, AttributeError):
            continue
    return []


def _live(listen_s: float) -> Examined:
    import rosgraph

    from doctor import graph, installation, machine
    from doctor_ros import live

    seen = live.look(listen_s)
    topics, frames = len(seen.recording.topics), len({edge.child for edge in seen.recording.transforms})
    examined = f"{len(seen.nodes)} nodes, {topics} topics, {frames} transforms for {seen.wall_s:.0f} s"
    here = machine.Machine("", ros={"ROS_MASTER_URI": rosgraph.get_master_uri()}, masters=machine.masters())
    return [*graph.check(seen), *installation.other_masters(here)], examined


def _bag(path: Path) -> Examined:
    from doctor import bag
    from doctor_ros.bag import read

    recording, parameters = read(path)
    count = sum(len(topic.received_s) for topic in recording.topics.values())
    return bag.check(recording, parameters), f"{count} messages on {len(recording.topics)} topics of {path}"
