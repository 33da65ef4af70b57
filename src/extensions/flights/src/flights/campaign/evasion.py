"""Flies what a UAV can do within its own response to get out of the way: in each direction, up and down.

Whatever velocity is commanded, the acceleration is at most `acceleration_max_m_s2` of the response, and
changes by at most `jerk_max_m_s3`. CEPA counts on no more. So each flight here wants the greatest
acceleration in a direction, and changes to it as fast as it can. Some keep it, some stop after a while, and
some go on in another direction, around a corner. The height follows with CEPA's lag.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cepa.dynamic.constants.response import CLIMB_LAG_S
from cepa.identification.response import ResponseModel

DIRECTIONS, FIRST_OF_TWO = 72, 24
"""Directions that are kept, or in which the UAV stops; and those that it changes between."""
STOPS_S = tuple(np.arange(0.1, 1.6, 0.1).round(1).tolist())
TURNS_S = (0.1, 0.2, 0.4, 0.8)
"""When it begins to brake, or changes its direction."""
STANDS_M_S = 0.02
CLIMBS_M_S = (-1.0, 0.0, 3.0)
"""PX4's MPC_Z_VEL_MAX_DN, the height that it has, and MPC_Z_VEL_MAX_UP."""
GRAVITY_M_S2 = 9.81
FORESEEN_S, STEP_S = 4.0, 0.01


@dataclass(frozen=True)
class Start:
    """A UAV when a command shows its first effect. Its vectors are (3,)."""

    time_s: float
    place_m: np.ndarray
    velocity_m_s: np.ndarray
    acceleration_m_s2: np.ndarray
    yaw_rad: float = 0.0


@dataclass(frozen=True)
class _Wishes:
    """Accelerations that n flights want (n, 2), m/s2: ``first``, and from ``until_s`` (n,) on ``then``.

    is_braking (n,): they want to stand from then on.
    """

    first: np.ndarray
    then: np.ndarray
    until_s: np.ndarray
    is_braking: np.ndarray

    def at(self, time_s: float, velocity_m_s: np.ndarray, most_m_s2: float) -> np.ndarray:
        """Return what they want (n, 2) at their velocities (n, 2)."""
        wanted = np.where((time_s < self.until_s)[:, None], self.first, self.then)
        brakes = self.is_braking & (time_s >= self.until_s)
        speed = np.hypot(*velocity_m_s[brakes].T)[:, None]
        against = -most_m_s2 * velocity_m_s[brakes] / np.maximum(speed, STANDS_M_S)
        wanted[brakes] = against
        return wanted


def times_s() -> np.ndarray:
    """Return the times (t,), s after the start, at which flights are looked at."""
    return STEP_S * np.arange(round(FORESEEN_S / STEP_S) + 1)


def level_flights(start: Start, model: ResponseModel) -> tuple[np.ndarray, np.ndarray]:
    """Return where the UAV can be, m, and how it accelerates, m/s2, (n, t, 2) at `times_s` of n flights."""
    most, change = model.acceleration_max_m_s2, model.jerk_max_m_s3 * STEP_S
    wishes = _wishes(most)
    place, v, a = (
        np.tile(vector[:2], (len(wishes.first), 1))
        for vector in (start.place_m, start.velocity_m_s, start.acceleration_m_s2)
    )
    paths, accelerations = [place], [a]
    for time_s in times_s()[:-1].tolist():
        lacks = wishes.at(time_s, v, most) - a
        new = a + lacks * np.minimum(1.0, change / np.maximum(np.hypot(*lacks.T), 1e-9))[:, None]
        place = place + STEP_S * (v + STEP_S * (2.0 * a + new) / 6.0)
        v = v + 0.5 * STEP_S * (a + new)
        a = new
        paths.append(place)
        accelerations.append(a)
    return np.stack(paths, axis=1), np.stack(accelerations, axis=1)


def lifted_m(offsets_m: np.ndarray, acceleration_m_s2: np.ndarray) -> np.ndarray:
    """Return how far the lean lifts what is beside a UAV's middle (2,), m, at accelerations (n, 2).

    A UAV leans to where it accelerates, so that its thrust is along its acceleration and against gravity.
    """
    thrust = np.hypot(GRAVITY_M_S2, np.hypot(*acceleration_m_s2.T))
    return np.asarray(-(acceleration_m_s2 @ offsets_m) / thrust)


def heights_m(start: Start) -> np.ndarray:
    """Return the heights (c, t), m, at `times_s` of a UAV that sinks, stays and climbs; 0: it has landed."""
    share = 1.0 - math.exp(-STEP_S / CLIMB_LAG_S)
    climbs = np.full(len(CLIMBS_M_S), start.velocity_m_s[2])
    wanted, heights = np.array(CLIMBS_M_S), [np.full(len(climbs), start.place_m[2])]
    for _ in times_s()[:-1]:
        climbs = climbs + share * (wanted - climbs)
        heights.append(np.maximum(0.0, heights[-1] + climbs * STEP_S))
    return np.stack(heights, axis=1)


def _wishes(most_m_s2: float) -> _Wishes:
    """Return all that is tried: straight on as before, stand, each direction, and two one after the other."""
    many, few = most_m_s2 * _compass(DIRECTIONS), most_m_s2 * _compass(FIRST_OF_TWO)
    none = np.zeros((1, 2))
    kept = np.concatenate((none, many))
    stopped = np.repeat(many, len(STOPS_S), axis=0)
    from_few = np.repeat(few, len(few) * len(TURNS_S), axis=0)
    to_few = np.tile(np.repeat(few, len(TURNS_S), axis=0), (len(few), 1))
    first = np.concatenate((kept, none, stopped, from_few))
    then = np.concatenate((kept, none, np.zeros_like(stopped), to_few))
    stop_s = np.concatenate(((0.0,), np.tile(STOPS_S, DIRECTIONS)))
    turn_s = np.tile(TURNS_S, len(few) ** 2)
    until_s = np.concatenate((np.full(len(kept), math.inf), stop_s, turn_s))
    is_braking = np.zeros(len(first), np.bool_)
    is_braking[len(kept) : len(kept) + len(stop_s)] = True
    return _Wishes(first, then, until_s, is_braking)


def _compass(number: int) -> np.ndarray:
    angles = np.arange(number) * (2.0 * math.pi / number)
    return np.column_stack((np.cos(angles), np.sin(angles)))
