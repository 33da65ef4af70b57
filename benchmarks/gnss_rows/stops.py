"""How soon the UAV stops when `vision_pose_publisher` dies for good: at many places of one round of the hold.

Every `PERIOD_S` of the round it dies in a copy of the flight. Times count from the last pose's scan, one of
them also from the death.
"""

from __future__ import annotations

from functools import partial
from typing import Sequence

import numpy as np

from benchmarks.gnss_rows.hold import loop_in_hold
from benchmarks.shared.forked import in_a_copy
from flights.flight.closed_loop import ClosedLoop
from flights.flight.course import Phase
from flights.flight.judging.stop_metrics import stop_of
from flights.flight.without_gnss import BRIDGE, Outage

PERIOD_S, WATCHED_S = 1.3, 1.6
FIRST_S = 4.0
"""The UAV has left its start."""
LOST_SCAN_S, FLIES_ON_S = 0.1, 2.0
"""The bridge misses one scan of the URG, and the UAV is at its speed again when the bridge dies."""
MOVES_M_S = 0.2
TURNS_RAD_S = 0.3


def fly(lidar: str, seed: int, after_lost_scan: bool = False) -> list[dict]:
    """Fly the round and return a stop for each place where the UAV was moving."""
    stops = []
    with loop_in_hold(lidar, seed) as loop:
        loop.run_to(Phase.FLYING)
        due_s = loop.time_s + FIRST_S
        while _is_on_its_way(loop):
            loop.step()
            if loop.time_s >= due_s:
                due_s += PERIOD_S
                stops.append(in_a_copy(partial(_die, loop, after_lost_scan)))
    return [stop for stop in stops if stop["speed_m_s"] > MOVES_M_S]


def _die(loop: ClosedLoop, after_lost_scan: bool) -> dict:
    """Let the bridge die, and return the stop. Changes the flight."""
    loop.listeners.clear()  # SLAM does nothing for the stop
    if after_lost_scan:
        loop.outage = Outage(BRIDGE, loop.time_s, LOST_SCAN_S)
        flies_on_s = loop.time_s + FLIES_ON_S
        loop.run(until=lambda loop: loop.time_s >= flies_on_s)
    died_s, noticed_s = loop.time_s, None
    loop.outage = Outage(BRIDGE, died_s)
    while not loop.is_over and loop.time_s < died_s + WATCHED_S:
        loop.step()
        if noticed_s is None and not loop.publisher.ready:
            noticed_s = loop.time_s
    assert loop.own_odometry is not None  # there is no GNSS
    assert loop.own_odometry.told_us is not None
    lost_s = 1e-6 * loop.own_odometry.told_us
    brakes_s = None if noticed_s is None else noticed_s - lost_s
    stop = stop_of(loop.log.truth.rows, lost_s)
    after_death_s = None if stop.slow_s is None else stop.slow_s - (died_s - lost_s)
    return {"brakes_s": brakes_s, "after_death_s": after_death_s, **stop._asdict()}


def _is_on_its_way(loop: ClosedLoop) -> bool:
    return not loop.is_over and Phase.HOVERING not in loop.outcome.times_s


def summary(stops: Sequence[dict]) -> dict:
    """Return counts, and of all stops and of those in curves how long they took; an unknown time is None."""
    turning = [stop for stop in stops if abs(stop["turn_rad_s"]) >= TURNS_RAD_S]
    return {
        "stops": len(stops),
        "turning": len(turning),
        "median_s": _median(stops, "slow_s"),
        "worst_s": _worst(stops, "slow_s"),
        "worst_after_death_s": _worst(stops, "after_death_s"),
        "turning_median_s": _median(turning, "slow_s"),
        "turning_worst_s": _worst(turning, "slow_s"),
        "brakes_after_s": _median(stops, "brakes_s"),
        "stays_slow_s": _median(stops, "stays_slow_s"),
        "fastest_after_m_s": _worst(stops, "fastest_after_m_s"),
        "way_m": _worst(stops, "way_m"),
    }


def _median(stops: Sequence[dict], key: str) -> float | None:
    values = [stop[key] for stop in stops]
    return float(np.median(values)) if values and None not in values else None


def _worst(stops: Sequence[dict], key: str) -> float | None:
    values = [stop[key] for stop in stops]
    return max(values) if values and None not in values else None
