"""The row `ros`: flights through all ROS nodes in real time, in the places of the row `spaced`."""

from __future__ import annotations

import argparse
import csv
import json
import tempfile
from pathlib import Path
from typing import Mapping, Sequence

import pandas as pd

from benchmarks.avoidance_rows.rows import JUDGED, SPACED, Row
from benchmarks.shared.trials import run_all
from flights.campaign.campaign import Case
from flights.campaign.places import place_of
from flights.campaign.reading import read_campaign
from flights.campaign.trial import thinned_times
from flights.errors import GraphError
from flights.graph.free_ports import free_ports
from flights.graph.launched_graph import LaunchedGraph
from flights.trials.trial import Trial

FLIGHTS, BRIEF_FLIGHTS, SPEED_M_S = 20, 2, 4.0
ALGORITHMS = (JUDGED,)
PATIENCE_S = 300.0
"""Start, take-off, 120 s of flight and landing take less on a machine that keeps up."""


def fly_all(row: Row, given: argparse.Namespace) -> tuple[pd.DataFrame, Mapping[int, Sequence[float]]]:
    """Fly one after the other; return the flights and their computation times as a campaign has them."""
    campaign = read_campaign(Path(SPACED.campaign))
    number = given.seeds or (BRIEF_FLIGHTS if given.brief or given.smallest else FLIGHTS)
    cases = [
        case
        for case in campaign.cases
        if case.settings["speed_m_s"] == SPEED_M_S
        and case.settings["algorithm"] in ALGORITHMS
        and case.replicate < number
    ]
    trials = [
        Trial(f"{c.settings['algorithm']} {c.replicate}", fly, {"case": c}, cost_s=60.0, alone=True)
        for c in cases
    ]
    flown = run_all(row.campaign, trials, given)
    slow = sum(result["real_time_factor"] < 0.98 for result in flown)
    if slow:
        print(f"In {slow} of {len(flown)} flights the machine was too busy for real time.")
    rows = [
        {"index": i, "replicate": case.replicate, **case.settings, **result, "world": row.name}
        for i, (case, result) in enumerate(zip(cases, flown))
    ]
    return pd.DataFrame(rows), {i: result["computation_ms"] for i, result in enumerate(flown)}


def fly(case: Case) -> dict:
    """Fly a case of a campaign in the graph; return the columns of its row, and the real-time factor.

    Raises:
        GraphError: the graph did not start or end, or the UAV did not fly.
    """
    settings, place = case.settings, place_of(case.settings, case.place_seed)
    ports = (f"{name}:={port}" for name, port in zip(("offboard_port", "gcs_port"), free_ports(2)))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        graph = LaunchedGraph(
            folder,
            *("flights", "fly_to_goal.launch", "headless:=true", "lockstep:=false", *ports),
            f"world:={place.world_file(folder)}",
            f"goal:={place.distance_m:g} 0 {settings['height_m']:g}",
            *(f"{name}:={settings[name]}" for name in ("algorithm", "lidar")),
            f"speed:={settings['speed_m_s']:g}",
            f"seed:={case.noise_seed % 2**31}",
            f"results:={folder / 'results'}",
            events=(),
        )
        try:
            graph.wait_for_end(PATIENCE_S)
            found = sorted(folder.glob("results/fly_to_goal/*/result.json"))
            if not found:
                raise GraphError(f"The flight left no result; it said: {graph.said()}")
            return outcome_of(found[-1], place.distance_m / settings["speed_m_s"])
        finally:
            graph.close()


def outcome_of(path: Path, straight_s: float) -> dict:
    """Return the columns of a run's row. straight_s: time of the straight way at full speed."""
    result = json.loads(path.read_text(encoding="utf-8"))
    if "flying" not in result["times_s"]:
        raise GraphError(result["failure"])
    with open(path.parent / "decisions.csv", encoding="utf-8", newline="") as stream:
        times_ms = [
            float(row["computation_ms"])
            for row in csv.DictReader(stream)
            if float(row["t_s"]) >= result["times_s"]["flying"]
        ]
    reached, collision = result["reached_goal"], result["collision"]
    return {
        "reached": reached and not collision,
        "collision": collision,
        "stuck": not (reached or collision),
        "flight_time_s": result["flight_time_s"],
        "time_over_straight": result["flight_time_s"] / straight_s if reached else None,
        "path_length_m": result["path_length_m"],
        "min_clearance_m": result["min_clearance_m"],
        "emergencies": result["emergencies"],
        "computation_ms": thinned_times(times_ms),
        "real_time_factor": result["real_time_factor"] or 0.0,
    }
