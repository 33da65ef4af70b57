"""Seeded worlds whose places look alike: rows of equal rooms, parallel corridors, the hold's beams."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import Callable, Sequence

import numpy as np
from planar_world import Drift, Lidar, Log, along, drive

from gridslam import SlamParameters, se2
from gridslam.evaluation import Walls
from gridslam.session import SlamSession

STEP_M = 0.25
DOOR_M = 1.0
PARAMETERS = SlamParameters(particles=15, linearUpdate=0.5, angularUpdate=0.3, threads=1)


@dataclass(frozen=True)
class World:
    """Walls, and a route (k, 2) through them."""

    name: str
    walls: Walls
    route_xy: np.ndarray


def world(seed: int) -> World:
    """Return the world of a seed: its kind and its sizes are drawn."""
    return KINDS[seed % len(KINDS)](np.random.default_rng(seed))


def flight(seed: int) -> Log:
    """Return a drive along the route of a seed's world: lidar and odometry's drift are drawn."""
    rng = np.random.default_rng((seed, 1))
    range_m, drift = float(rng.choice([5.6, 8.0, 10.0])), float(rng.uniform(1.0, 3.0))
    lidar = Lidar(math.radians(float(rng.choice([240.0, 270.0, 359.0]))), 271, range_m, 0.01, 10.0)
    drifting = Drift(0.01 * drift, 0.002 * drift, 0.02 * drift, 0.01 * drift, 0.02 * drift)
    place = world(seed)
    return drive(place.walls, along(place.route_xy, STEP_M), lidar, seed, drifting)


def closure_errors(seed: int) -> np.ndarray:
    """Map a seed's drive with loop closure. Return each closure's error (n, 2), m and rad."""
    log = flight(seed)
    session = SlamSession(
        dataclasses.replace(PARAMETERS, seed=seed), starting_pose=tuple(log.truth.poses_in_map[0])
    )
    for scan, odometry in zip(log.scans, log.odometry):
        session.process(scan, odometry)
    session.finish()
    errors = []
    for closure in session.closures:
        moments = np.searchsorted(log.truth.stamps_s, (closure.stamp_from_s, closure.stamp_to_s))
        older, newer = log.truth.poses_in_map[moments]
        error = se2.between(se2.between(older, newer), np.array(closure.pose_difference))
        errors.append((math.hypot(error[0], error[1]), abs(error[2])))
    return np.array(errors).reshape(-1, 2)


def rooms_along_a_corridor(rng: np.random.Generator) -> World:
    """Equal rooms on one side of a corridor; the route visits each, and comes back along the corridor."""
    count, wide, deep = int(rng.integers(3, 6)), rng.uniform(3.0, 6.0), rng.uniform(3.0, 6.0)
    length, corridor = count * wide, 2.0
    segments = [(0, 0, length, 0), (0, 0, 0, corridor + deep), (length, 0, length, corridor + deep)]
    segments.append((0, corridor + deep, length, corridor + deep))
    route = [(0.8, 1.0)]
    for room in range(count):
        left, middle = room * wide, (room + 0.5) * wide
        segments += [
            (left, corridor, left, corridor + deep),
            (left, corridor, middle - DOOR_M / 2, corridor),
            (middle + DOOR_M / 2, corridor, left + wide, corridor),
        ]
        route += [(middle, 1.0), (middle, corridor + 0.6 * deep), (middle, 1.0)]
    return World(
        "rooms_along_a_corridor", _walls(segments), np.array([*route, (length - 0.8, 1.0), route[0]])
    )


def rooms_in_a_row(rng: np.random.Generator) -> World:
    """Equal rooms, each with a door to the next; there and back."""
    count, wide, deep = int(rng.integers(4, 8)), rng.uniform(3.0, 5.0), rng.uniform(3.0, 5.0)
    segments = [(0, 0, count * wide, 0), (0, deep, count * wide, deep)]
    segments += [(0, 0, 0, deep), (count * wide, 0, count * wide, deep)]
    for x in wide * np.arange(1, count):
        segments += [(x, 0, x, (deep - DOOR_M) / 2), (x, (deep + DOOR_M) / 2, x, deep)]
    ends = [(0.5 * wide, 0.5 * deep), ((count - 0.5) * wide, 0.5 * deep)]
    return World("rooms_in_a_row", _walls(segments), np.array([*ends, ends[0]]))


def parallel_corridors(rng: np.random.Generator) -> World:
    """Two equal corridors, joined at their ends; out along one, back along the other."""
    length, apart, wide = rng.uniform(15.0, 30.0), rng.uniform(4.0, 8.0), 2.0
    niches = np.arange(3.0, length - 3.0, rng.uniform(3.0, 5.0))
    outer = _box(-wide / 2, -wide / 2, length + wide / 2, apart + wide / 2)
    inner = _box(wide / 2, wide / 2, length - wide / 2, apart - wide / 2)
    segments = outer + inner
    for x in niches:
        for y in (-wide / 2, apart + wide / 2 - 0.3):
            segments += _box(x, y, x + 0.4, y + 0.3)
    corners = np.array([(0.0, 0.0), (length, 0.0), (length, apart), (0.0, apart)])
    route = np.concatenate([[(length / 2, 0.0)], corners[1:], corners[:1], [(length / 2 + 3.0, 0.0)]])
    return World("parallel_corridors", _walls(segments), route)


def beams(rng: np.random.Generator) -> World:
    """A hall with the same beam every few metres on all sides; once round."""
    every, counts = rng.uniform(2.5, 4.0), (int(rng.integers(5, 10)), int(rng.integers(4, 7)))
    width, height = counts[0] * every, counts[1] * every
    segments = _box(0.0, 0.0, width, height)
    for x in every * (np.arange(counts[0]) + 0.5):
        segments += _box(x - 0.5, 0.0, x + 0.5, 0.5) + _box(x - 0.5, height - 0.5, x + 0.5, height)
    for y in every * (np.arange(counts[1]) + 0.5):
        segments += _box(0.0, y - 0.5, 0.5, y + 0.5) + _box(width - 0.5, y - 0.5, width, y + 0.5)
    near = 2.5
    corners = [(width - near, near), (width - near, height - near), (near, height - near), (near, near)]
    return World("beams", _walls(segments), np.array([(width / 2, near), *corners, (width / 2 + 3.0, near)]))


KINDS: tuple[Callable[[np.random.Generator], World], ...] = (
    rooms_along_a_corridor,
    rooms_in_a_row,
    parallel_corridors,
    beams,
)


def _box(x0: float, y0: float, x1: float, y1: float) -> list[tuple]:
    return [(x0, y0, x1, y0), (x1, y0, x1, y1), (x1, y1, x0, y1), (x0, y1, x0, y0)]


def _walls(segments: Sequence[tuple]) -> Walls:
    return Walls(np.array(segments, float))
