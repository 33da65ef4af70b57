"""The summary of a run: the content of its result.json, and its headline for a terminal."""

from __future__ import annotations

import hashlib
from pathlib import Path

from flights.flight.description import RunDescription
from flights.flight.judging.wall_metrics import WallMetrics
from flights.results import run_folder
from flights.results.sources import commit
from flights.worlds.scenario import ALGORITHMS

COMMAND_TIMEOUT_S = 0.5
"""Default `command_timeout` of mavros_publisher: an older command is none, and the UAV hovers."""
KEPT_SHARE = 0.9
"""Of the real-time factor that was asked for. A machine that has time keeps 0.99."""


def summary_of(
    description: RunDescription, metrics: dict, wall: WallMetrics, min_clearance_m: float | None
) -> dict:
    """Return the content of result.json."""
    scenario = description.scenario
    return {
        "experiment": description.experiment,
        "scenario": scenario.name,
        "algorithm": description.algorithm,
        "lidar": description.lidar,
        "seed": description.seed,
        **metrics,
        "min_clearance_m": min_clearance_m,
        **vars(wall),
        "world": scenario.world_path,
        "start": scenario.start_xyz_yaw,
        "goal": scenario.goal_xyz_m,
        "mission": scenario.mission_path,
        "parameters": description.parameters,
        "versions": run_folder.versions(),
        "machine": run_folder.machine(),
        "commit": commit(Path(__file__).parent),
    }


def steering(algorithm: str) -> str:
    """Return the name of the avoidance in words: CEPA, or a user's node."""
    return f"{algorithm} CEPA" if algorithm in ALGORITHMS else algorithm


def headline(content: dict) -> str:
    """Return a run's metrics in a few lines for a terminal."""
    computation = content["cepa_computation_ms"] or {}
    latency = content["latency_ms"] or {}
    rows = {
        "scenario": "{scenario}, {steering}, {lidar}, seed {seed}".format(
            steering=steering(content["algorithm"]), **content
        ),
        "mission ended" if content.get("mission") else "reached goal": _arrival(content),
        "collision": "yes" if content["collision"] else "no",
        "landed": "yes" if content.get("landed") else "no",
        "landing error": _in_unit("m", 2, content.get("landing_error_m")),
        "flight time": _in_unit("s", 1, content["flight_time_s"]),
        "path length": _in_unit("m", 1, content["path_length_m"]),
        "least clearance": _in_unit("m", 2, content["min_clearance_m"]),
        "CEPA, mean, p99": _in_unit("ms", 3, computation.get("mean"), computation.get("p99")),
        "latency, median, p99": _in_unit("ms", 1, latency.get("median"), latency.get("p99")),
        "real-time factor": _in_unit("", 3, content["real_time_factor"]),
        **_pace(content),
    }
    if content["failure"]:
        rows["failure"] = content["failure"]
    remarks = content.get("world_remarks") or ()
    if remarks:
        rows["world"] = remarks[0] + (f" And {len(remarks) - 1} more: world_remarks" if remarks[1:] else "")
    return "\n".join(f"  {name:<22} {value}" for name, value in rows.items())


def _pace(content: dict) -> dict[str, str]:
    """Return a row that judges latency and real-time factor; none if both are as they should be."""
    parameters = content.get("parameters") or {}
    simulator, publisher = (parameters.get(node) or {} for node in ("gazebo", "mavros_publisher"))
    late_ms = 1e3 * float(publisher.get("command_timeout", COMMAND_TIMEOUT_S))
    asked, kept = float(simulator.get("real_time_factor", 0.0)), content["real_time_factor"]
    is_slow = kept is not None and kept < KEPT_SHARE * asked
    is_late = ((content["latency_ms"] or {}).get("p99") or 0.0) > late_ms
    if not (is_slow or is_late):
        return {}
    if simulator.get("lockstep"):
        return {"pace": "slow, which does not matter: in lockstep the simulator waited for each answer"}
    faults = [f"1 % of the answers came after {late_ms:g} ms, when the UAV already hovers"] * is_late
    faults += [f"the machine did not keep the factor of {asked:g}"] * is_slow
    return {"pace": f"bad: {', and '.join(faults)}. Add lockstep:=true, or end other programs"}


def _arrival(content: dict) -> str:
    """Return whether the goal was reached, and how far from it the UAV was before it landed."""
    off_m = content.get("goal_error_m")
    return ("yes" if content["reached_goal"] else "no") + (
        "" if off_m is None else f", {off_m:.2f} m from the goal"
    )


def truth_digest(folder: Path, content: dict) -> str | None:
    """Return the SHA-256 of truth.csv if the run repeats bit for bit, to compare it with another machine's.

    folder: of the run. content: of its result.json. None: it was not flown in lockstep, an answer came too
    late, or there is no such file.
    """
    truth = folder / "truth.csv"
    lockstep = (content.get("parameters") or {}).get("gazebo", {}).get("lockstep")
    if not lockstep or content.get("lockstep_misses") or not truth.is_file():
        return None
    return hashlib.sha256(truth.read_bytes()).hexdigest()


def _in_unit(unit: str, digits: int, *values: float | None) -> str:
    written = ["-" if value is None else f"{value:.{digits}f} {unit}".strip() for value in values]
    return ", ".join(written)
