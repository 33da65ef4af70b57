"""Boxes that the UAV stays out of, and their walls near it, which count as obstacles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Sequence

import numpy as np

from cepa.errors import ParameterError
from cepa.kernels.walls import walls_near
from flight_limits import KeepOutBox, Limits, LimitsError, parse_limits

WALL_REACH_M = 8.0
"""m: Walls count so far from the UAV; the distance field reaches as far."""
WALL_UP_M = 1.8
"""m: And so far above and below it, as the layers of heights do."""
WALL_STEP_M = 0.15
"""m: Points of a wall are so far apart, closer than any gap that the UAV fits through."""
REACH_M = np.array([WALL_REACH_M, WALL_REACH_M, WALL_UP_M])


@dataclass(frozen=True, eq=False)
class MapPose:
    """The pose of the odometry's frame in the map: rotation (3, 3), and translation (3,), m."""

    rotation: np.ndarray
    translation_m: np.ndarray


SAME_FRAME = MapPose(np.eye(3), np.zeros(3))


class KeepOut:
    """Keep-out boxes as a UAV meets them in the odometry's frame.

    map_pose changes when SLAM corrects the odometry; set it at any time.
    """

    def __init__(self, boxes: Sequence[KeepOutBox] = (), map_pose: MapPose = SAME_FRAME) -> None:
        self.boxes, self.map_pose = tuple(boxes), map_pose

    def walls(self, position_m: Sequence[float]) -> np.ndarray:
        """Return points of the walls (n, 3), m, along the odometry's axes, from a place in its frame."""
        if not self.boxes:
            return np.empty((0, 3))
        rotation, position = self.map_pose.rotation, np.array(position_m)
        place = rotation @ position + self.map_pose.translation_m
        walls = np.concatenate([walls_of(box, place) for box in self.boxes])
        return (walls - place) @ rotation


def limits_of(given: object) -> Limits:
    """Return the limits of a mapping, as the ROS parameter ~limits is one: the file of path_planner.

    Raises:
        ParameterError: it makes no sense.
    """
    try:
        return parse_limits(given)
    except LimitsError as error:
        raise ParameterError(f"limits: {error}") from None


def walls_of(box: KeepOutBox, place_m: np.ndarray) -> np.ndarray:
    """Return points (n, 3), m, of a box's faces near a place (3,), all in the map's frame.

    A UAV that is in the box may leave it, so there are none then.
    """
    low, high = np.array(box.low_m, float), np.array(box.high_m, float)
    if np.all((low < place_m) & (place_m < high)):
        return np.empty((0, 3))
    return walls_near(low, high, place_m, REACH_M, WALL_STEP_M)


def at_heights(walls: np.ndarray, low_m: float, high_m: float) -> np.ndarray:
    """Return those of ``walls`` (n, 3), m, that are at heights from ``low_m`` to ``high_m``, in their order.

    Of points that follow each other at the same place in the plan only the first is among them.
    """
    heights_m = walls[:, 2]
    found: np.ndarray = walls[(low_m <= heights_m) & (heights_m <= high_m)]
    if not len(found):
        return found
    x, y = found[:, 0], found[:, 1]
    return found[np.append(True, (x[1:] != x[:-1]) | (y[1:] != y[:-1]))]
