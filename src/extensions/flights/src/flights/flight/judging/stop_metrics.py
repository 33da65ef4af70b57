"""How soon the UAV stops after it has lost its pose."""

from __future__ import annotations

from typing import NamedTuple, Sequence

import numpy as np

from simulation_tools.geometry import wrap_angle, yaw_from_quaternion

SLOW_M_S = 0.1
GOAL_S = 0.5
_TURN_WINDOW_S = 0.04


class Stop(NamedTuple):
    """One stop, from the last pose on; horizontal.

    speed_m_s, turn_rad_s: at the last pose. slow_s: time until it is slower than `SLOW_M_S`; None: never.
    stays_slow_s: time from which on it stays slower. fastest_after_m_s: greatest speed after `GOAL_S`.
    way_m: greatest distance from the place of the last pose.
    """

    speed_m_s: float
    turn_rad_s: float
    slow_s: float | None
    stays_slow_s: float
    fastest_after_m_s: float
    way_m: float


def stop_of(truth: Sequence[tuple], lost_s: float) -> Stop:
    """Return the stop. truth: rows of `FlightLog.truth` until more than `GOAL_S` after lost_s."""
    rows = np.array(truth)
    speeds_m_s = horizontal_speeds(rows)
    lost = int(np.searchsorted(rows[:, 0], lost_s - 1e-9))
    before = int(np.searchsorted(rows[:, 0], lost_s - _TURN_WINDOW_S))
    turned_rad = wrap_angle(_yaw_rad(rows[lost]) - _yaw_rad(rows[before]))
    after, speeds_m_s = rows[lost:], speeds_m_s[lost:]
    times_s = after[:, 0] - lost_s
    is_slow = speeds_m_s < SLOW_M_S
    return Stop(
        speed_m_s=float(speeds_m_s[0]),
        turn_rad_s=float(turned_rad / (rows[lost, 0] - rows[before, 0])),
        slow_s=float(times_s[is_slow][0]) if is_slow.any() else None,
        stays_slow_s=float(times_s[~is_slow].max(initial=0.0)),
        fastest_after_m_s=float(speeds_m_s[times_s > GOAL_S].max()),
        way_m=float(np.hypot(*(after[:, 1:3] - after[0, 1:3]).T).max()),
    )


def horizontal_speeds(rows: np.ndarray) -> np.ndarray:
    """Return the true horizontal speeds (n,). rows (n, 3 or more): time, x, y."""
    return np.hypot(*np.gradient(rows[:, 1:3], rows[:, 0], axis=0).T)


def _yaw_rad(row: np.ndarray) -> float:
    x, y, z, w = row[4:8].tolist()
    return yaw_from_quaternion((x, y, z, w))
