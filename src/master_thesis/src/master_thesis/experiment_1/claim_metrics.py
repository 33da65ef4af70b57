"""The metrics of Experiment 1's flights that decide on the thesis's claims (`report/claims.yaml`)."""

from __future__ import annotations

from typing import Mapping, Sequence

import numpy as np

from master_thesis.report import thesis
from master_thesis.report.claims import Value, threshold_of
from master_thesis.report.content import counted, listed

Flights = Mapping[tuple, Sequence[dict]]
"""Numbers of the flights by (scenario, algorithm)."""


def claim_metrics(names: Sequence[str], flights: Flights) -> dict[str, Value]:
    """Return the metrics of the flights in these scenarios that can be had from them."""
    if not names:
        return {}
    pairs = [(name, algorithm) for name in names for algorithm in ("improved", "original")]
    metrics = {
        "flights": min(len(flights[pair]) for pair in pairs),
        **_reduction(names, flights),
        "original_worst_p99_ms": max(f["computation_p99_ms"] for n in names for f in flights[n, "original"]),
        **_arrivals([flight for name in names for flight in flights[name, "improved"]]),
    }
    if len(names) > 1:
        metrics.update(_scenarios_compared(names, flights))
    if "empty" in names:
        for algorithm in ("improved", "original"):
            directions = [flight["directions"] for flight in flights["empty", algorithm]]
            metrics[f"{algorithm}_directions_in_empty"] = float(np.mean(directions))
    if set(names) == set(thesis.SCENARIO_FIGURES):
        metrics.update(_order(names, flights))
    return metrics


def _reduction(names: Sequence[str], flights: Flights) -> dict[str, Value]:
    ratios = {name: ratio(flights, name) for name in names}
    huge = threshold_of("experiment_1", "least_ratio")
    least, greatest = min(ratios.values()), max(ratios.values())
    return {
        "least_ratio": least,
        "ratios": " to ".join(dict.fromkeys(f"{end:.0f}" for end in (least, greatest))),
        "slow": listed([name for name, value in ratios.items() if value < huge]),
    }


def _scenarios_compared(names: Sequence[str], flights: Flights) -> dict[str, Value]:
    original, improved = (
        {name: _mean(flights, name, algorithm) for name in names} for algorithm in ("original", "improved")
    )
    theirs = [thesis.TABLE_8_1_MS["original"][name] for name in names]
    metrics: dict[str, Value] = {
        "original_slowest_over_fastest": max(original.values()) / min(original.values()),
        "their_slowest_over_fastest": max(theirs) / min(theirs),
        "original_fastest": min(original, key=original.__getitem__),
        "original_fastest_ms": min(original.values()),
        "improved_fastest": min(improved, key=improved.__getitem__),
        "improved_times": ", ".join(f"{name} {value:.3f} ms" for name, value in improved.items()),
    }
    if "empty" in names:
        metrics["original_empty_ms"] = original["empty"]
        metrics["original_empty_above_fastest_ms"] = original["empty"] - min(original.values())
        metrics["improved_empty_above_fastest_ms"] = improved["empty"] - min(improved.values())
    return metrics


def _order(names: Sequence[str], flights: Flights) -> dict[str, Value]:
    ours = sorted(names, key=lambda name: _mean(flights, name, "improved"))
    theirs = sorted(names, key=lambda name: thesis.TABLE_8_1_MS["improved"][name])
    return {
        "our_order": " < ".join(ours),
        "their_order": " < ".join(theirs),
        "scenarios_out_of_order": sum(our != their for our, their in zip(ours, theirs)),
    }


def _arrivals(improved: Sequence[dict]) -> dict[str, Value]:
    collisions, arrived = (sum(flight[what] for flight in improved) for what in ("collision", "reached_goal"))
    return {
        "improved_collisions": collisions,
        "improved_collisions_counted": counted(collisions, "collision"),
        "improved_flights_counted": counted(len(improved), "flight"),
        "improved_arrived": arrived,
        "improved_not_arrived": len(improved) - arrived,
    }


def ratio(flights: Flights, name: str) -> float:
    """Return the ratio of the original's time to the improved's."""
    return _mean(flights, name, "original") / _mean(flights, name, "improved")


def times_ms(flights: Flights, name: str, algorithm: str) -> list[float]:
    """Return the flights' mean computation times."""
    return [flight["computation_ms"] for flight in flights[name, algorithm]]


def _mean(flights: Flights, name: str, algorithm: str) -> float:
    return float(np.mean(times_ms(flights, name, algorithm)))
