"""How close a model is to its surroundings: exact distances (GJK) to the few bodies that can be nearest."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Iterable, Sequence

import numpy as np

from simulation_tools.geometry import Pose
from simulation_tools.world.bodies import Body
from simulation_tools.world.engine import pybullet


@dataclass(frozen=True)
class OwnShape:
    """A PyBullet collision shape supposed at a pose (world), and a sphere around it in its own frame."""

    shape: int
    pose: Pose
    centre_m: tuple[float, float, float]
    radius_m: float


class Clearances:
    """Finds least distances in one PyBullet client; remembers the boxes around what does not move."""

    def __init__(self, client: int) -> None:
        self._client = client
        self._boxes: dict[int, tuple[tuple, tuple]] = {}

    def forget(self, uid: int) -> None:
        """Note that a fixed body was moved or removed."""
        self._boxes.pop(uid, None)

    def clear(self) -> None:
        """Note that every body is gone."""
        self._boxes.clear()

    def least(self, own: Sequence[OwnShape], others: Sequence[Body], max_distance_m: float) -> float:
        """Return the least distance between shapes and bodies; inf when none is within max_distance_m."""
        others = [body for body in others if any(shape >= 0 for shape in body.shapes)]
        if not others:
            return float("inf")
        lows, highs = (np.array(corners) for corners in zip(*(self._box(body) for body in others)))
        best = float("inf")
        for shape in own:
            centre = shape.pose.transform(np.array(shape.centre_m))
            gaps = np.linalg.norm(np.maximum(np.maximum(lows - centre, centre - highs), 0.0), axis=1)
            # Nearest box first: a good bound early spares the exact distance to most of the others.
            for index in np.argsort(gaps):
                if gaps[index] - shape.radius_m > min(best, max_distance_m):
                    break
                best = min(best, self._distance(shape, others[index], min(best, max_distance_m)))
        return best if best <= max_distance_m else float("inf")

    def _distance(self, own: OwnShape, other: Body, limit_m: float) -> float:
        points: Iterable[tuple] = pybullet.getClosestPoints(
            bodyA=-1,
            bodyB=other.uid,
            distance=max(limit_m, 0.0),
            linkIndexA=-1,
            collisionShapeA=own.shape,
            collisionShapePositionA=own.pose.position_m,
            collisionShapeOrientationA=own.pose.orientation_xyzw,
            physicsClientId=self._client,
        )
        return min((point[8] for point in points), default=float("inf"))

    def _box(self, body: Body) -> tuple[tuple, tuple]:
        box = self._boxes.get(body.uid)
        if box is None:
            corners = [
                pybullet.getAABB(body.uid, index - 1, physicsClientId=self._client)
                for index, shape in enumerate(body.shapes)
                if shape >= 0
            ]
            low = tuple(min(corner[0][axis] for corner in corners) for axis in range(3))
            high = tuple(max(corner[1][axis] for corner in corners) for axis in range(3))
            box = (low, high)
            if body.collision is not None:
                self._boxes[body.uid] = box
        return box
