"""The metrics of Experiment 2 that decide on the thesis's claims (`report/claims.yaml`)."""

from __future__ import annotations

import math
from typing import Mapping, Sequence

from master_thesis.experiment_2.variations import Flown, variations_metrics
from master_thesis.report.claims import Value, threshold_of
from master_thesis.report.content import listed

Sets = Mapping[tuple, Sequence[Flown]]
"""Flights by (scenario, algorithm)."""


def claim_metrics(proposals: Mapping[str, dict], sets: Sets) -> dict[str, Value]:
    """Return the metrics that can be had. proposals: by scenario, of each placement as it is."""
    metrics: dict[str, Value] = {}
    if "columns" in proposals:
        metrics.update(_sweep(proposals["columns"]["sweep"]))
    for scenario, short in (("wall_one_column", "one_column"), ("wall_three_columns", "three_columns")):
        if scenario in proposals:
            metrics[f"{short}_arrows_apart_deg"] = _apart_deg(proposals[scenario]["proposals"])
        flights = sets.get((scenario, "original"), ())
        if flights:
            metrics.update({f"{short}_{name}": value for name, value in _original(flights).items()})
    improved = [flight for (_, name), flights in sets.items() if name == "improved" for flight in flights]
    return {**metrics, **_improved(improved)} if improved else metrics


def _sweep(sweep: Sequence[dict]) -> dict[str, Value]:
    by_k = sorted(sweep, key=lambda each: each["k_filter"])
    low, high = by_k[0], by_k[-1]
    limit = threshold_of("experiment_2", "blocked_growth") * high["intruding_share"]
    begin = (each["k_filter"] for each in reversed(by_k) if each["intruding_share"] > limit)
    return {
        "low_k": low["k_filter"],
        "low_k_blocked_percent": 100 * low["intruding_share"],
        "high_k": high["k_filter"],
        "high_k_blocked_percent": 100 * high["intruding_share"],
        "blocked_growth": low["intruding_share"] / high["intruding_share"],
        "effects_begin_at_k": next(begin, None),
    }


def _apart_deg(proposed: dict) -> float:
    return angle_deg(proposed["original_xy"], proposed["improved_xy"])


def _original(flights: Sequence[Flown]) -> dict[str, Value]:
    touched = sum(flight.metrics["collision"] for flight in flights)
    return {
        "flights": len(flights),
        "touched": touched,
        "touched_share": touched / len(flights),
        "refused": sum(flight.proposal_refused for flight in flights),
    }


def _improved(flights: Sequence[Flown]) -> dict[str, Value]:
    values = variations_metrics(flights)
    failed = {f.scenario for f in flights if f.metrics["collision"] or not f.metrics["left"]}
    return {
        "improved_flights": values["flights"],
        "improved_touched": values["touched"],
        "improved_left": values["left"],
        "improved_stuck": values["flights"] - values["left"],
        "improved_clearance_m": max(values["min_clearance_m"], 0.0),
        "improved_fails_in": listed([name.replace("_", " ") for name in sorted(failed)]),
    }


def angle_deg(first_xy: Sequence[float], second_xy: Sequence[float]) -> float:
    """Return the angle between two velocities, 0 to 180 degrees."""
    turn = math.atan2(first_xy[1], first_xy[0]) - math.atan2(second_xy[1], second_xy[0])
    return abs(math.degrees(math.remainder(turn, 2.0 * math.pi)))
