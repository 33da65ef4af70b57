"""Flights of a UAV with a planar lidar and range finders beside a box that moves, among walls."""

from __future__ import annotations

import math
from typing import Callable, NamedTuple

import numpy as np
from spatial_flight import LEVEL, STEP_S, Boxes

from cepa import Dynamic, LaserScan2D, Motion, Ranging
from cepa.dynamic.kernels.response import fly
from cepa.dynamic.observer import response_of
from cepa.motion import Cloud

PERIOD_S = 0.1
BEAMS = 360
ANGLES = -math.pi + np.arange(BEAMS) * 2.0 * math.pi / BEAMS
AROUND = np.stack([np.cos(ANGLES), np.sin(ANGLES), np.zeros(BEAMS)], axis=1)
UP, DOWN = (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)
NO_WALLS = np.empty((0, 2, 3))

Box = tuple[tuple[float, float, float], tuple[float, float, float]]


class Beside(NamedTuple):
    """How near the UAV came, m."""

    box_m: float
    walls_m: float
    lowest_m: float


def fly_beside(
    box_at: Callable[[float], Box],
    reference_of: Callable[[np.ndarray], tuple[float, float]],
    until_s: float,
    place_m: tuple[float, float, float],
    speed: float = 0.0,
    has_puck: bool = False,
    walls: np.ndarray = NO_WALLS,
) -> Beside:
    """Fly a UAV that follows exactly as the response model says.

    box_at: least and greatest corner of what moves, at a time. reference_of: v_ref at the UAV's place. speed:
    along x at first. has_puck: clouds come, too, of channels up to 15 degrees. walls: boxes (n, 2, 3).
    """
    steering, position, state = Dynamic(), np.array(place_m), np.zeros((3, 4))
    model, stands = steering.parameters.response, Boxes(walls)
    command = np.array([speed, 0.0, 0.0])
    state[0, 1] = speed
    response, nearest = response_of(model, STEP_S), Beside(math.inf, math.inf, place_m[2])
    for number in range(round(until_s / PERIOD_S)):
        box = Boxes(np.array([box_at(number * PERIOD_S)]))
        seen = Boxes(np.concatenate((walls, box.corners)))
        ranges = seen.ranges(position, AROUND)
        ranges = np.where(ranges <= 10.0, ranges, math.inf)
        scan = LaserScan2D(ranges, -math.pi, 2 * math.pi / BEAMS, 0.06, 10.0)
        rangings = [(way, float(seen.ranges(position, np.array([way]) + 1e-9)[0])) for way in (UP, DOWN)]
        steering.take_ranges([Ranging((0.0, 0.0, 0.0), way, up_m, 0.05, 40.0) for way, up_m in rangings])
        climb_ref = float(np.clip(place_m[2] - position[2], -1.0, 1.0))
        motion = Motion(number * PERIOD_S, tuple(position), LEVEL, tuple(state[:, 1]), climb_ref)
        cloud = cloud_of_puck(seen, position) if has_puck else None
        decision = steering.steer(scan, reference_of(position), tuple(state[:2, 1]), motion, cloud)
        late, command = command, np.array([*decision.velocity_xy, decision.climb_m_s or 0.0])
        state[:, 0] = 0.0
        commands = np.array([[0.0, 9.0, *late], [model.delay_s, 9.0, *command]])
        fly(state, commands, 0, 2, 0.0, PERIOD_S, response)
        position = position + state[:, 0]
        apart_m = (boxes.clearance(position, 0.35, 0.25, 0.1) for boxes in (box, stands))
        nearest = Beside(*np.minimum(nearest, (*apart_m, position[2])).tolist())
    return nearest


def cloud_of_puck(boxes: Boxes, position: np.ndarray) -> Cloud:
    """Return the cloud of 16 channels, 2 degrees apart, that meet boxes."""
    elevations = np.repeat(np.radians(np.arange(-15.0, 16.0, 2.0)), 180)
    angles = np.tile(np.radians(np.arange(0.0, 360.0, 2.0)), 16)
    level = np.cos(elevations)
    directions = np.stack([level * np.cos(angles), level * np.sin(angles), np.sin(elevations)], axis=1)
    ranges = boxes.ranges(position, directions)
    hit = ranges < 50.0
    limits_rad = math.radians(-15.0), math.radians(15.0)
    return Cloud(ranges[hit, None] * directions[hit], limits_rad, 0.4, 100.0)
