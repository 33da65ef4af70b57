"""A small robot in rooms of a few metres: a lidar of 5.6 m, turns of 186 degrees/s, gaps of 5 s."""

from __future__ import annotations

import math

import numpy as np
from planar_world import URG, Drift, Lidar, Log, cast, drifting

from gridslam import se2
from gridslam.evaluation import Walls
from gridslam.inputs.scan_projection import project
from gridslam.scan import PlanarScan
from gridslam.trajectory import Trajectory

SPEED_M_S, TURN_RAD_S, PERIOD_S, SWEEP_S = 0.35, math.radians(186.0), 0.1, 0.067
"""A scan is taken within SWEEP_S, beam after beam, while the robot turns."""
GAP_S, GAP_EVERY_S = 5.0, 35.0
UPRIGHT = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
WHEELS = Drift(0.02, 0.01, 0.02, 0.02, 0.05)


def rooms(seed: int) -> tuple[Walls, np.ndarray]:
    """Return two rows of rooms at a corridor of 1.1 m, with furniture, and a route (k, 2) through all."""
    rng = np.random.default_rng(seed)
    wide, deep, corridor = rng.uniform(2.2, 3.4, 3), rng.uniform(2.2, 3.2, 2), 1.1
    ends, route, x = [], [(0.5, 0.0)], 0.0
    for width in wide.tolist():
        middle = x + width * rng.uniform(0.35, 0.65)
        for side, depth in zip((1.0, -1.0), deep):
            near, far = side * corridor / 2, side * (corridor / 2 + depth)
            ends += [(x, near, middle - 0.4, near), (middle + 0.4, near, x + width, near)]
            ends += [(x, near, x, far), (x + width, near, x + width, far), (x, far, x + width, far)]
            box = np.array(
                (x + rng.choice((0.3, width - 0.3)), side * (corridor / 2 + depth * rng.uniform(0.6, 0.9)))
            )
            half = rng.uniform(0.1, 0.25, 2)
            corners = box + half * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
            ends += [(*corners[i], *corners[(i + 1) % 4]) for i in range(4)]
            inside = (middle, side * (corridor / 2 + 0.5 * depth))
            route += [(middle, 0.0), inside, (middle, 0.0)]
        x += width
    ends += [(0.0, -corridor / 2, 0.0, corridor / 2), (x, -corridor / 2, x, corridor / 2)]
    way = np.array(route)
    return Walls(np.array(ends, float)), np.vstack([way, way[::-1][1:]])


def motion(route: np.ndarray) -> np.ndarray:
    """Return poses (k, 3), one every PERIOD_S: straight at SPEED_M_S, turns on the spot at TURN_RAD_S."""
    poses, heading = [], math.atan2(*(route[1] - route[0])[::-1])
    for a, b in zip(route[:-1], route[1:]):
        length = math.dist(a, b)
        if length < 1e-6:
            continue
        new = math.atan2(b[1] - a[1], b[0] - a[0])
        turn = math.remainder(new - heading, 2.0 * math.pi)
        count = math.ceil(abs(turn) / (TURN_RAD_S * PERIOD_S))
        poses += [(*a, heading + turn * part / count) for part in range(1, count + 1)]
        heading, count = new, math.ceil(length / (SPEED_M_S * PERIOD_S))
        poses += [(*(a + (b - a) * part / count), heading) for part in range(count)]
    return np.array(poses)


def small_robot(
    seed: int, lidar: Lidar = URG, tells_time: bool = True, gap: tuple[float, float] = (GAP_S, GAP_EVERY_S)
) -> tuple[Log, Walls]:
    """Return a seed's drive: scans that turns have skewed, with gaps, and the walls.

    tells_time: the driver tells `time_increment`, so that odometry's motion straightens the scans.
    gap: s of each so many s, the last of them, are without scans.
    """
    walls, route = rooms(seed)
    truth, rng = motion(route), np.random.default_rng((seed, 1))
    odometry, spins = drifting(truth, WHEELS, rng), np.append(np.diff(truth[:, 2]), 0.0)
    part = np.linspace(0.0, SWEEP_S / PERIOD_S, lidar.beams)
    scans, kept = [], []
    for index, (pose, spin) in enumerate(zip(truth, spins)):
        if index * PERIOD_S % gap[1] > gap[1] - gap[0]:
            continue
        turned = se2.wrap(spin) * part
        ranges = cast(walls.ends_m, pose[:2], pose[2] + turned + lidar.angles_rad)
        noisy = np.maximum(ranges + lidar.noise_m * rng.standard_normal(len(ranges)), 0.02)
        seen = np.where(ranges <= lidar.range_m, noisy, np.inf)
        scans.append(_told(index, seen, lidar, odometry, tells_time))
        kept.append(index)
    return Log(scans, odometry[kept], Trajectory(PERIOD_S * np.array(kept), truth[kept])), walls


def _told(
    index: int, ranges_m: np.ndarray, lidar: Lidar, odometry: np.ndarray, tells_time: bool
) -> PlanarScan:
    """Return the scan as SLAM gets it. Within a scan the robot only turns here."""
    moved, last = None, min(index + 1, len(odometry) - 1)
    if tells_time:
        moved = (0.0, 0.0, SWEEP_S / PERIOD_S * float(se2.between(odometry[index], odometry[last])[2]))
    first_rad, step_rad = float(lidar.angles_rad[0]), lidar.fov_rad / (lidar.beams - 1)
    limits_m, stamp_s = (0.01, lidar.range_m), index * PERIOD_S
    return project(ranges_m, first_rad, step_rad, *limits_m, UPRIGHT, stamp_s=stamp_s, moved=moved)
