"""Open fields in which something meets the UAV: a person or lorry, people abreast, a load, a small UAV.

A person or a lorry is higher than the flight, so that a lidar sees it however the UAV leans. All moves evenly
by a script of simulated time, in which the goal is sent after about 8.1 s.
"""

from __future__ import annotations

import math

import numpy as np

from flights.worlds.drawn.materials import GRASS, STEEL
from flights.worlds.writer import Box, Cylinder, Part, Shape, Walk, write_world

CROSSING, HEAD_ON = "crossing", "head_on"
ABREAST, SINKING, SMALL_UAV = "abreast", "sinking", "small_uav"
GOAL_SENT_S = 8.1
"""From the simulation's start; it differs by 0.2 s from seed to seed."""
LAG_S = 0.6
"""By which a flight is behind one that has its full speed at once."""
MEETINGS = (0.35, 0.65)
"""Where it meets a UAV that flies straight, as shares of the way."""
_PERSON, _LORRY = Cylinder(0.3, 4.0), Box(4.5, 1.8, 4.0)
_SMALL_UAV = Box(0.4, 0.4, 0.2)
_GOES_ON_S = 20.0
PERSONS, PERSONS_APART_M, WALKING_M_S = (2, 8), (0.8, 2.5), (0.7, 2.0)
LOADS_M, SINKING_M_S, LOAD_TIMING_S = (0.3, 2.0), (0.2, 2.0), 1.0
SMALL_UAV_M_S, SMALL_UAV_ABOVE_M = (1.0, 3.0), (-0.4, 0.4)
"""What is drawn: least and greatest."""


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
    velocity = mover_speed_m_s * math.cos(direction_rad), mover_speed_m_s * math.sin(direction_rad), 0.0
    meeting = (meeting_x, meeting_y, 0.0), meeting_s
    return _field(kind, (_walk("mover", shape, *meeting, velocity, direction_rad),))


def abreast_sdf(rng: np.random.Generator, distance_m: float, speed_m_s: float) -> str:
    """Return a field in which people come head-on, side by side."""
    persons = int(rng.integers(PERSONS[0], PERSONS[1] + 1))
    apart_m, walking_m_s = rng.uniform(*PERSONS_APART_M), rng.uniform(*WALKING_M_S)
    meeting_x, meeting_s = _meeting(rng, distance_m, speed_m_s)
    direction_rad, meeting_y = math.pi + rng.uniform(-0.1, 0.1), rng.uniform(-0.3, 0.3)
    c, s = math.cos(direction_rad), math.sin(direction_rad)
    walks = []
    for number in range(persons):
        aside_m = apart_m * (number - 0.5 * (persons - 1))
        place = meeting_x - s * aside_m, meeting_y + c * aside_m, 0.0
        velocity = walking_m_s * c, walking_m_s * s, 0.0
        walks.append(_walk(f"person_{number}", _PERSON, place, meeting_s, velocity, direction_rad))
    return _field(ABREAST, tuple(walks))


def sinking_sdf(rng: np.random.Generator, distance_m: float, speed_m_s: float, height_m: float) -> str:
    """Return a field in which a load comes down to the floor, onto a UAV that flies straight."""
    edge_m, sinking_m_s = rng.uniform(*LOADS_M), rng.uniform(*SINKING_M_S)
    meeting_x, meeting_s = _meeting(rng, distance_m, speed_m_s)
    meeting_s += rng.uniform(-LOAD_TIMING_S, LOAD_TIMING_S)
    place = meeting_x, rng.uniform(-0.3, 0.3), height_m
    load, velocity = Box(edge_m, edge_m, edge_m), (0.0, 0.0, -sinking_m_s)
    return _field(SINKING, (_walk("load", load, place, meeting_s, velocity, rng.uniform(0.0, math.pi)),))


def small_uav_sdf(rng: np.random.Generator, distance_m: float, speed_m_s: float, height_m: float) -> str:
    """Return a field in which a UAV of 0.4 m by 0.2 m meets one that flies straight, from any quarter."""
    meeting_x, meeting_s = _meeting(rng, distance_m, speed_m_s)
    direction_rad, flying_m_s = rng.uniform(-math.pi, math.pi), rng.uniform(*SMALL_UAV_M_S)
    middle_m = height_m + rng.uniform(*SMALL_UAV_ABOVE_M)
    place = meeting_x, rng.uniform(-0.2, 0.2), middle_m - 0.5 * _SMALL_UAV.z_m
    velocity = flying_m_s * math.cos(direction_rad), flying_m_s * math.sin(direction_rad), 0.0
    return _field(SMALL_UAV, (_walk("intruder", _SMALL_UAV, place, meeting_s, velocity, direction_rad),))


def _meeting(rng: np.random.Generator, distance_m: float, speed_m_s: float) -> tuple[float, float]:
    """Return where, m along the straight way, and when, s, something meets the UAV."""
    meeting_x = distance_m * rng.uniform(*MEETINGS)
    return meeting_x, GOAL_SENT_S + meeting_x / speed_m_s + LAG_S + rng.uniform(-0.15, 0.15)


def _walk(
    name: str,
    shape: Shape,
    place_m: tuple[float, float, float],
    meeting_s: float,
    velocity_m_s: tuple[float, float, float],
    yaw_rad: float,
) -> Walk:
    """Return something that is at a place at a time, and moves evenly before and after, down to the floor."""
    end_s = meeting_s + _GOES_ON_S
    times_s = np.linspace(0.0, end_s, round(end_s) + 1)
    if velocity_m_s[2] < 0.0:
        floor_s = min(end_s, meeting_s - place_m[2] / velocity_m_s[2])
        times_s = np.sort(np.append(times_s, floor_s))
    x, y, z = (at + v * (times_s - meeting_s) for at, v in zip(place_m, velocity_m_s))
    z = np.maximum(z, 0.0)
    waypoints = np.column_stack((times_s, x, y, z, np.full_like(x, yaw_rad)))
    return Walk(name, (Part("body", shape, STEEL),), tuple(map(tuple, waypoints.tolist())))


def _field(name: str, walks: tuple[Walk, ...]) -> str:
    return write_world(name, "Something that meets the UAV, drawn at random.", GRASS, (), walks)
