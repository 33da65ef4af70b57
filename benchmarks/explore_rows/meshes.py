"""Nine places as worlds of other people are: each is one mesh, and few have one level floor."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Callable, Sequence

import numpy as np
import trimesh

Range = tuple[float, float]
WALL_M = 0.2
ROUGH_M = 0.25
"""Side of the cubes that the mine is cut out of."""


@dataclass(frozen=True)
class MeshPlace:
    """The UAV starts at the origin, on the floor. low_m, high_m: corners of a box around all, m."""

    mesh: trimesh.Trimesh
    low_m: tuple[float, float, float]
    high_m: tuple[float, float, float]

    def written_to(self, folder: Path) -> Path:
        """Write mesh and world; return the world's path."""
        self.mesh.export(folder / "place.stl")
        uri = f"<geometry><mesh><uri>{(folder / 'place.stl').as_uri()}</uri></mesh></geometry>"
        world = folder / "place.world"
        world.write_text(
            '<?xml version="1.0"?><sdf version="1.6"><world name="place"><model name="building"><static>true'
            f'</static><link name="link"><collision name="c">{uri}</collision><visual name="v">{uri}</visual>'
            "</link></model></world></sdf>"
        )
        return world


def box(x: Range, y: Range, z: Range) -> trimesh.Trimesh:
    """Return a box from and to, m."""
    sides = [high - low for low, high in (x, y, z)]
    middle = [0.5 * (low + high) for low, high in (x, y, z)]
    return trimesh.creation.box(sides).apply_translation(middle)


def shell(x: Range, y: Range, z: Range) -> list[trimesh.Trimesh]:
    """Return six walls around a room."""
    (x0, x1), (y0, y1), (z0, z1), t = x, y, z, WALL_M
    return [
        box((x0 - t, x1 + t), (y0 - t, y1 + t), (z0 - t, z0)),
        box((x0 - t, x1 + t), (y0 - t, y1 + t), (z1, z1 + t)),
        box((x0 - t, x0), (y0, y1), (z0, z1)),
        box((x1, x1 + t), (y0, y1), (z0, z1)),
        box((x0, x1), (y0 - t, y0), (z0, z1)),
        box((x0, x1), (y1, y1 + t), (z0, z1)),
    ]


def slab(x: Range, y: Range, z: Range, hole: tuple[Range, Range]) -> list[trimesh.Trimesh]:
    """Return a level plate with a hole from and to in x and y."""
    (x0, x1), (y0, y1), ((a0, a1), (b0, b1)) = x, y, hole
    return [
        box((x0, a0), y, z),
        box((a1, x1), y, z),
        box((a0, a1), (y0, b0), z),
        box((a0, a1), (b1, y1), z),
    ]


def wall(at_m: float, y: Range, z: Range, door: tuple[Range, Range]) -> list[trimesh.Trimesh]:
    """Return a wall across x with an opening from and to in y and z."""
    (y0, y1), (z0, z1), ((a0, a1), (b0, b1)) = y, z, door
    x = at_m, at_m + WALL_M / 2.0
    parts = [(y0, a0, z0, z1), (a1, y1, z0, z1), (a0, a1, z0, b0), (a0, a1, b1, z1)]
    return [box(x, (a, b), (c, d)) for a, b, c, d in parts if b > a and d > c]


def joined(parts: Sequence[trimesh.Trimesh]) -> MeshPlace:
    """Return all parts as one mesh."""
    mesh: trimesh.Trimesh = trimesh.util.concatenate(list(parts))  # type: ignore[assignment]
    low, high = mesh.bounds
    return MeshPlace(mesh, tuple(low.tolist()), tuple(high.tolist()))


def ramp() -> MeshPlace:
    """A corridor of 4 x 3 m that rises by 8 degrees for 12 m."""
    top = 12.0 * math.tan(math.radians(8.0))
    return _corridor([(-3.0, 0.0), (3.0, 0.0), (15.0, top), (21.0, top)], 4.0, 3.0)


