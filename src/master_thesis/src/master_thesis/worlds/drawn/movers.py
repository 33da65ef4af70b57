"""Open fields in which something meets the UAV: it crosses the straight way, or comes head-on.

It is as wide as a person or as a lorry, and higher than the flight, so that a lidar sees it however the UAV
leans. It moves evenly by a script of simulated time, in which the goal is sent after about 8.1 s.
"""

from __future__ import annotations

import math

import numpy as np

from master_thesis.worlds.drawn.materials import GRASS, STEEL
from master_thesis.worlds.writer import Box, Cylinder, Part, Walk, write_world

CROSSING, HEAD_ON = "crossing", "head_on"
GOAL_SENT_S = 8.1
"""From the simulation's start; it differs by 0.2 s from seed to seed."""
LAG_S = 0.6
"""By which a flight is behind one that has its full speed at once."""
MEETINGS = (0.35, 0.65)
"""Where it meets a UAV that flies straight, as shares of the way."""
_PERSON, _LORRY = Cylinder(0.3, 4.0), Box(4.5, 1.8, 4.0)
_GOES_ON_S = 20.0


def meeting_sdf(
    rng: np.random.Generator, kind: str, distance_m: float, speed_m_s: float, mover_speed_m_s: float
) -> str:
    """Return a field in which something meets a UAV of this speed; kind: CROSSING or HEAD_ON."""
    meeting_x = distance_m * rng.uniform(*MEETINGS)
    meeting_s = GOAL_SENT_S + meeting_x / speed_m_s + LAG_S + rng.uniform(-0.15, 0.15)
    meeting_y = rng.uniform(-0.3, 0.3)
    if kind == CROSSING:
        direction_rad = rng.choice((-1.0, 1.0)) * (math.pi / 2 + rng.uniform(-math.pi / 6, math.pi / 6))
    else:
        direction_rad = math.pi + rng.uniform(-0.1, 0.1)
    shape = _PERSON if rng.random() < 0.5 else _LORRY
    times_s = np.linspace(0.0, meeting_s + _GOES_ON_S, round(meeting_s + _GOES_ON_S) + 1)
    way_m = mover_speed_m_s * (times_s - meeting_s)
    x, y = meeting_x + way_m * math.cos(direction_rad), meeting_y + way_m * math.sin(direction_rad)
    waypoints = np.column_stack((times_s, x, y, np.full_like(x, direction_rad)))
    walk = Walk("mover", (Part("body", shape, STEEL),), tuple(map(tuple, waypoints.tolist())))
    return write_world(kind, "Something that meets the UAV, drawn at random.", GRASS, (), (walk,))
