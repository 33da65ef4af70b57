"""Flights in three dimensions among boxes, of a UAV that follows exactly as the response model says."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from cepa import Cloud, Decision, Dynamic, LaserScan2D, Motion, Ranging
from cepa.dynamic.kernels.response import fly
from cepa.dynamic.observer import response_of

RANGE_MIN_M, RANGE_MAX_M = 0.5, 30.0
CHANNELS_RAD = np.radians(np.arange(-15.0, 15.1, 2.0))
"""Of a Puck."""
PERIOD_S, STEP_S = 0.1, 0.001
CLIMB_ERROR_M_S2 = 0.2
"""The vertical disturbance that doc/three_dimensions.md allows."""
HEIGHT_M = 2.0
LEVEL = (0.0, 0.0, 0.0, 1.0)
NO_SCAN = LaserScan2D(np.full(4, math.inf), -math.pi, 0.5 * math.pi, RANGE_MIN_M, RANGE_MAX_M)

_azimuth, _elevation = np.meshgrid(np.radians(np.arange(0.0, 360.0, 1.0)), CHANNELS_RAD)
DIRECTIONS = np.stack(
    [
        np.cos(_elevation) * np.cos(_azimuth),
        np.cos(_elevation) * np.sin(_azimuth),
        np.sin(_elevation),
    ],
    axis=-1,
).reshape(-1, 3)


@dataclass(frozen=True)
class Boxes:
    """Boxes (n, 2, 3), each with its least and its greatest corner, m, over a floor at z = 0."""

    corners: np.ndarray

    def cloud(self, position: np.ndarray) -> Cloud:
        """Return what a level Puck sees."""
        ranges = self.ranges(position, DIRECTIONS)
        met = (ranges > RANGE_MIN_M) & (ranges < RANGE_MAX_M)
        points = DIRECTIONS[met] * ranges[met, None]
        return Cloud(points, (CHANNELS_RAD[0], CHANNELS_RAD[-1]), RANGE_MIN_M, RANGE_MAX_M)

    def at(self, t_s: float, position: np.ndarray) -> Boxes:
        """Return the boxes that are there when a UAV is at ``position``."""
        return self

    def senses(self, position: np.ndarray) -> tuple[LaserScan2D, Cloud | None]:
        """Return the planar scan and the cloud that come at one instant."""
        return NO_SCAN, self.cloud(position)

    def ranges(self, position: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """Return how far beams along unit vectors (n, 3) go, m; inf where they meet nothing."""
        with np.errstate(divide="ignore", invalid="ignore"):
            ranges = np.where(directions[:, 2] < 0.0, -position[2] / directions[:, 2], math.inf)
            for low, high in self.corners:
                one, other = (low - position) / directions, (high - position) / directions
                enters, leaves = np.minimum(one, other).max(axis=1), np.maximum(one, other).min(axis=1)
                ranges = np.minimum(ranges, np.where((enters < leaves) & (enters > 0.0), enters, math.inf))
        return ranges

    def clearance(self, position: np.ndarray, radius: float, below: float, above: float) -> float:
        """Return how far, m, a cylinder is from the boxes; 0 where it touches one."""
        least = position[2] - below
        for low, high in self.corners:
            aside = np.maximum(0.0, np.maximum(low[:2] - position[:2], position[:2] - high[:2]))
            over = max(0.0, low[2] - position[2] - above, position[2] - below - high[2])
            least = min(least, math.hypot(max(0.0, math.hypot(*aside) - radius), over))
        return least


@dataclass
class Flight:
    """What came of a flight; positions and velocities in m and m/s, one row per scan."""

    positions: list[np.ndarray] = field(default_factory=list)
    clearances_m: list[float] = field(default_factory=list)
    decisions: list[Decision] = field(default_factory=list)


def motion_at(
    stamp_s: float, position: np.ndarray, velocity=(0.0, 0.0, 0.0), climb_ref: float = 0.0
) -> Motion:
    """Return the motion of a level UAV that looks along x."""
    return Motion(stamp_s, tuple(map(float, position)), LEVEL, tuple(map(float, velocity)), climb_ref)


def fly_up(
    steering: Dynamic,
    boxes: Boxes,
    start: np.ndarray,
    goal: np.ndarray,
    sign: float,
    patience_s: float,
    begin_s: float = 0.0,
) -> Flight:
    """Fly straight up (sign 1) or down (-1) to a goal, by clouds and the range finder that looks there.

    begin_s: later than what the steering has seen before.
    """
    model = steering.parameters.response
    response = response_of(model, STEP_S)
    position, state, flight, command = start.copy(), np.zeros((3, 4)), Flight(), np.zeros(3)
    ahead = np.array([(1e-3, 0.0, sign)])
    for number in range(round(patience_s / PERIOD_S)):
        reference = np.clip(0.5 * (goal - position), -0.7, 0.7)
        motion = motion_at(begin_s + number * PERIOD_S, position, state[:, 1], float(reference[2]))
        range_m = float(boxes.ranges(position, ahead)[0])
        steering.take_ranges([Ranging((0.0, 0.0, 0.0), (0.0, 0.0, sign), range_m, 0.05, 12.0)])
        asked, own = tuple(reference[:2].tolist()), tuple(state[:2, 1].tolist())
        decision = steering.steer(NO_SCAN, asked, own, motion, boxes.cloud(position))
        flight.decisions.append(decision)
        late, command = command, np.array([*decision.velocity_xy, decision.climb_m_s])
        state[:, 0] = 0.0
        commands = np.array([[0.0, 9.0, *late], [model.delay_s, 9.0, *command]])
        fly(state, commands, 0, 2, 0.0, PERIOD_S, response)
        position = position + state[:, 0]
        flight.positions.append(position)
        flight.clearances_m.append(boxes.clearance(position, 0.35, 0.3, 0.15))
        if sign * (goal[2] - position[2]) < 0.3:
            break
    return flight


def fly_along_x(
    steering: Dynamic,
    boxes: Boxes,
    speed: float,
    distance_m: float,
    patience_s: float,
    pushed_up_m_s2: float = 0.0,
) -> Flight:
    """Fly along x at HEIGHT_M, after a climb from the floor, until ``distance_m`` or out of patience.

    pushed_up_m_s2: an acceleration that disturbs the UAV all the time.
    """
    model = steering.parameters.response
    response = response_of(model, STEP_S)
    position, state, flight = np.array([0.0, 0.0, 0.4]), np.zeros((3, 4)), Flight()
    command = np.zeros(3)
    for number in range(round(patience_s / PERIOD_S)):
        climb_ref = float(np.clip(HEIGHT_M - position[2], -1.0, 1.0))
        rises = number * PERIOD_S < 3.0
        reference = (0.0, 0.0) if rises else (speed, 0.0)
        motion = motion_at(number * PERIOD_S, position, state[:, 1], climb_ref)
        boxes = boxes.at(number * PERIOD_S, position)
        scan, cloud = boxes.senses(position)
        decision = steering.steer(scan, reference, tuple(state[:2, 1]), motion, cloud)
        flight.decisions.append(decision)
        late, command = command, np.array([*decision.velocity_xy, climb_ref if rises else decision.climb_m_s])
        state[:, 0] = 0.0
        commands = np.array([[0.0, 9.0, *late], [model.delay_s, 9.0, *command]])
        for step in range(5):
            begin = 0.2 * step * PERIOD_S
            fly(state, commands, 0, 2, begin, begin + 0.2 * PERIOD_S, response)
            state[2, 1] += 0.2 * PERIOD_S * pushed_up_m_s2
            body = position + state[:, 0]
            flight.clearances_m.append(boxes.clearance(body, 0.3, 0.25, 0.1))
        position = position + state[:, 0]
        flight.positions.append(position)
        if position[0] > distance_m:
            break
    return flight
