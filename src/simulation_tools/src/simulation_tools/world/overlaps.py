"""Finds models that are inside each other at the start, before physics pushes them apart."""

from __future__ import annotations

from typing import Iterator, Mapping, NamedTuple, Sequence

import numpy as np

from simulation_tools.world.bodies import Body
from simulation_tools.world.engine import pybullet

TOUCHING_M = 0.01
"""A shape that is inside another by less than this only stands on it or leans against it."""
NAMED = 3
"""Number of pairs in a sentence."""


class Overlap(NamedTuple):
    """Two models, at least one of which can move, and how deep they are inside each other."""

    first: str
    second: str
    depth_m: float


def overlaps(client: int, owners: Mapping[int, tuple[str, Body]]) -> list[Overlap]:
    """Return the overlaps of models in one PyBullet client, the deepest first.

    owners: name of the model and body of each PyBullet uid. The function only computes distances. The
    engine's contacts do not change.
    """
    deepest: dict[tuple[str, str], float] = {}
    for first, second in _near(client, owners):
        names = owners[first][0], owners[second][0]
        points = pybullet.getClosestPoints(first, second, 0.0, physicsClientId=client)
        depth_m = -min((point[8] for point in points), default=0.0)
        if depth_m > TOUCHING_M and depth_m > deepest.get(names, 0.0):
            deepest[names] = depth_m
    found = [Overlap(*names, depth_m) for names, depth_m in deepest.items()]
    return sorted(found, key=lambda overlap: -overlap.depth_m)


def warning_of(found: Sequence[Overlap]) -> str | None:
    """Return the warning about overlaps, None when there are none."""
    if not found:
        return None
    named = ", ".join(f"{first} and {second} by {depth_m:.2f} m" for first, second, depth_m in found[:NAMED])
    more = f", and {len(found) - NAMED} pairs more" if len(found) > NAMED else ""
    return (
        f"Models that can move are inside others at the start ({named}{more}): physics throws them apart. "
        "Place them apart, or let nothing in the world move: static_models:=true, or <static> in its file."
    )


def _near(client: int, owners: Mapping[int, tuple[str, Body]]) -> Iterator[tuple[int, int]]:
    """Yield the pairs of bodies (a moving one first) whose boxes overlap; each pair once."""
    uids = [uid for uid, (_, body) in owners.items() if any(shape >= 0 for shape in body.shapes)]
    if not any(_moves(owners[uid][1]) for uid in uids):
        return
    lows, highs = (np.array(corners) for corners in zip(*(_box(client, owners[uid][1]) for uid in uids)))
    for index, uid in enumerate(uids):
        name, body = owners[uid]
        if not _moves(body):
            continue
        near = np.flatnonzero(((lows <= highs[index]) & (highs >= lows[index])).all(axis=1))
        for other in near:
            other_name, other_body = owners[uids[other]]
            if other_name != name and not (_moves(other_body) and other < index):
                yield uid, uids[other]


def _moves(body: Body) -> bool:
    return any(part.mass is not None for part in body.parts)


def _box(client: int, body: Body) -> tuple[np.ndarray, np.ndarray]:
    """Return the least and greatest corner of the box around a body, m."""
    corners = np.array(
        [
            pybullet.getAABB(body.uid, index - 1, physicsClientId=client)
            for index, shape in enumerate(body.shapes)
            if shape >= 0
        ]
    )
    return corners[:, 0].min(axis=0), corners[:, 1].max(axis=0)
