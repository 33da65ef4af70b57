"""A simulated plane for tests: straight walls, a lidar by ray casting, a route, odometry that drifts."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gridslam import se2
from gridslam.evaluation import Walls
from gridslam.scan import PlanarScan
from gridslam.trajectory import Trajectory


@dataclass(frozen=True)
class Lidar:
    """Beams evenly spread over a field of view, with Gaussian noise."""

    fov_rad: float
    beams: int
    range_m: float
    noise_m: float
    rate_hz: float

    @property
    def angles_rad(self) -> np.ndarray:
        return np.linspace(-self.fov_rad / 2, self.fov_rad / 2, self.beams)


URG = Lidar(math.radians(240.0), 342, 5.6, 0.01, 10.0)  # every second beam, to be quick
UST = Lidar(math.radians(270.0), 271, 10.0, 0.013, 10.0)


@dataclass(frozen=True)
class Drift:
    """Odometry's error: systematic in scale and heading, and noise that grows with way and turning."""

    scale: float = 0.01
    heading_rad_per_m: float = 0.002
    position_m_per_sqrt_m: float = 0.02
    heading_rad_per_sqrt_m: float = 0.01
    heading_rad_per_sqrt_rad: float = 0.02


@dataclass(frozen=True)
class Log:
    """What a run leaves: scans, odometry (k, 3) at each, and the truth."""

    scans: list
    odometry: np.ndarray
    truth: Trajectory


def hold(beams: bool = True) -> Walls:
    """The cargo hold: 30 x 20 m about the origin, beams 1 m wide and 0.5 m deep every 3 m on all sides."""
    sides = [(30.0, 10.0, -math.pi / 2), (20.0, 15.0, 0.0), (30.0, 10.0, math.pi / 2), (20.0, 15.0, math.pi)]
    corners = []
    for length, reach, yaw in sides:
        count = int((length - 1.0) / 3.0) + 1 if beams else 0
        side = [(0.0, -length / 2)]
        for middle in (np.arange(count) - (count - 1) / 2) * 3.0:
            side += [(0.0, middle - 0.5), (-0.5, middle - 0.5), (-0.5, middle + 0.5), (0.0, middle + 0.5)]
        corners.append(se2.transform((reach * math.cos(yaw), reach * math.sin(yaw), yaw), np.array(side)))
    return Walls.from_polygons([np.concatenate(corners)])


def scattered_boxes(seed: int, route: np.ndarray) -> Walls:
    """A hall of 34 x 24 m with boxes of different sizes and headings beside a route."""
    rng = np.random.default_rng(seed)
    polygons = [np.array([(-17.0, -12.0), (17.0, -12.0), (17.0, 12.0), (-17.0, 12.0)])]
    while len(polygons) < 60:
        middle, half, yaw = rng.uniform((-16, -11), (16, 11)), rng.uniform(0.3, 1.0, 2), rng.uniform(0.0, 3.0)
        if np.hypot(*(route[:, :2] - middle).T).min() > 1.6:
            corners = half * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
            polygons.append(se2.transform((*middle, yaw), corners))
    return Walls.from_polygons(polygons)


def rectangle_route(half_x: float, half_y: float, start: float = 0.0, laps: float = 1.0) -> np.ndarray:
    """Corners of a route round a rectangle, counter-clockwise, from a share `start` of the lower side on."""
    corners = np.array([(half_x, -half_y), (half_x, half_y), (-half_x, half_y), (-half_x, -half_y)])
    first = np.array([[-half_x + start * 2.0 * half_x, -half_y]])
    whole = np.concatenate([first] + [np.concatenate([corners, first])] * math.ceil(laps))
    return whole if laps == math.ceil(laps) else whole[: 1 + round(laps * 5)]


def along(route_xy: np.ndarray, step_m: float, turn_rad: float = 0.3) -> np.ndarray:
    """Poses (k, 3) along a route, heading forward, turning on the spot at its corners."""
    poses = []
    heading = math.atan2(*(route_xy[1] - route_xy[0])[::-1])
    for a, b in zip(route_xy[:-1], route_xy[1:]):
        new = math.atan2(b[1] - a[1], b[0] - a[0])
        turn = math.remainder(new - heading, 2.0 * math.pi)
        for part in range(1, math.ceil(abs(turn) / turn_rad) + 1):
            poses.append((*a, heading + turn * part / math.ceil(abs(turn) / turn_rad)))
        heading = new
        count = max(1, round(float(np.hypot(*(b - a))) / step_m))
        poses += [(*(a + (b - a) * i / count), heading) for i in range(count)]
    poses.append((*route_xy[-1], heading))
    return np.array(poses)


def drive(
    walls: Walls, truth: np.ndarray, lidar: Lidar, seed: int, drift: Drift = Drift(), seconds: float = 0.5
) -> Log:
    """Scan from each true pose (k, 3); the odometry starts at the true pose and drifts from there."""
    rng = np.random.default_rng(seed)
    stamps = np.arange(len(truth)) * seconds
    scans = [scan_at(walls, pose, lidar, rng, stamp) for pose, stamp in zip(truth, stamps)]
    return Log(scans, drifting(truth, drift, rng), Trajectory(stamps, truth))


def scan_at(walls: Walls, pose, lidar: Lidar, rng: np.random.Generator, stamp_s: float = 0.0) -> PlanarScan:
    """What the lidar, in the middle of the base, sees from a pose."""
    ranges = cast(walls.ends_m, pose[:2], pose[2] + lidar.angles_rad)
    seen = ranges <= lidar.range_m
    noisy = np.maximum(ranges + lidar.noise_m * rng.standard_normal(len(ranges)), 0.02)
    return PlanarScan(
        stamp_s, lidar.angles_rad, np.where(seen, noisy, np.inf), (0.0, 0.0, 0.0), lidar.range_m
    )


def cast(ends_m: np.ndarray, origin_xy, bearings_rad: np.ndarray) -> np.ndarray:
    """Distance along each bearing to the nearest wall; inf where there is none."""
    direction = np.stack([np.cos(bearings_rad), np.sin(bearings_rad)], axis=1)[:, None, :]
    start = (ends_m[:, :2] - np.asarray(origin_xy))[None]
    side = (ends_m[:, 2:] - ends_m[:, :2])[None]
    with np.errstate(divide="ignore", invalid="ignore"):
        denominator = _cross(direction, side)
        distance = _cross(start, side) / denominator
        part = _cross(start, direction) / denominator
        hit = (distance > 0.0) & (part >= 0.0) & (part <= 1.0)
    return np.where(hit, distance, np.inf).min(axis=1)


def _cross(a, b):
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def drifting(truth: np.ndarray, drift: Drift, rng: np.random.Generator) -> np.ndarray:
    """Odometry (k, 3) of a true path (k, 3)."""
    steps = se2.between(truth[:-1], truth[1:])
    way, turned = np.hypot(steps[:, 0], steps[:, 1]), np.abs(steps[:, 2])
    noise = rng.standard_normal((len(steps), 3))
    variance = drift.heading_rad_per_sqrt_m**2 * way + drift.heading_rad_per_sqrt_rad**2 * turned
    measured = np.column_stack(
        [
            (1.0 + drift.scale) * steps[:, :2]
            + drift.position_m_per_sqrt_m * np.sqrt(way)[:, None] * noise[:, :2],
            steps[:, 2] + drift.heading_rad_per_m * way + np.sqrt(variance) * noise[:, 2],
        ]
    )
    poses = [truth[0]]
    for step in measured:
        poses.append(se2.compose(poses[-1], step))
    return np.array(poses)
