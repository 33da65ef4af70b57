"""Seeded defects on the surfaces of a world, and marks that look like some and are none."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import yaml

from flights.errors import ScenarioError
from flights.worlds.cargo import NAMES as CARGO
from flights.worlds.floor_plan import outlines
from simulation_tools.camera.surfaces import surfaces_of
from simulation_tools.sdf.elements import Plane, World
from simulation_tools.sdf.parser import load_world

NUMBERS = {"rust": 60, "crack": 40, "seam": 40, "stain": 30, "shadow": 20}
"""Of each kind. The first two are defects: 100 together."""
COATINGS = {
    "ground_plane": (0.55, 0.57, 0.56),
    "shell": (0.70, 0.72, 0.69),
    "frames": (0.66, 0.69, 0.66),
    "bulkheads": (0.66, 0.69, 0.66),
    "stiffeners": (0.66, 0.69, 0.66),
    "beams": (0.66, 0.69, 0.66),
    "stanchions": (0.66, 0.69, 0.66),
}
"""Light grey epoxy, sRGB. The worlds' own colours are for drawings."""
_TRIES, _MORE_TRIES = 20_000, 1_000
"""For a mark of its first size, and for each smaller one, where a world has no room for that."""
_SMALLER, _LEAST_M = 0.6, 0.05
"""A mark that finds no place gets this share of its size, and is left out when it would be shorter."""
_RAYS, _BOUNCES = 4000, 50
"""Rays that look for rooms, and how often each goes on from somewhere on its way."""
_ASIDE_M, _ABOVE_M, _GROUND_M = 3.0, 1.0, 0.3
"""In the open, the eyes are so far beside what stands there and above it, and so far above its foot."""
_EYE_M = 0.6
"""An eye keeps so far from the ends of the box in which it is drawn."""
_BEYOND_M = 0.5
"""A ray that ends farther outside what was seen looks through an opening into another room."""


def write_defects(world: Path, target: Path, seed: int, share: float = 1.0) -> dict[str, int]:
    """Write a file of defects for a world with plane walls. The same seed gives the same file.

    share: of the numbers of each kind. Return how many marks of each kind found no place, and were left out.

    Raises:
        ScenarioError: the world has no free surface.
        SdfError: the world cannot be read.
    """
    description = load_world(str(world))
    rng = np.random.default_rng(seed)
    placer = _Placer(description, rng)
    wanted = [kind for kind, number in NUMBERS.items() for _ in range(round(share * number))]
    defects = [mark for kind in wanted if (mark := placer.one(kind)) is not None]
    if not defects:
        raise ScenarioError(
            f"{world}: no mark found a place. Marks need plane surfaces with 1 m of room before them."
        )
    content = {"world": world.name, "seed": seed, "coatings": _plain(COATINGS), "defects": defects}
    target.write_text(yaml.safe_dump(content, sort_keys=False, default_flow_style=None), encoding="utf-8")
    missing = Counter(wanted) - Counter(mark["kind"] for mark in defects)
    return dict(missing)


def _plain(coatings: dict) -> dict:
    return {name: list(colour) for name, colour in coatings.items()}


def _grounds(world: World) -> tuple[str, ...]:
    """Return the names of the models that are planes."""
    return tuple(
        model.name
        for model in world.models
        if any(isinstance(visual.geometry, Plane) for link in model.links for visual in link.visuals)
    )


def _around(world: World) -> tuple[np.ndarray, np.ndarray]:
    """Return a box about all that stands in an open world; raises ScenarioError if nothing does."""
    standing = outlines(world)
    if not standing:
        raise ScenarioError(f"{world.source}: nothing stands in this world that could have defects.")
    corners = np.concatenate([each.outline_xy for each in standing])
    bottom, top = min(each.bottom_m for each in standing), max(each.top_m for each in standing)
    low, high = np.append(corners.min(axis=0), bottom), np.append(corners.max(axis=0), top)
    aside = np.array((_ASIDE_M, _ASIDE_M, 0.0))
    return low - aside + (0.0, 0.0, _GROUND_M - _EYE_M), high + aside + (0.0, 0.0, _ABOVE_M)


