"""Measurements 1 and 2 on the page: tables 8.3 and 8.4."""

from __future__ import annotations

from typing import Mapping

from flights.trials.store import Store
from flights.trials.trial import Row
from master_thesis.measurements.claim_metrics import build_metrics, launch_metrics
from master_thesis.measurements.pieces import LAUNCHES, pieces
from master_thesis.report import thesis
from master_thesis.report.claims import judged
from master_thesis.report.content import Section, Table, counted, number
from master_thesis.report.size import Size


def build_section(size: Size, store: Store) -> Section:
    """Return the section of table 8.3 from finished pieces."""
    done = next((d for name, d in _done(size, store).items() if name.startswith("measurement_1")), None)
    blocks = [_build_table(done)] if done else []
    return Section(
        key="measurement_1",
        title="Measurement 1: compilation time",
        reference="8.3, table 8.3; discussed in 9.2.3",
        method=(
            "A copy of this workspace is built with catkin_make, from nothing and again after files "
            "were altered from which code is generated (messages, dynamic_reconfigure). The time is "
            "wall time from the command to its end, the median of some rounds."
        ),
        blocks=blocks,
        findings=judged("measurement_1", build_metrics(done.result["seconds"], size.builds)) if done else [],
        parameters=counted(size.builds, "round"),
    )


def _build_table(done: Row) -> Table:
    ours = done.result["seconds"]
    theirs = thesis.TABLE_8_3_S
    rows = [
        (
            "thesis",
            *(f"~ {theirs[key]:g}" for key in ("full, one file", "full, many files")),
            "scales with files",
            "-",
            "-",
        ),
        (
            "ours",
            *(number(ours[key], 1) for key in ("one file", "many files", "single package")),
            number(ours["from nothing"], 1),
            number(ours["nothing altered"], 1),
        ),
    ]
    return Table(
        "Table 8.3: compilation time, s",
        ("", "full, one file", "full, many files", "single package", "full, from nothing", "nothing altered"),
        rows,
        emphasis=(1,),
        theirs=(0,),
        note=f"Many files: all {ours['files altered']:.0f} from which code is generated. Load average at "
        f"the start: {done.load:.1f}. A node, a library or a launch file that is altered needs "
        "no build at all: Python is used where it lies.",
    )


def launch_section(size: Size, store: Store) -> Section:
    """Return the section of table 8.4 from finished pieces."""
    done = _done(size, store)
    launches = {d.result["what"]: d for name, d in done.items() if name.startswith("measurement_2")}
    numbers = {what: each.result for what, each in launches.items()}
    return Section(
        key="measurement_2",
        title="Measurement 2: launch and shutdown time",
        reference="8.3, table 8.4; discussed in 9.2.3",
        method=(
            "roslaunch starts the collection of nodes; the clock runs until all of them are good to go: "
            "the first scan, the flight controller's link to MAVROS, RViz's displays listening. Then "
            "Ctrl-C is pressed and the clock runs until the last process is gone."
        ),
        blocks=[_launch_table(launches)] if launches else [],
        findings=judged("measurement_2", launch_metrics(numbers, size.launches)),
        parameters=f"each launched {size.launches} times" if size.launches > 1 else "each launched once",
    )


def _launch_table(launches: Mapping[str, Row]) -> Table:
    columns = [what for what in LAUNCHES if what in launches]
    rows = []
    for label, key in (("startup", "startup_s"), ("shutdown", "shutdown_s")):
        theirs = (thesis.TABLE_8_4.get(what) for what in columns)
        rows.append((f"thesis: {label}", *(number(t and getattr(t, key), 0) for t in theirs)))
        rows.append((f"ours: {label}", *(number(launches[what].result[key], 1) for what in columns)))
    load = max(each.load for each in launches.values())
    return Table(
        "Table 8.4: time to launch and to shut down, s",
        ("", *columns),
        rows,
        emphasis=(1, 3),
        theirs=(0, 2),
        note="“Gazebo” is this workspace's simulator, which holds the flight controller's stand-in in "
        "its own process. RViz draws by software on a display without a screen. Experiment 1: every "
        "node of the thesis's figure 5.2, until CEPA's first answer. Load average at the start: "
        f"{load:.1f} at most.",
    )


def _done(size: Size, store: Store) -> dict[str, Row]:
    found = {piece.name: store.get(piece) for piece in pieces(size)}
    return {name: done for name, done in found.items() if done is not None}
