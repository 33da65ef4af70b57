"""How close a model is to its surroundings: exact distances (GJK) to the few bodies that can be nearest."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Iterable, Iterator, Mapping, Sequence

import numpy as np

from simulation_tools.geometry import Pose
from simulation_tools.world.bodies import Body
from simulation_tools.world.engine import pybullet
from simulation_tools.world.shapes.meshes import mesh_of

FINE_TRIANGLES = 4000
"""A mesh with more triangles is fine: physics is asked for what is near first."""
FIRST_M = 0.25
WIDER = 1.4
WIDER_LEAST_M = 0.01
SHELL_TRIANGLES = 1000
"""Triangles of a flat mesh that lie between two distances that physics is asked for."""


@dataclass(frozen=True)
class OwnShape:
    """A PyBullet collision shape, a pose to test it at (world), and a sphere around it in its own frame."""

    shape: int
    pose: Pose
    centre_m: tuple[float, float, float]
    radius_m: float


@dataclass(frozen=True)
class _Surroundings:
    """The bodies that may be near. lows, highs: corners (n, 3) of the boxes around fixed bodies."""

    standing: tuple[Body, ...]
    lows: np.ndarray
    highs: np.ndarray
    moving: tuple[Body, ...]


class Clearances:
    """Finds least distances in one PyBullet client.

    owners: name of the model and body of each PyBullet uid, kept up to date by the world. Call `forget` when
    fixed bodies have changed.
    """

    def __init__(self, client: int, owners: Mapping[int, tuple[str, Body]]) -> None:
        self._client = client
        self._owners = owners
        self._surroundings: dict[frozenset[str], _Surroundings] = {}
        self._triangles_m2: dict[int, float] = {}

    def forget(self) -> None:
        """Note that a body was added or removed, or that a fixed one was moved."""
        self._surroundings.clear()
        self._triangles_m2.clear()

    def least(self, own: Sequence[OwnShape], passed_over: frozenset[str], max_distance_m: float) -> float:
        """Return the least distance between shapes and the bodies of all models that are not ignored.

        inf when nothing is within max_distance_m.
        """
        around = self._surroundings.get(passed_over)
        if around is None:
            around = self._surroundings[passed_over] = self._look_around(passed_over)
        bodies, lows, highs = around.standing, around.lows, around.highs
        if around.moving:
            boxes = np.array([self._box(body) for body in around.moving])
            bodies = (*bodies, *around.moving)
            lows, highs = np.concatenate((lows, boxes[:, 0])), np.concatenate((highs, boxes[:, 1]))
        best = float("inf")
        for shape in own if bodies else ():
            centre = shape.pose.transform(np.array(shape.centre_m))
            gaps = np.linalg.norm(np.maximum(np.maximum(lows - centre, centre - highs), 0.0), axis=1)
            # Start with the nearest box. An early good bound spares the exact distance to most other bodies.
            for index in np.argsort(gaps):
                limit = min(best, max_distance_m)
                if gaps[index] - shape.radius_m > limit:
                    break
                best = min(best, self._distance(shape, bodies[index], limit))
        return best if best <= max_distance_m else float("inf")

    def _look_around(self, passed_over: frozenset[str]) -> _Surroundings:
        bodies = [
            body
            for name, body in self._owners.values()
            if name not in passed_over and any(shape >= 0 for shape in body.shapes)
        ]
        standing = tuple(body for body in bodies if body.stands)
        boxes = np.array([self._box(body) for body in standing]).reshape(-1, 2, 3)
        moving = tuple(body for body in bodies if not body.stands)
        return _Surroundings(standing, boxes[:, 0], boxes[:, 1], moving)

    def _distance(self, own: OwnShape, other: Body, limit_m: float) -> float:
        for within_m in self._widening(other, max(limit_m, 0.0)):
            points: Iterable[tuple] = pybullet.getClosestPoints(
                bodyA=-1,
                bodyB=other.uid,
                distance=within_m,
                linkIndexA=-1,
                collisionShapeA=own.shape,
                collisionShapePositionA=own.pose.position_m,
                collisionShapeOrientationA=own.pose.orientation_xyzw,
                physicsClientId=self._client,
            )
            nearest_m: float = min((point[8] for point in points), default=math.inf)
            if nearest_m < math.inf:
                return nearest_m
        return math.inf

    def _widening(self, body: Body, limit_m: float) -> Iterator[float]:
        """Yield the distances, m, within which physics looks for a body, one after the other.

        PyBullet returns a point for each triangle within the distance. With some 50 000 points it writes
        beyond its buffer: the distances are wrong, or the process ends. So it looks near a fine mesh first.
        """
        triangle_m2, within_m = self._triangle_m2(body), 0.0
        while within_m < limit_m and triangle_m2 > 0.0:
            flat_m = math.sqrt(within_m * within_m + SHELL_TRIANGLES * triangle_m2 / math.pi)
            wider_m = min(max(FIRST_M, WIDER * within_m), max(flat_m, within_m + WIDER_LEAST_M))
            within_m = min(wider_m, limit_m)
            yield within_m
        if within_m < limit_m or limit_m == 0.0:
            yield limit_m

    def _triangle_m2(self, body: Body) -> float:
        """Return the mean area of a fine mesh's triangles, m^2; 0: the body is none."""
        known = self._triangles_m2.get(body.uid)
        if known is None:
            known = self._triangles_m2[body.uid] = _mean_triangle_m2(body)
        return known

    def _box(self, body: Body) -> np.ndarray:
        """Return the least and greatest corner of the box around a body, (2, 3)."""
        corners = np.array(
            [
                pybullet.getAABB(body.uid, index - 1, physicsClientId=self._client)
                for index, shape in enumerate(body.shapes)
                if shape >= 0
            ]
        )
        return np.stack((corners[:, 0].min(axis=0), corners[:, 1].max(axis=0)))


def _mean_triangle_m2(body: Body) -> float:
    """Return the mean area of a body's triangles, m^2; 0: there are not many, or physics takes its hull."""
    if body.collision is None:
        return 0.0
    mesh = mesh_of(body.collision.collision.geometry)
    if len(mesh.triangles) <= FINE_TRIANGLES:
        return 0.0
    first, second, third = (mesh.vertices[mesh.triangles[:, k]] for k in range(3))
    return 0.5 * float(np.linalg.norm(np.cross(second - first, third - first), axis=1).mean())
