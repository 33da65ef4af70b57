"""The velocities that are tried."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cepa.decision import Reason
from cepa.dynamic.constants.choice import (
    FAN_CLIMBS,
    FAN_COARSER,
    FAN_DIRECTIONS,
    FAN_FASTER_OF,
    FAN_SPEEDS,
    LEADS_BACK_COS,
    LEVEL_CLIMB_M_S,
)

REFERENCE, LAST, STANDSTILL = range(3)
"""Rows of the candidates; the fan follows."""
OFFSETS_RAD, SHARES = np.arange(FAN_DIRECTIONS) * (2.0 * math.pi / FAN_DIRECTIONS), np.array(FAN_SPEEDS)


class Chosen(NamedTuple):
    """A command that was chosen."""

    command: np.ndarray
    """(3,) m/s"""
    cost: float
    tested: int
    """Of so many."""
    reason: Reason


def candidates(v_ref: np.ndarray, last: np.ndarray, speed: float, fastest: float = 0.0) -> np.ndarray:
    """Return the velocities (n, 3), m/s: v_ref, the last command, standstill, and a fan of directions.

    v_ref, last: (3,). speed: the greatest that the fan has. fastest: if it is greater, all directions are
    tried with it, too, behind the others. The last command is limited to the greater one.
    """
    tried = np.append(speed * SHARES, fastest) if fastest > speed else speed * SHARES
    commands = np.zeros((STANDSTILL + 1 + len(tried) * FAN_DIRECTIONS, 3))
    commands[REFERENCE] = v_ref
    commands[LAST] = last * min(1.0, max(speed, fastest) / max(math.hypot(last[0], last[1]), 1e-9))
    angles = math.atan2(v_ref[1], v_ref[0]) + OFFSETS_RAD
    speeds, fans = tried[:, None], commands[STANDSTILL + 1 :].reshape(len(tried), FAN_DIRECTIONS, 3)
    np.multiply(speeds, np.cos(angles), out=fans[:, :, 0])
    np.multiply(speeds, np.sin(angles), out=fans[:, :, 1])
    return commands


def climbing(level: np.ndarray, climb: float, climb_max: float) -> np.ndarray:
    """Return ``level`` (n, 3), which ``candidates`` gives, with climbs of at most ``climb_max``, m/s.

    climb: towards the height to fly at. Every direction is tried with it, some with the greatest climb and
    descent and with none.
    """
    kept = level.copy()
    kept[STANDSTILL + 1 :, 2] = climb
    kept[:, 2] = np.clip(kept[:, 2], -climb_max, climb_max)
    fast = STANDSTILL + 1 + np.arange(0, FAN_DIRECTIONS * len(FAN_SPEEDS) // FAN_FASTER_OF, FAN_COARSER)
    some = kept[np.concatenate(([REFERENCE, LAST, STANDSTILL], fast))]
    halves = kept[[REFERENCE, LAST, REFERENCE, LAST]]
    halves[:, 2] = climb_max * np.array([0.5, 0.5, -0.5, -0.5])
    climbs = [share for share in FAN_CLIMBS if share != 0.0 or abs(climb) > LEVEL_CLIMB_M_S]
    return np.concatenate((kept, halves, *(some * (1, 1, 0) + (0, 0, climb_max * share) for share in climbs)))


def leads_back(commands: np.ndarray, way: np.ndarray) -> np.ndarray:
    """Return which commands (n, 3) lead back along the direction ``way`` (2,), or nowhere; all if it is 0."""
    if not way.any():
        return np.ones(len(commands), np.bool_)
    speeds = np.hypot(commands[:, 0], commands[:, 1])
    return commands[:, :2] @ way <= -LEADS_BACK_COS * np.hypot(*way) * speeds
