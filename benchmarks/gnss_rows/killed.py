"""Parts of the chain that die in flight: for 0.3 s, many in one round of the hold, or for good.

Short ones come about every 2 s of the flight, each part in turn, at times that the seed draws. After a death
for good the flight is watched until the UAV is disarmed, or for 12 s.
"""

from __future__ import annotations

import math
from typing import Sequence

import numpy as np

from benchmarks.gnss_rows.hold import loop_in_hold
from flights.flight.course import Phase
from flights.flight.judging.contacts import GROUND
from flights.flight.judging.stop_metrics import SLOW_M_S, horizontal_speeds
from flights.flight.without_gnss import PARTS, SLAM, Outage

LIDAR = "ust"
SHORT_S, PERIOD_S, WATCHED_S = 0.3, 2.0, 12.0


def briefly(seed: int) -> dict:
    """Fly the round of Experiment 4 with a short death every 2 s; return how many of each part."""
    rng = np.random.default_rng(seed)
    with loop_in_hold(LIDAR, seed) as loop:
        loop.run_to(Phase.FLYING)
        kills = dict.fromkeys(PARTS, 0)
        order: list[str] = []
        while Phase.HOVERING not in loop.outcome.times_s and not loop.is_over:
            order = order or list(rng.permutation(PARTS))
            part, begins_s = order.pop(), loop.time_s + rng.uniform(0.0, PERIOD_S - SHORT_S)
            ends_s = loop.time_s + PERIOD_S
            loop.outage = Outage(part, begins_s, SHORT_S)
            while loop.time_s < ends_s and not loop.is_over:
                loop.step()
            kills[part] += 1
        loop.outage = None
        outcome = loop.run()
        return {"kills": kills, "contact": outcome.collision, "flown": outcome.success}


def for_good(part: str, seed: int) -> dict:
    """Let a part die for good on the first leg of the round; return what came of it."""
    rng = np.random.default_rng(seed)
    with loop_in_hold(LIDAR, seed, backwards=bool(rng.integers(2))) as loop:
        loop.run_to(Phase.FLYING)
        begins_s = loop.time_s + rng.uniform(1.0, 12.0)
        loop.outage = Outage(part, begins_s)
        moving_s = begins_s
        while not loop.is_over and loop.time_s < begins_s + WATCHED_S:
            loop.step()
            if any(loop.publisher.velocity_m_s) and loop.time_s >= begins_s:
                moving_s = loop.time_s
        truth = np.array(loop.log.truth.rows)
        landed = bool(truth[-1, 3] < 0.3)
        after = truth[truth[:, 0] >= begins_s]
        speeds = horizontal_speeds(after)
        way_m = np.hypot(*(after[:, 1:3] - after[0, 1:3]).T)
        return {
            "contact": any(shape.split("::")[0] != GROUND for shape in loop.outcome.touched),
            "landed": landed,
            "speed_m_s": float(speeds[0]),
            "way_m": float(way_m.max()),
            "commanded_s": moving_s - begins_s,
            "stands_s": _first_stand_s(after[:, 0] - begins_s, speeds),
        }


def _first_stand_s(times_s: np.ndarray, speeds_m_s: np.ndarray) -> float:
    """Return the time from which on the UAV stands for a second; infinity if it never does."""
    moving_s = times_s[speeds_m_s > SLOW_M_S]
    edges_s = np.concatenate(([0.0], moving_s, times_s[-1:]))
    stands = np.flatnonzero(np.diff(edges_s) > 1.0)
    return float(edges_s[stands[0]]) if len(stands) else math.inf


def summary_for_good(part: str, trials: Sequence[dict]) -> dict:
    """Return counts, and the worst of each measured value; SLAM's flights go on, so they have none."""
    numbers = {
        "kills": len(trials),
        "contacts": sum(trial["contact"] for trial in trials),
        "landed": sum(trial["landed"] for trial in trials),
    }
    if part != SLAM:
        for key in ("way_m", "commanded_s", "stands_s"):
            values = [trial[key] for trial in trials]
            numbers[key] = {"median": float(np.median(values)), "worst": max(values)}
    return numbers


def summary_briefly(part: str, trials: Sequence[dict]) -> dict:
    """Return the number of deaths of a part, and of flights with a contact or without an end."""
    return {
        "kills": sum(trial["kills"][part] for trial in trials),
        "contacts": sum(trial["contact"] for trial in trials),
        "flown": sum(trial["flown"] for trial in trials),
        "flights": len(trials),
    }


def flights_for(kills: int, flight_s: float = 80.0) -> int:
    """Return how many rounds hold so many short deaths of each part."""
    return math.ceil(kills * len(PARTS) * PERIOD_S / flight_s)