def stairs() -> MeshPlace:
    """Two storeys of 2.8 m. A flight of 15 steps leads through an opening of 4 x 1.6 m."""
    steps = [
        box((1.0 + 0.28 * n, 1.0 + 0.28 * (n + 1)), (-0.8, 0.8), (0.0, 0.2 * (n + 1))) for n in range(15)
    ]
    inner = slab((-4.0, 8.0), (-3.0, 3.0), (2.8, 3.0), ((1.2, 5.2), (-0.8, 0.8)))
    return joined([*shell((-4.0, 8.0), (-3.0, 3.0), (0.0, 5.8)), *inner, *steps])


def double_bottom() -> MeshPlace:
    """1.2 m high and 6 x 4 m: two floors with manholes of 0.8 x 0.8 m."""
    floors = [
        part
        for x, y in ((1.0, -0.6), (3.0, 0.6))
        for part in wall(x, (-2.0, 2.0), (0.0, 1.2), ((y - 0.4, y + 0.4), (0.2, 1.0)))
    ]
    return joined([*shell((-1.2, 4.8), (-2.0, 2.0), (0.0, 1.2)), *floors])


def hole() -> MeshPlace:
    """A room with a hole of 2 x 2 m in its floor, and a room below."""
    floor = slab((-4.0, 6.0), (-4.0, 4.0), (-0.2, 0.0), ((2.5, 4.5), (-1.0, 1.0)))
    above = shell((-4.0, 6.0), (-4.0, 4.0), (0.0, 3.5))[1:]
    return joined([*floor, *above, *shell((0.0, 6.0), (-3.0, 3.0), (-5.0, -0.2))[:1],
                   *shell((0.0, 6.0), (-3.0, 3.0), (-5.0, -0.2))[2:]])  # fmt: skip


def shaft() -> MeshPlace:
    """3 x 3 x 25 m. Two baffles, at 8 and at 16 m, leave half of it open, on opposite sides."""
    baffles = [box((0.0, 1.5), (-1.5, 1.5), (8.0, 8.2)), box((-1.5, 0.0), (-1.5, 1.5), (16.0, 16.2))]
    return joined([*shell((-1.5, 1.5), (-1.5, 1.5), (0.0, 25.0)), *baffles])


def hall() -> MeshPlace:
    """100 x 60 x 20 m with twelve columns."""
    columns = [
        box((x, x + 1.0), (y, y + 1.0), (0.0, 20.0))
        for x in (-25.0, -5.0, 15.0, 35.0)
        for y in (-15.0, 0.5, 15.0)
    ]
    return joined([*shell((-45.0, 55.0), (-30.0, 30.0), (0.0, 20.0)), *columns])


def storeys() -> MeshPlace:
    """Four storeys of 2.8 m, 8 x 6 m, joined by openings of 1.6 x 1.6 m on opposite sides."""
    floors = [
        part
        for n in (1, 2, 3)
        for part in slab(
            (-4.0, 4.0),
            (-3.0, 3.0),
            (3.0 * n - 0.2, 3.0 * n),
            (((1.4, 3.0), (-3.0, -1.4))[n % 2], (-0.8, 0.8)),
        )
    ]
    return joined([*shell((-4.0, 4.0), (-3.0, 3.0), (0.0, 11.8)), *floors])


def mine() -> MeshPlace:
    """Galleries with rough walls that branch, fall and rise: 30 m long."""
    low, high = np.array((-4.0, -12.0, -4.0)), np.array((28.0, 12.0, 7.0))
    shape = np.round((high - low) / ROUGH_M).astype(int)
    rng = np.random.default_rng(76)
    centres = low + (np.argwhere(np.ones(shape, bool)) + 0.5) * ROUGH_M
    solid = np.ones(len(centres), bool)
    ways = (
        ((-1, 0, 1.5), (12, 0, 0.5)),
        ((12, 0, 0.5), (25, 6, 3.0)),
        ((12, 0, 0.5), (22, -8, -1.0)),
        ((6, 0, 1.0), (6, 9, 1.5)),
    )
    for begin, end in ways:
        a, b = np.array(begin, float), np.array(end, float)
        share = np.clip(((centres - a) @ (b - a)) / ((b - a) @ (b - a)), 0.0, 1.0)
        off = np.linalg.norm(centres - a - share[:, None] * (b - a), axis=1)
        solid &= off > 1.7 + 0.15 * rng.standard_normal(len(centres))
    floor = (np.abs(centres[:, 0]) < 2.0) & (np.abs(centres[:, 1]) < 1.5)
    solid |= floor & (centres[:, 2] < 0.0)  # level, to take off from
    return joined([_skin(solid.reshape(shape), low)])


