"""CPU time of decisions in a hall of which half is known, without a flight: 45 of 100 x 60 x 20 m."""

from __future__ import annotations

import time

import numpy as np

from exploration.next_view import Explorer
from exploration.planning import FREE, OCCUPIED, UNKNOWN, PathPlanner
from flights.exploring.places import EXPLORER, PLANNER
from inspection.warm_up import warm_up

ROW = "decisions"
VOXELS_M = (0.1, 0.2)
SIDE = 16
"""Voxels along a tile, as slam_octomap has it."""
KNOWN_M, BREADTH_M, HEIGHT_M, BEYOND_M = 45.0, 60.0, 20.0, 6.0
PATCHES, MACHINES, SEED = 400, 60, 0
"""Unknown places under the ceiling and near the floor; boxes whose tops and sides are known."""
DECISIONS, STEP_M = 6, np.array((0.4, 0.0, 0.0))
BEGIN_M, HOME_M = np.array((38.0, 30.0, 8.0)), np.array((3.0, 3.0, 2.0))


def measure(voxel_m: float) -> dict:
    """Return the times of decisions on the way to a view, and of a plan home, s."""
    warm_up()
    kinds = hall(voxel_m)
    planner, explorer = planner_of(kinds, voxel_m), Explorer(EXPLORER)
    decisions_s, home_s, way_m = [], [], 0.0
    for number in range(DECISIONS):
        here_m = BEGIN_M + number * STEP_M
        planner.assume_free(here_m, 1.5)
        planner.space(float(number), here_m)  # what has changed is not the decision's
        began_s = time.thread_time()
        decision = explorer.decide(planner.space(float(number), here_m), here_m)
        decided_s = time.thread_time()
        way_m = planner.plan(here_m, HOME_M).length_m
        decisions_s.append(decided_s - began_s)
        home_s.append(time.thread_time() - decided_s)
        assert decision.goal_m is not None
    return {
        "voxels": kinds.size,
        "known_m3": float(np.count_nonzero(kinds)) * voxel_m**3,
        "first_s": decisions_s[0],
        "median_s": float(np.median(decisions_s[1:])),
        "home_median_s": float(np.median(home_s)),
        "home_m": way_m,
    }


def hall(voxel_m: float) -> np.ndarray:
    """Return kinds (d, h, w) of a hall whose border runs across it, ragged, with patches and machines."""
    rng = np.random.default_rng(SEED)
    high, broad, long = (round(m / voxel_m) + 2 for m in (HEIGHT_M, BREADTH_M, KNOWN_M + BEYOND_M))
    kinds = np.zeros([-(-size // SIDE) * SIDE for size in (high, broad, long)], np.uint8)
    y = np.arange(broad) * voxel_m
    edge_m = KNOWN_M + 3.0 * np.sin(y / 3.0) + 1.5 * np.sin(1.7 * y) + 0.3 * rng.standard_normal(broad)
    is_known = np.arange(long) * voxel_m < edge_m[:, None]
    kinds[1 : high - 1, 1 : broad - 1, 1:long] = np.where(is_known[1:-1, 1:], FREE, UNKNOWN)
    wall = round(KNOWN_M / voxel_m)
    kinds[0, :broad, :long] = np.where(is_known, OCCUPIED, UNKNOWN)
    kinds[:high, (0, broad - 1), :wall] = kinds[:high, :broad, 0] = OCCUPIED
    kinds[high - 1, :broad, : round(0.6 * wall)] = OCCUPIED
    for _ in range(PATCHES):
        x, across = rng.uniform((2.0, 1.3), (KNOWN_M, BREADTH_M - 1.3)) / voxel_m
        up = rng.choice([rng.uniform(HEIGHT_M - 3.0, HEIGHT_M - 0.2), rng.uniform(0.2, 2.0)]) / voxel_m
        _fill(kinds, (up, across, x), rng.uniform(0.3, 1.2) / voxel_m * np.array((0.5, 1.0, 1.0)), UNKNOWN)
    for _ in range(MACHINES):
        x, across = rng.uniform((2.0, 2.0), (KNOWN_M - 3.0, BREADTH_M - 2.0)) / voxel_m
        half, tall = rng.uniform(0.3, 1.5) / voxel_m, rng.uniform(0.5, 6.0) / voxel_m
        _fill(kinds, (tall / 2, across, x), np.array((tall / 2, half, half)), OCCUPIED)
        _fill(kinds, (tall / 2 - 1, across, x), np.array((tall / 2 - 1, half - 1, half - 1)), UNKNOWN)
    return kinds


def planner_of(kinds: np.ndarray, voxel_m: float) -> PathPlanner:
    """Return a planner that knows these kinds."""
    planner, tiles = PathPlanner(PLANNER), np.array(kinds.shape) // SIDE
    cubes = kinds.reshape(tiles[0], SIDE, tiles[1], SIDE, tiles[2], SIDE).transpose(0, 2, 4, 1, 3, 5)
    places = np.argwhere(np.ones(tiles, bool))[:, ::-1]
    planner.update_map(voxel_m, SIDE, places, cubes.reshape(-1, SIDE**3))
    return planner


def _fill(kinds: np.ndarray, middle: tuple[float, float, float], half: np.ndarray, kind: int) -> None:
    low = np.maximum(np.floor(np.array(middle) - half), 1).astype(int)
    high = np.maximum(np.ceil(np.array(middle) + half), 1).astype(int)
    kinds[tuple(map(slice, low.tolist(), high.tolist()))] = kind
