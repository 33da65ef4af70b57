"""Measurements 1 and 2 on the page: tables 8.3 and 8.4."""

from __future__ import annotations

from typing import Mapping

from master_thesis.report import thesis
from master_thesis.report.content import Finding, Section, Table, counted, number, resting_on
from master_thesis.report.pieces import measurements
from master_thesis.report.size import Size
from master_thesis.trials.store import Store
from master_thesis.trials.trial import Row

ALIKE = 2.0
"""Times within this factor agree: the thesis rounds, and takes its own "with a grain of salt"."""


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
        findings=resting_on(build_findings(done.result["seconds"]), size.builds, "round") if done else [],
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


def build_findings(ours: Mapping[str, float]) -> list[Finding]:
    """Return the thesis's statements beside our times (s, by what was altered)."""
    times = {"one file": ours["one file"], "many files": ours["many files"]}
    theirs = {name: thesis.TABLE_8_3_S[f"full, {name}"] or 0.0 for name in times}
    return [
        Finding(
            "“Compiling takes 5-15s on average.”",
            "9.2.3, table 8.3",
            f"One file: {times['one file']:.1f} s; many: {times['many files']:.1f} s.",
            _alike(times, theirs),
            _how_they_differ(times, theirs, "At the load that stands in the note above"),
        ),
        Finding(
            "More altered files take longer.",
            "table 8.3",
            f"{ours['one file']:.1f}, {ours['many files']:.1f} and, from nothing, "
            f"{ours['from nothing']:.1f} s.",
            ours["one file"] < ours["many files"] < ours["from nothing"],
            ""
            if ours["one file"] < ours["many files"] < ours["from nothing"]
            else "Most of a build here is CMake's look at the packages, whatever was altered.",
        ),
    ]


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
        findings=resting_on(launch_findings(numbers), size.launches, "launch of each"),
        parameters=f"each launched {size.launches} times" if size.launches > 1 else "each launched once",
    )


def _launch_table(launches: Mapping[str, Row]) -> Table:
    columns = [what for what in measurements.LAUNCHES if what in launches]
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


def launch_findings(ours: Mapping[str, dict]) -> list[Finding]:
    """Return the thesis's statements beside our times (startup_s, shutdown_s by what was launched)."""
    both = [what for what in thesis.TABLE_8_4 if what in ours]
    found = []
    if both:
        theirs = {what: sum(thesis.TABLE_8_4[what]) for what in both}
        times = {what: ours[what]["startup_s"] + ours[what]["shutdown_s"] for what in both}
        found.append(
            Finding(
                "To stop and start again takes "
                + ", ".join(f"{seconds:g} s ({what})" for what, seconds in theirs.items())
                + ".",
                "table 8.4, 9.2.3",
                "Ours: " + ", ".join(f"{seconds:.1f} s" for seconds in times.values()) + ".",
                _alike(times, theirs),
                _how_they_differ(times, theirs, "Another simulator on another machine"),
            )
        )
    if "Gazebo with PX4" in ours:
        times = ours["Gazebo with PX4"]
        agrees = times["shutdown_s"] > times["startup_s"]
        found.append(
            Finding(
                "“Gazebo and PX4 use much more time to close properly than to launch properly.”",
                "8.3",
                f"Start {times['startup_s']:.1f} s, end {times['shutdown_s']:.1f} s.",
                agrees,
                "Neither Gazebo nor PX4 runs here: our simulator and the flight controller's "
                "stand-in are one process, which ends at the first signal.",
            )
        )
    if {"Gazebo", "Gazebo with Rviz"} <= set(ours):
        alone, with_rviz = (ours[what]["startup_s"] for what in ("Gazebo", "Gazebo with Rviz"))
        found.append(
            Finding(
                "RViz is what makes the start slow.",
                "table 8.4",
                f"{alone:.1f} s without, {with_rviz:.1f} s with RViz.",
                with_rviz > alone,
                "RViz starts beside the simulator, and the slower of both "
                "counts; the rest is the machine's load.",
            )
        )
    return found


def _alike(ours: Mapping[str, float], theirs: Mapping[str, float]) -> bool:
    return all(1.0 / ALIKE <= ours[name] / theirs[name] <= ALIKE for name in ours)


def _how_they_differ(ours: Mapping[str, float], theirs: Mapping[str, float], why: str) -> str:
    """Return the times that differ, with their ratios; empty: none."""
    words = []
    for name in ours:
        ratio = ours[name] / theirs[name]
        if ratio > ALIKE:
            words.append(f"{name} {ratio:.1f} times as long")
        elif ratio < 1.0 / ALIKE:
            words.append(f"{name} {1.0 / ratio:.1f} times as fast")
    return f"{why}: {', '.join(words)}." if words else ""


def _done(size: Size, store: Store) -> dict[str, Row]:
    found = {piece.name: store.get(piece) for piece in measurements.pieces(size)}
    return {name: done for name, done in found.items() if done is not None}
