"""Pieces of pictures from above with ahead upwards and left to the left, like the thesis's Experiment 2."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Sequence

import numpy as np
from matplotlib.axes import Axes

from flights.results.palette import SOLID
from flights.results.solids import draw_solids
from flights.worlds.floor_plan import outlines
from flights.worlds.placements import Obstacle
from simulation_tools.geometry import Pose
from simulation_tools.sdf.elements import Model, World

UAV = "#9db4cf"
LABEL: dict[str, Any] = {"fontsize": 8}


def up(points_xy: np.ndarray) -> np.ndarray:
    """Turn points (..., 2) so that x (ahead) is upwards and y (left) to the left."""
    return np.stack((-points_xy[..., 1], points_xy[..., 0]), axis=-1)


def frame(axes: Axes, behind: float, ahead: float, right: float, left: float) -> None:
    """Set equal scales, these limits (m along x and y) and labels."""
    axes.set_aspect("equal")
    axes.set_xlim(-left, -right)
    axes.set_ylim(behind, ahead)
    axes.set_xlabel("to the right [m]", **LABEL)
    axes.set_ylabel("ahead [m]", **LABEL)
    axes.tick_params(labelsize=7)


def draw_obstacles(axes: Axes, obstacles: Sequence[Obstacle]) -> None:
    """Draw obstacles in the frame of their placement."""
    _draw_models(axes, tuple(obstacle.model() for obstacle in obstacles), SOLID, 1.0, 2)


def draw_uav(axes: Axes, uav: Model, pose: Pose, alpha: float = 1.0) -> None:
    """Draw the outline of a UAV."""
    _draw_models(axes, (replace(uav, pose=pose),), UAV, alpha, 3)


def _draw_models(axes: Axes, models: tuple[Model, ...], colour: str, alpha: float, order: int) -> None:
    shapes = outlines(World("from above", models=models))
    draw_solids(axes, (up(shape.outline_xy) for shape in shapes), colour, alpha=alpha, zorder=order)
