"""Boxes that the UAV stays out of, and their walls near it, which count as obstacles."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Mapping, Sequence

import numpy as np

from cepa.errors import ParameterError
from cepa.motion import Vector3

WALL_REACH_M = 8.0
"""m: Walls count so far from the UAV; the distance field reaches as far."""
WALL_UP_M = 1.8
"""m: And so far above and below it, as the layers of heights do."""
WALL_STEP_M = 0.15
"""m: Points of a wall are so far apart, closer than any gap that the UAV fits through."""
FARTHEST_M = 1e6
"""m: A box ends here at the latest."""
KEYS = ("low", "high")


@dataclass(frozen=True)
class KeepOutBox:
    """A box from ``low_m`` to ``high_m`` (x, y, z), m, in the map's frame.

    Raises ParameterError if a corner is not three numbers, or low is not below high.
    """

    low_m: Vector3
    high_m: Vector3
    name: str = ""

    def __post_init__(self) -> None:
        for corner in (self.low_m, self.high_m):
            are_numbers = all(isinstance(v, (int, float)) and not isinstance(v, bool) for v in corner)
            if len(corner) != 3 or not are_numbers or not all(abs(v) <= FARTHEST_M for v in corner):
                raise ParameterError(f"{self} has a corner {corner!r}; give three numbers: x, y, z.")
        for axis, low, high in zip("xyz", self.low_m, self.high_m):
            if not low < high:
                raise ParameterError(f"{self} has {axis} from {low:g} to {high:g} m; low must be below high.")

    def __str__(self) -> str:
        return f"The keep-out box {self.name}".rstrip()

    def walls(self, place_m: np.ndarray) -> np.ndarray:
        """Return points (n, 3), m, of its faces near a place (3,), all in the map's frame.

        A UAV that is in the box may leave it, so there are none then.
        """
        low, high = np.array(self.low_m), np.array(self.high_m)
        if np.all((low < place_m) & (place_m < high)):
            return np.empty((0, 3))
        reach = np.array([WALL_REACH_M, WALL_REACH_M, WALL_UP_M])
        near_low, near_high = np.maximum(low, place_m - reach), np.minimum(high, place_m + reach)
        if np.any(near_low > near_high):
            return np.empty((0, 3))
        sides = [_steps(*ends) for ends in zip(near_low.tolist(), near_high.tolist())]
        faces = []
        for axis in range(3):
            for end, near in ((low[axis], near_low[axis]), (high[axis], near_high[axis])):
                if end == near:
                    axes = [np.array([end]) if k == axis else sides[k] for k in range(3)]
                    faces.append(np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3))
        return np.concatenate(faces) if faces else np.empty((0, 3))


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
        walls = np.concatenate([box.walls(place) for box in self.boxes])
        return (walls - place) @ rotation


def boxes_of(limits: Any) -> tuple[KeepOutBox, ...]:
    """Return the boxes of a mapping, as the ROS parameter ~limits is one: the file of path_planner.

    keep_out: a list of boxes with low, high and perhaps a name. keep_in: a box; all around it is kept out.
    For the ceiling see `ceiling_m`.

    Raises:
        ParameterError: it makes no sense.
    """
    if not isinstance(limits, Mapping) or not set(limits) <= {"keep_out", "keep_in", "ceiling"}:
        raise ParameterError(f"limits must hold keep_out, keep_in and ceiling, not {limits!r}.")
    listed = limits.get("keep_out") or []
    if not isinstance(listed, list):
        raise ParameterError("keep_out is no list; give a list of boxes with low and high.")
    boxes = [_box(given, str(number)) for number, given in enumerate(listed, start=1)]
    if "keep_in" in limits:
        boxes += _around(_box(limits["keep_in"], "keep_in"))
    return tuple(boxes)


def ceiling_m(limits: Any) -> float:
    """Return the greatest height that such a mapping allows, m; inf: any. Raises ParameterError."""
    ceiling = limits.get("ceiling", math.inf)
    if isinstance(ceiling, bool) or not isinstance(ceiling, (int, float)) or math.isnan(ceiling):
        raise ParameterError(f"ceiling is {ceiling!r}; it must be a height in metres.")
    return float(ceiling)


def _box(given: Any, name: str) -> KeepOutBox:
    if not isinstance(given, Mapping) or not set(KEYS) <= set(given) <= {*KEYS, "name"}:
        raise ParameterError(f"The keep-out box {name} is {given!r}; give it low, high and perhaps a name.")
    if not all(isinstance(given[corner], (list, tuple)) for corner in KEYS):
        raise ParameterError(f"The keep-out box {name} needs low and high as lists: [x, y, z].")
    return KeepOutBox(tuple(given["low"]), tuple(given["high"]), str(given.get("name", name)))


def _around(inner: KeepOutBox) -> list[KeepOutBox]:
    """Return boxes that hold all that is outside of one."""
    boxes = []
    for axis, name in enumerate("xyz"):
        for is_above in (False, True):
            low, high = [-FARTHEST_M] * 3, [FARTHEST_M] * 3
            if is_above:
                low[axis] = inner.high_m[axis]
            else:
                high[axis] = inner.low_m[axis]
            side = "above" if is_above else "below"
            boxes.append(
                KeepOutBox((low[0], low[1], low[2]), (high[0], high[1], high[2]), f"{name} {side} keep_in")
            )
    return boxes


def _steps(low_m: float, high_m: float) -> np.ndarray:
    """Return places at most WALL_STEP_M apart, both ends included."""
    return np.linspace(low_m, high_m, math.ceil((high_m - low_m) / WALL_STEP_M) + 1)