def office() -> MeshPlace:
    """A corridor of 14 x 2 m with six rooms of 4 x 4 m, their doors 1.3 m wide, tables and shelves."""
    parts = shell((-2.0, 12.0), (-5.1, 5.1), (0.0, 2.8))
    for side in (1.0, -1.0):
        for n in range(3):
            x0, door = -2.0 + 14.0 / 3.0 * n, -2.0 + 14.0 / 3.0 * n + 1.0
            inner = (1.0, 1.1) if side > 0 else (-1.1, -1.0)
            parts += [
                box((x0, door), inner, (0.0, 2.8)),
                box((door + 1.3, x0 + 14.0 / 3.0), inner, (0.0, 2.8)),
                box((door, door + 1.3), inner, (2.2, 2.8)),
                box((door + 0.8, door + 2.4), _between(side * 4.2, side * 5.1), (0.0, 0.75)),
            ]
            if n:
                parts.append(box((x0 - 0.05, x0 + 0.05), _between(side * 1.1, side * 5.1), (0.0, 2.8)))
    return joined(parts)


PLACES: dict[str, Callable[[], MeshPlace]] = {
    each.__name__: each for each in (ramp, stairs, double_bottom, hole, shaft, hall, storeys, mine, office)
}


def _between(a: float, b: float) -> Range:
    return min(a, b), max(a, b)


def _corridor(floor_m: Sequence[tuple[float, float]], breadth_m: float, height_m: float) -> MeshPlace:
    """Return a corridor along x whose floor runs through places (x, z)."""
    half, corners, faces = breadth_m / 2.0, [], []
    for x, z in floor_m:
        corners += [(x, y, z + h) for h in (0.0, height_m) for y in (-half, half)]
    for n in range(len(floor_m) - 1):
        a, b = 4 * n, 4 * n + 4
        for i, j in ((0, 1), (1, 3), (3, 2), (2, 0)):
            faces += [(a + i, a + j, b + j), (a + i, b + j, b + i)]
    last = 4 * (len(floor_m) - 1)
    for a in (0, last):
        faces += [(a, a + 1, a + 3), (a, a + 3, a + 2)]
    return joined([trimesh.Trimesh(corners, faces, process=False)])


def _skin(solid: np.ndarray, low_m: np.ndarray) -> trimesh.Trimesh:
    """Return the faces between solid and empty cubes (w, h, d), x first."""
    around = np.pad(solid, 1, constant_values=True)
    quads = []
    for axis in range(3):
        others = [other for other in range(3) if other != axis]
        change = np.argwhere(np.diff(around.astype(np.int8), axis=axis))
        for first, second in ((0, 0), (1, 0), (1, 1), (0, 1)):
            corner = change.astype(float)
            corner[:, others[0]] += first - 1.0
            corner[:, others[1]] += second - 1.0
            quads.append(corner)
        quads[-4:] = [np.stack(quads[-4:], axis=1)]
    corners = low_m + np.concatenate(quads) * ROUGH_M
    numbers = np.arange(4 * len(corners)).reshape(-1, 4)
    faces = np.concatenate([numbers[:, [0, 1, 2]], numbers[:, [0, 2, 3]]])
    mesh = trimesh.Trimesh(corners.reshape(-1, 3), faces, process=False)
    mesh.merge_vertices()
    return mesh
