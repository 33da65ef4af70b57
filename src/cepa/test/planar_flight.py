"""A quick closed loop for tests and tuning: planar UAV with PX4's lag, an analytic lidar, CEPA in between.

Not the simulator (that is simulation_tools): no tilt, no height, exact geometry.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from cepa import LaserScan2D, Motion

STEP_S = 0.004
SCAN_EVERY = 6  # steps: 24 ms, as near to 40 Hz as the step allows
DELAY_STEPS = 3
BODY_RADIUS_M = 0.35


@dataclass(frozen=True)
class Scene:
    """Circles (n, 3): x, y, radius; walls (m, 4): x1, y1, x2, y2. Metres."""

    circles: np.ndarray = field(default_factory=lambda: np.empty((0, 3)))
    walls: np.ndarray = field(default_factory=lambda: np.empty((0, 4)))

    def ranges(self, position, directions, circles_within_m=math.inf) -> np.ndarray:
        """Cast rays from ``position`` (2,) along unit ``directions`` (n, 2); inf where nothing is hit.

        circles_within_m: circles that are farther away are not looked for.
        """
        circles = self.circles - (*position, 0.0)
        circles = circles[np.hypot(circles[:, 0], circles[:, 1]) - circles[:, 2] < circles_within_m]
        return np.minimum(self._to_circles(circles, directions), self._to_walls(position, directions))

    def _to_circles(self, circles, directions):
        ranges = np.full(len(directions), np.inf)
        for x, y, radius in circles:
            along = directions @ (x, y)
            inside = along**2 - (x**2 + y**2 - radius**2)
            (hit,) = np.nonzero((inside >= 0.0) & (along > 0.0))
            ranges[hit] = np.minimum(ranges[hit], along[hit] - np.sqrt(inside[hit]))
        return ranges

    def _to_walls(self, position, directions):
        if not len(self.walls):
            return np.full(len(directions), np.inf)
        start = self.walls[:, :2] - position
        edge = self.walls[:, 2:] - self.walls[:, :2]
        across = directions[:, :1] * edge[:, 1] - directions[:, 1:] * edge[:, 0]
        with np.errstate(all="ignore"):
            distance = (start[:, 0] * edge[:, 1] - start[:, 1] * edge[:, 0]) / across
            share = (start[:, 0] * directions[:, 1:] - start[:, 1] * directions[:, :1]) / across
            hit = (distance > 0.0) & (share >= 0.0) & (share <= 1.0)
            return np.where(hit, distance, np.inf).min(axis=1)

    def clearance(self, position) -> float:
        """Distance from ``position`` to the nearest surface, m."""
        best = math.inf
        if len(self.circles):
            gaps = np.hypot(*(self.circles[:, :2] - position).T) - self.circles[:, 2]
            best = min(best, gaps.min())
        if len(self.walls):
            edge = self.walls[:, 2:] - self.walls[:, :2]
            share = np.sum((position - self.walls[:, :2]) * edge, axis=1) / np.sum(edge**2, axis=1)
            nearest = self.walls[:, :2] + np.clip(share, 0.0, 1.0)[:, None] * edge
            best = min(best, np.hypot(*(nearest - position).T).min())
        return float(best)


@dataclass(frozen=True)
class Lidar:
    """A UST-10LX, padded to a full turn."""

    field_of_view: float = math.radians(270.0)
    increment: float = math.radians(0.25)
    range_min: float = 0.06
    range_max: float = 10.0
    sigma: float = 0.04 / 3.0

    def scan(self, scene: Scene, position, yaw: float, rng) -> LaserScan2D:
        beams = round(self.field_of_view / self.increment)
        angle_min = -0.5 * self.field_of_view
        angles = angle_min + np.arange(beams) * self.increment + yaw
        directions = np.stack([np.cos(angles), np.sin(angles)], axis=1)
        ranges = scene.ranges(position, directions, self.range_max + 20.0 * self.sigma)
        ranges = ranges + rng.normal(0.0, self.sigma, beams)
        ranges[ranges > self.range_max] = np.inf
        ranges[ranges < self.range_min] = -np.inf
        return LaserScan2D(ranges, angle_min, self.increment, self.range_min, self.range_max)


class Uav:
    """Planar position, velocity and yaw behind PX4's velocity law and an attitude lag."""

    ATTITUDE_LAG_S = 0.16

    def __init__(self, position=(0.0, 0.0), yaw: float = 0.0, velocity=(0.0, 0.0)):
        self.x, self.y = position
        self.vx, self.vy = velocity
        self.ax = self.ay = self.ix = self.iy = 0.0
        self.yaw = yaw

    def step(self, target, yaw_rate: float) -> None:
        """Advance one step towards the velocity ``target`` (world, m/s)."""
        self.ax, self.ix = self._accelerate(target[0] - self.vx, self.ax, self.ix)
        self.ay, self.iy = self._accelerate(target[1] - self.vy, self.ay, self.iy)
        self.vx += self.ax * STEP_S
        self.vy += self.ay * STEP_S
        self.x += self.vx * STEP_S
        self.y += self.vy * STEP_S
        self.yaw = math.remainder(self.yaw + yaw_rate * STEP_S, 2.0 * math.pi)

    def _accelerate(self, error, acceleration, integral):
        integral += error * STEP_S
        wanted = 1.8 * error + 0.4 * integral - 0.2 * acceleration
        wanted = min(max(wanted, -9.81), 9.81)
        return acceleration + (wanted - acceleration) * STEP_S / self.ATTITUDE_LAG_S, integral


