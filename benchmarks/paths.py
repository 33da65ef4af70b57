"""Time of a plan in a hold of 30 x 20 x 10 m that is known: 40 boxes and beams, two walls with a door each.

Starts and goals are random. Times are CPU times of the thread. Keys: paths.hold.VOXEL_cm.{plans, plan_s,
plan_worst_s, refusal_worst_s, map_s, voxels}.
"""

from __future__ import annotations

import time
from typing import Sequence

import numpy as np

from benchmarks.shared.results import Results, options, table
from exploration.planning import FREE, OCCUPIED, UNKNOWN, PathPlanner
from flight_basics.errors import NoPathError
from inspection.warm_up import warm_up

SIDE = 16
LOW_M, HIGH_M = np.full(3, 0.5), np.array((30.5, 20.5, 10.5))
WALLS_X_M = (10.0, 20.0)
DOOR_M = (1.4, 2.2)
"""Width and height."""


Corner = np.ndarray | tuple[float, float, float]


def fill(kinds: np.ndarray, low_m: Corner, high_m: Corner, voxel_m: float, kind: int) -> None:
    """Set the kind of the voxels (z, y, x) in a box with corners x, y, z."""
    low, high = (np.rint(np.asarray(corner) / voxel_m).astype(int)[::-1] for corner in (low_m, high_m))
    kinds[tuple(map(slice, low.tolist(), high.tolist()))] = kind


def hold(voxel_m: float, random: np.random.Generator) -> np.ndarray:
    """Return the kinds of the voxels (d, h, w) of a hold."""
    shape = (np.ceil((HIGH_M + 1.0) / voxel_m / SIDE) * SIDE).astype(int)
    kinds = np.full(shape[::-1], UNKNOWN, np.uint8)
    fill(kinds, LOW_M - 2.0 * voxel_m, HIGH_M + 2.0 * voxel_m, voxel_m, OCCUPIED)
    fill(kinds, LOW_M, HIGH_M, voxel_m, FREE)
    for _ in range(40):
        low_m, size_m = random.uniform(LOW_M, HIGH_M - 0.5), random.uniform(0.3, 3.0, 3)
        if random.random() < 0.4:
            size_m[random.integers(3)] = 12.0
        fill(kinds, low_m, np.minimum(low_m + size_m, HIGH_M), voxel_m, OCCUPIED)
    for x_m in WALLS_X_M:
        y_m, z_m = random.uniform(2.0, 18.0), random.uniform(1.0, 7.0)
        fill(kinds, (x_m, 0.5, 0.5), (x_m + 0.2, 20.5, 10.5), voxel_m, OCCUPIED)
        fill(kinds, (x_m, y_m, z_m), (x_m + 0.2, y_m + DOOR_M[0], z_m + DOOR_M[1]), voxel_m, FREE)
    return kinds


def tiles_of(kinds: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return all tiles (n, 3) of kinds, and their voxels (n, SIDE**3)."""
    d, h, w = (size // SIDE for size in kinds.shape)
    voxels = kinds.reshape(d, SIDE, h, SIDE, w, SIDE).transpose(0, 2, 4, 1, 3, 5).reshape(-1, SIDE**3)
    return np.argwhere(np.ones((d, h, w)))[:, ::-1], voxels


def measure(voxel_m: float, count: int, seed: int = 0) -> dict[str, float]:
    """Return the numbers of one hold."""
    random = np.random.default_rng(seed)
    planner = PathPlanner()
    kinds = hold(voxel_m, random)
    start = time.thread_time()
    planner.update_map(voxel_m, SIDE, *tiles_of(kinds))
    planner.is_clear(np.full((2, 3), 5.0))  # computes the distances
    map_s = time.thread_time() - start
    plans_s, refusals_s = [], [0.0]
    for _ in range(count):
        ends = random.uniform(LOW_M + 1.0, HIGH_M - 1.0, (2, 3))
        start = time.thread_time()
        try:
            planner.plan(*ends)
            plans_s.append(time.thread_time() - start)
        except NoPathError:
            refusals_s.append(time.thread_time() - start)
    return {
        "plans": len(plans_s),
        "plan_s": float(np.median(plans_s)),
        "plan_worst_s": max(plans_s),
        "refusal_worst_s": max(refusals_s),
        "map_s": map_s,
        "voxels": kinds.size,
    }


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, print and write."""
    parser = options(__doc__)
    parser.add_argument("--plans", type=int, default=100, metavar="NUMBER", help="that are asked for")
    given = parser.parse_args(arguments)
    with Results("paths", given.results, vars(given)) as results:
        warm_up()
        rows = []
        for voxel_cm in (20, 10):
            numbers = measure(voxel_cm / 100.0, 10 if given.brief else given.plans)
            results.add(f"paths.hold.{voxel_cm}_cm", numbers)
            rows.append((f"{voxel_cm} cm", *(round(value, 3) for value in numbers.values())))
        print(table(("voxels", *numbers), rows))


if __name__ == "__main__":
    main()