class _Placer:
    """Finds free places by rays from points inside the world: what is hit can be seen.

    Cargo gets no marks. In a world that is open, the ground gets none either.
    """

    def __init__(self, world: World, rng: np.random.Generator) -> None:
        self._surfaces, self._rng = surfaces_of(world, COATINGS), rng
        self._taken: list[tuple[np.ndarray, float]] = []
        self._tries = dict.fromkeys(NUMBERS, _TRIES)
        inside = self._bounds()
        self._inside = inside or _around(world)
        left_out = CARGO if inside else (*CARGO, *_grounds(world))
        kept = tuple(each for each in world.models if each.name not in left_out)
        self._ship = surfaces_of(replace(world, models=kept))

    def _bounds(self) -> tuple[np.ndarray, np.ndarray] | None:
        """Return the box about all rooms that are open to the place above the origin; None: it is open."""
        eyes = np.tile((0.0, 0.0, 1.5), (_RAYS, 1))
        hits = self._hits(eyes, self._rng)
        if hits is None:
            return None
        low, high = hits.min(axis=0), hits.max(axis=0)
        (others,) = self._rng.spawn(1)
        for _ in range(_BOUNCES):
            eyes = eyes + others.random((_RAYS, 1)) * (hits - eyes)
            hits = self._hits(eyes, others)
            if hits is None:
                return None
            beyond = ((hits < low - _BEYOND_M) | (hits > high + _BEYOND_M)).any(axis=1)
            low = np.minimum(low, hits[beyond].min(axis=0, initial=np.inf))
            high = np.maximum(high, hits[beyond].max(axis=0, initial=-np.inf))
        return low, high

    def _hits(self, eyes: np.ndarray, rng: np.random.Generator) -> np.ndarray | None:
        """Return where rays (n, 3) from eyes (n, 3) end; None if one leaves the world."""
        directions = rng.standard_normal(eyes.shape)
        directions /= np.linalg.norm(directions, axis=1)[:, None]
        faces, distances = self._surfaces.nearest(eyes, directions)
        return None if (faces < 0).any() else eyes + distances[:, None] * directions

    def one(self, kind: str) -> dict | None:
        """Return one mark that lies on one plane, is seen from 1 m, and touches no other of its size.

        Where there is no room for it, a smaller one; None: not even for that.
        """
        length, width = self._size(kind)
        low, high = self._inside
        while length > max(high - low):
            length *= _SMALLER
        while length >= _LEAST_M or self._tries[kind] == _TRIES:
            for _ in range(self._tries[kind]):
                placed = self._try(kind, length, width)
                if placed is not None:
                    return placed
            self._tries[kind] = _MORE_TRIES
            length *= _SMALLER
            width *= 1.0 if kind in ("crack", "seam") else _SMALLER
        return None

    def _size(self, kind: str) -> tuple[float, float]:
        rng = self._rng
        if kind == "rust":
            length = float(np.exp(rng.uniform(np.log(0.03), np.log(0.30))))
            return length, length * rng.uniform(0.6, 1.0)
        if kind == "crack":
            return rng.uniform(0.2, 1.0), float(np.exp(rng.uniform(np.log(0.0003), np.log(0.002))))
        if kind == "seam":
            return rng.uniform(1.0, 2.6), rng.uniform(0.010, 0.016)
        return rng.uniform(0.2, 0.8), rng.uniform(0.1, 0.4)

    def _try(self, kind: str, length: float, width: float) -> dict | None:
        rng, surfaces = self._rng, self._surfaces
        low, high = self._inside
        eye = rng.uniform(low + _EYE_M, np.maximum(high - _EYE_M, low + _EYE_M + 0.01))
        direction = rng.standard_normal(3)
        direction /= np.linalg.norm(direction)
        faces, distances = surfaces.nearest(eye[None], direction[None])
        face, distance = int(faces[0]), float(distances[0])
        if face < 0 or not 0.5 < distance < 12.0:
            return None
        if not np.isclose(self._ship.nearest(eye[None], direction[None])[1][0], distance):
            return None  # on cargo
        normal = surfaces.normals[face]
        if -(normal @ direction) < 0.5:
            return None
        middle = eye + distance * direction
        middle -= (normal @ middle - surfaces.offsets_m[face]) * normal
        angle = rng.choice((0.0, np.pi / 2)) if kind == "seam" else rng.uniform(0.0, np.pi)
        if kind == "stain":
            angle = np.pi / 2
        u, v = surfaces.u_axes[face], surfaces.v_axes[face]
        along, across = np.cos(angle) * u + np.sin(angle) * v, np.cos(angle) * v - np.sin(angle) * u
        reach = 0.5 * length + 0.05
        if any(np.linalg.norm(middle - other) < reach + far for other, far in self._taken):
            return None
        if not self._is_free(face, middle, normal, along * 0.55 * length, across * (0.55 * width + 0.03)):
            return None
        if kind != "seam":
            self._taken.append((middle, reach))
        vectors = {"position_m": middle, "normal": normal, "along": along}
        return {
            "kind": kind,
            **{name: [round(float(x), 5) for x in vector] for name, vector in vectors.items()},
            "length_m": round(float(length), 4),
            "width_m": round(float(width), 5),
            "seed": int(rng.integers(1 << 31)),
        }

    def _is_free(
        self, face: int, middle: np.ndarray, normal: np.ndarray, half: np.ndarray, side: np.ndarray
    ) -> bool:
        """Whether the mark's outline lies on the face, and is seen from 1 m in front of its middle."""
        steps = [(a, b) for a in (-1, -0.5, 0, 0.5, 1) for b in (-1, 0, 1)]
        outline = np.array([middle + a * half + b * side for a, b in steps])
        starts = np.vstack((outline + 0.3 * normal, np.tile(middle + 1.0 * normal, (len(outline), 1))))
        ways = np.vstack((outline, outline)) - starts
        lengths = np.linalg.norm(ways, axis=1)
        faces, distances = self._surfaces.nearest(starts, ways / lengths[:, None])
        return bool((faces == face).all() and (np.abs(distances - lengths) < 2e-3).all())
