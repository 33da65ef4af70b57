"""Numbers of a row's flights with their 95 % bounds, and whether they reach the row's goals."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Iterator, Mapping, Sequence

import numpy as np
import pandas as pd
import scipy  # loads stats at its first use; that takes half a second

from benchmarks.avoidance_rows.rows import COMPARED, JUDGED, Goal, Row
from benchmarks.shared.results import table

HEADER = (
    "place",
    "m/s",
    "algorithm",
    "flights",
    "contacts",
    "unavoidable",
    "95 %",
    "reached",
    "95 %",
    "stuck",
    "time/straight",
    "clearance [m]",
    "p50, p99 [ms]",
)


def metrics(flights: pd.DataFrame, computation_ms: Mapping[int, Sequence[float]]) -> dict:
    """Return the metrics of some flights; computation_ms: a sample of each flight's times, by its index."""
    number, contacts, reached = len(flights), int(flights["collision"].sum()), int(flights["reached"].sum())
    arrived = flights[flights["reached"].astype(bool)]
    times_ms = np.concatenate([np.empty(0), *(computation_ms.get(i, ()) for i in flights["index"])])
    percentiles = np.percentile(times_ms, (50, 99)) if len(times_ms) else ()
    return {
        "flights": number,
        "contacts": contacts,
        "contacts_95": share_interval(contacts, number),
        "unavoidable": int(flights["unavoidable"].sum()) if "unavoidable" in flights else 0,
        "reached": reached / number,
        "reached_95": share_interval(reached, number),
        "stuck": flights["stuck"].mean(),
        "time_ratio": arrived["time_over_straight"].mean() if reached else None,
        "clearance_m": {
            "least": flights["min_clearance_m"].min(),
            "median": flights["min_clearance_m"].median(),
        },
        "computation_ms": dict(zip(("p50", "p99"), percentiles)) or None,
    }


def share_interval(events: int, number: int) -> tuple[float, float]:
    """Return the exact 95 % interval (Clopper and Pearson 1934) of a share."""
    interval = scipy.stats.binomtest(events, number).proportion_ci(0.95, method="exact")
    return float(interval.low), float(interval.high)


def sets(row: Row, trials: pd.DataFrame) -> dict[tuple[str, float, str], pd.DataFrame]:
    """Return the flights by place, speed in m/s and algorithm."""
    keys = [row.places(trials), "speed_m_s", "algorithm"]
    return dict(iter(trials.groupby(keys, sort=False)))


def key(place: str, speed_m_s: float, algorithm: str) -> str:
    """Return the key of some flights in benchmarks.json."""
    return f"avoidance.{place}.{speed_m_s:g}_m_s.{algorithm}"


def as_table(found: Mapping[tuple[str, float, str], Mapping]) -> str:
    """Return the metrics as a table; time: mean of the flights that arrived."""
    return table(
        HEADER, [(place, f"{speed:g}", name, *_cells(m)) for (place, speed, name), m in found.items()]
    )


def _cells(values: Mapping) -> tuple[str, ...]:
    ratio, times = values["time_ratio"], values["computation_ms"]
    return (
        f"{values['flights']}",
        f"{values['contacts']}",
        f"{values['unavoidable']}",
        "{:.0%} to {:.0%}".format(*values["contacts_95"]),
        f"{values['reached']:.0%}",
        "{:.0%} to {:.0%}".format(*values["reached_95"]),
        f"{values['stuck']:.0%}",
        f"{ratio:.2f}" if ratio else "-",
        "{least:.3f}, {median:.2f}".format(**values["clearance_m"]),
        "{p50:.2f}, {p99:.2f}".format(**times) if times else "-",
    )


@dataclass(frozen=True)
class Verdict:
    """Whether one goal of a row, or of one of its conditions, is met at a speed."""

    name: str
    speed_m_s: float
    goal: str
    found: str
    met: bool


def verdicts(row: Row, trials: pd.DataFrame, computation_ms: Mapping[int, Sequence[float]]) -> list[Verdict]:
    """Judge the flights of the algorithm that has goals.

    All places of a row count together, but each of the worse conditions alone.
    """
    found: list[Verdict] = []
    judged = row.places(trials) if row.worse else pd.Series(row.name, trials.index)
    for (name, speed), flights in trials.groupby([judged, "speed_m_s"], sort=False):
        goal, mine = row.goal(speed), flights[flights["algorithm"] == JUDGED]
        if goal is None or not len(mine):
            continue
        checks = [*_checks(goal, row.p99_ms, metrics(mine, computation_ms))]
        if goal.no_slower:
            ratio = time_over_compared(row, flights)
            no_slower = ratio is not None and ratio <= 1.0
            checks.append((f"time / {COMPARED}'s at most 1", ratio, "{:.2f}", no_slower))
        found += [
            Verdict(name, speed, what, "-" if value is None else form.format(value), met)
            for what, value, form, met in checks
        ]
    return found


def _checks(goal: Goal, p99_ms: float, values: Mapping) -> Iterator[tuple[str, float | None, str, bool]]:
    """Yield what is to be reached, what was found, how to write it, and whether it is enough."""
    contacts, reached = values["contacts"], values["reached"]
    unavoidable = values["unavoidable"]
    named = f"no contact but {unavoidable} that no command could avoid" if unavoidable else "no contact"
    yield named, contacts - unavoidable, "{:d}", contacts == unavoidable
    if goal.clearance_m is not None:
        least = values["clearance_m"]["least"]
        yield f"clearance at least {goal.clearance_m:g} m", least, "{:.3f} m", least >= goal.clearance_m
    if goal.reached:
        yield f"reached at least {goal.reached:.0%}", reached, "{:.1%}", reached >= goal.reached
    if goal.time_ratio is not None:
        ratio = values["time_ratio"]
        enough = ratio is not None and ratio <= goal.time_ratio
        yield f"time / straight at most {goal.time_ratio:g}", ratio, "{:.2f}", enough
    if values["computation_ms"] is not None:
        p99 = values["computation_ms"]["p99"]
        yield f"p99 of computation at most {p99_ms:g} ms", p99, "{:.2f} ms", p99 <= p99_ms


def time_over_compared(row: Row, flights: pd.DataFrame) -> float | None:
    """Return the mean time of the judged algorithm over the other's, where both arrived; None if nowhere."""
    arrived = flights[flights["reached"].astype(bool)].assign(place=row.places(flights))
    times = arrived.pivot_table("flight_time_s", ["place", "replicate"], "algorithm")
    if not {JUDGED, COMPARED} <= set(times):
        return None
    both = times.dropna(subset=[JUDGED, COMPARED])
    return float(both[JUDGED].mean() / both[COMPARED].mean()) if len(both) else None


def verdicts_table(found: Sequence[Verdict]) -> str:
    """Return the verdicts as a table."""
    rows = [(v.name, f"{v.speed_m_s:g}", v.goal, v.found, "met" if v.met else "missed") for v in found]
    return table(("row", "m/s", "goal", "found", ""), rows)