@dataclass
class Flight:
    """What happened."""

    reached: bool = False
    time_s: float = 0.0
    clearance_m: float = math.inf
    path: list = field(default_factory=list)
    commands: list = field(default_factory=list)  # world frame, one per scan
    decisions: list = field(default_factory=list)

    @property
    def contact(self) -> bool:
        return self.clearance_m < BODY_RADIUS_M


def to_goal(goal, speed: float = 2.0, tolerance: float = 0.3):
    """Return a pilot: (position, velocity) -> reference velocity (world), or None at the goal."""

    def reference(position):
        dx, dy = goal[0] - position[0], goal[1] - position[1]
        distance = math.hypot(dx, dy)
        if distance < tolerance:
            return None
        wanted = min(speed, 0.9 * distance)
        return wanted * dx / distance, wanted * dy / distance

    return reference


def fly(algorithm, scene: Scene, reference, uav: Uav, rng, time_limit_s):
    """Fly until ``reference`` says None or the time is up; commands take effect 12 ms after their scan."""
    lidar, flight = Lidar(), Flight()
    command, pending, yaw_rate = (0.0, 0.0), [], 0.0
    step = 0
    while step * STEP_S < time_limit_s:
        if step % SCAN_EVERY == 0:
            v_ref = reference((uav.x, uav.y))
            if v_ref is None:
                flight.reached = True
                break
            scan = lidar.scan(scene, (uav.x, uav.y), uav.yaw, rng)
            velocities = turn(v_ref, -uav.yaw), turn((uav.vx, uav.vy), -uav.yaw)
            level = 0.0, 0.0, math.sin(0.5 * uav.yaw), math.cos(0.5 * uav.yaw)
            motion = Motion(step * STEP_S, (uav.x, uav.y, 2.0), level, (uav.vx, uav.vy, 0.0))
            decision = algorithm.steer(scan, *velocities, motion)
            towards = (
                decision.velocity_xy if math.hypot(*decision.velocity_xy) > 0.1 else turn(v_ref, -uav.yaw)
            )
            rate = min(max(1.5 * math.atan2(towards[1], towards[0]), -1.5), 1.5)
            pending.append((step + DELAY_STEPS, turn(decision.velocity_xy, uav.yaw), rate))
            flight.commands.append(pending[-1][1])
            flight.decisions.append(decision)
            flight.path.append((uav.x, uav.y))
            flight.clearance_m = min(flight.clearance_m, scene.clearance(np.array([uav.x, uav.y])))
        while pending and pending[0][0] <= step:
            _, command, yaw_rate = pending.pop(0)
        uav.step(command, yaw_rate)
        step += 1
    flight.time_s = step * STEP_S
    return flight


def turn(vector, angle: float):
    """Rotate a plane vector."""
    c, s = math.cos(angle), math.sin(angle)
    return c * vector[0] - s * vector[1], s * vector[0] + c * vector[1]


def forest(rng, length=40.0, width=16.0, spacing=3.5, clear=2.5) -> Scene:
    """Trunks of radius 0.15-0.3 m, one per jittered cell of a grid, none near the start or the goal at
    (length, 0).
    """
    trees = []
    for x in np.arange(spacing, length, spacing):
        for y in np.arange(-width / 2, width / 2 + 0.01, spacing):
            centre = np.array([x, y]) + rng.uniform(-0.3, 0.3, 2) * spacing
            if min(np.hypot(*centre), np.hypot(centre[0] - length, centre[1])) > clear:
                trees.append((*centre, rng.uniform(0.15, 0.3)))
    return Scene(circles=np.array(trees))


def box(x: float, y: float, size: float):
    """Four walls of a square around (x, y)."""
    h = size / 2.0
    corners = [(x - h, y - h), (x + h, y - h), (x + h, y + h), (x - h, y + h)]
    return [(*corners[k], *corners[(k + 1) % 4]) for k in range(4)]
