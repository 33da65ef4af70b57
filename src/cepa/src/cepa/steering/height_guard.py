"""Keeps a UAV whose algorithm does not climb away from floor and ceiling, by range finders."""

from __future__ import annotations

import math
from typing import Callable, Sequence

from cepa.dynamic.constants.response import CLIMB_LAG_S
from cepa.motion import Ranging
from cepa.parameters import CepaParameters

Warn = Callable[[str], None]


def guarded_climb(climb_m_s: float, rangings: Sequence[Ranging], p: CepaParameters, warn: Warn) -> float:
    """Return the part of a climb (< 0: a descent) after which the UAV can stop at r_LB from what is ahead.

    As CEPA's inner cushion, upright: r_LB counts from the body's middle, and within it the UAV goes no
    nearer. It is never pushed away, so it can stand on the ground. Without a range in this direction all is
    allowed.

    rangings: in the body's frame. warn: takes a sentence about a range finder that measures nothing.
    """
    up = math.copysign(1.0, climb_m_s)
    for ranging in rangings:
        if climb_m_s == 0.0 or ranging.direction[2] * up <= 0.0:
            continue
        if math.isnan(ranging.range_m):
            way = ("down", "sink") if up < 0.0 else ("up", "climb")
            warn(f"The range finder that looks {way[0]} measures nothing (NaN); the UAV does not {way[1]}.")
        elif ranging.range_m > ranging.range_max_m:
            continue
        free_m = up * (ranging.origin_m[2] + ranging.free_m * ranging.direction[2]) - p.r_lb
        climb_m_s = up * min(abs(climb_m_s), stopping_speed(free_m, p))
    return climb_m_s


def stopping_speed(free_m: float, p: CepaParameters) -> float:
    """Return the vertical speed (m/s) that is lost within `free_m`; 0 where nothing is free.

    The UAV flies on for the braking latency and twice the vertical lag, then brakes with
    `braking_deceleration`. With one lag it would come some 0.02 m nearer before it stops.
    """
    late_m_s = p.braking_deceleration * (p.braking_latency + 2.0 * CLIMB_LAG_S)
    return math.sqrt(late_m_s**2 + 2.0 * p.braking_deceleration * max(0.0, free_m)) - late_m_s
