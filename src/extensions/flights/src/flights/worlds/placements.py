"""The obstacles of Experiment 2 (thesis, figures 8.3 to 8.7) around the UAV.

Positions are in the UAV's frame at the instant of the freeze, levelled: x forward, y left, metres; its origin
is on the floor below the UAV. Every obstacle lies within the 270 degrees that the UST-10LX sees. Every
obstacle reaches into the circle of `R_LB_M`, except the outer two of the three columns.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Sequence

import numpy as np

from flights.worlds.scenario import choose
from flights.worlds.writer import Box, Colour, Cylinder, Part, Prop, write_model
from simulation_tools.geometry import Pose
from simulation_tools.sdf.elements import Model
from simulation_tools.sdf.parser import parse_model

R_LB_M = 0.8
"""The experiment's r_LB.

In the thesis's figures the obstacles reach deep into the circle. CEPA's default circle of 0.5 m has no room
for this, because the UAV itself takes 0.38 m of it.
"""

HEIGHT_M = 2.4
VARIATION_M = 0.05
_COLUMN, _WALL = Colour(0.85, 0.52, 0.30, 0.35), Colour(0.80, 0.82, 0.84, 0.35)


@dataclass(frozen=True)
class Obstacle:
    """A column (`Cylinder`) or a wall (`Box`) and the place of its middle."""

    name: str
    shape: Box | Cylinder
    x_m: float
    y_m: float

    @property
    def sdf(self) -> str:
        """The text of its model file."""
        colour = _WALL if isinstance(self.shape, Box) else _COLUMN
        return write_model(Prop(self.name, 0.0, 0.0, (Part("body", self.shape, colour),)))

    def model(self, frame: Pose | None = None) -> Model:
        """Return its model. frame: pose of the UAV's frame at the freeze, in the model's coordinates."""
        return replace(parse_model(self.sdf, self.name, ()), pose=self.pose(frame))

    def pose(self, frame: Pose | None = None) -> Pose:
        """Return its pose. frame: as in `model`."""
        return (frame or Pose.identity()) @ Pose((self.x_m, self.y_m, 0.0))


def placement(scenario: str) -> tuple[Obstacle, ...]:
    """Return the obstacles of a scenario.

    columns: four around the UAV. Those behind are nearer, so that together they push it ahead, where there
    is room. wall_one_column: a wall to the left, a column ahead to the right. wall_three_columns: a wall to
    the left and three columns to the right. The UAV does not fit between these; ahead and behind there is
    room.

    Raises:
        ScenarioError: there is none of this name.
    """
    return _PLACEMENTS[choose("scenario", scenario, tuple(_PLACEMENTS))]


def varied(obstacles: Sequence[Obstacle], rng: np.random.Generator) -> tuple[Obstacle, ...]:
    """Return the obstacles, each shifted by up to `VARIATION_M` along x and y."""
    shifts = rng.uniform(-VARIATION_M, VARIATION_M, (len(obstacles), 2)).tolist()
    return tuple(
        replace(obstacle, x_m=obstacle.x_m + dx, y_m=obstacle.y_m + dy)
        for obstacle, (dx, dy) in zip(obstacles, shifts)
    )


def freeze_frame(pose: Pose) -> Pose:
    """Return the UAV's frame in which obstacles are placed: below it on the floor, turned by its yaw."""
    x_m, y_m, _ = pose.position_m
    return Pose.from_xyz_rpy(x_m, y_m, 0.0, yaw=pose.yaw_rad)


def _column(name: str, radius_m: float, x_m: float, y_m: float) -> Obstacle:
    return Obstacle(name, Cylinder(radius_m, HEIGHT_M), x_m, y_m)


def _around(name: str, distance_m: float, bearing_deg: float) -> Obstacle:
    """A column of 20 cm. distance_m: of its surface; bearing_deg: to the left of straight ahead."""
    radius_m, bearing = 0.1, math.radians(bearing_deg)
    middle_m = distance_m + radius_m
    return _column(name, radius_m, middle_m * math.cos(bearing), middle_m * math.sin(bearing))


def _wall_on_the_left(distance_m: float) -> Obstacle:
    thickness_m = 0.1
    return Obstacle("wall", Box(4.0, thickness_m, HEIGHT_M), 0.0, distance_m + thickness_m / 2)


_PLACEMENTS = {
    "columns": (
        _around("column_front_left", 0.65, 52.0),
        _around("column_front_right", 0.65, -52.0),
        _around("column_rear_left", 0.52, 120.0),
        _around("column_rear_right", 0.52, -120.0),
    ),
    "wall_one_column": (_wall_on_the_left(0.55), _column("column", 0.1, 0.45, -0.55)),
    "wall_three_columns": (
        _wall_on_the_left(0.5),
        _column("column_front", 0.1, 0.6, -0.7),
        _column("column_middle", 0.1, 0.0, -0.7),
        _column("column_rear", 0.1, -0.6, -0.7),
    ),
}

SCENARIOS = tuple(_PLACEMENTS)
