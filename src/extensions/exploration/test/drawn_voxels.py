"""Maps of voxels that are drawn with letters, and what a planner is asked and gives in terms of them."""

from __future__ import annotations

import numpy as np

from exploration.planning import PathPlanner

SIDE = 4
LETTERS = {"?": 0, ".": 1, "#": 2}


def kinds_of(*layers):
    """Kinds (d, h, w) from drawings of layers, from the lowest up; in each the first row has the least y."""
    return np.array(
        [[[LETTERS[letter] for letter in row] for row in layer.split()] for layer in layers], np.uint8
    )


def block(depth, height, width, kind=1):
    """Kinds of a block that is all of one kind."""
    return np.full((depth, height, width), kind, np.uint8)


def tiles_of(kinds, side=SIDE, at=(0, 0, 0)):
    """Tiles (n, 3) and voxels (n, side**3) of kinds whose first voxel is the first of tile `at` (x, y, z)."""
    padded = np.pad(kinds, [(0, -size % side) for size in kinds.shape])
    d, h, w = (size // side for size in padded.shape)
    voxels = padded.reshape(d, side, h, side, w, side).transpose(0, 2, 4, 1, 3, 5).reshape(-1, side**3)
    z, y, x = (axis.ravel() for axis in np.meshgrid(range(d), range(h), range(w), indexing="ij"))
    return np.stack((x, y, z), axis=1) + np.array(at), voxels


def planner_on(kinds, parameters, resolution_m=1.0, **how):
    """A planner that knows these kinds."""
    planner = PathPlanner(parameters, **how)
    planner.update_map(resolution_m, SIDE, *tiles_of(kinds))
    return planner


def voxels_on(points_m, resolution_m=1.0, step=0.01):
    """All voxels (n, 3), z, y, x, on a path's legs, by small steps; those grazed at a border are left out."""
    places = []
    for begin, end in zip(points_m, points_m[1:]):
        count = 2 + int(np.linalg.norm(end - begin) / (step * resolution_m))
        places.append(begin + np.linspace(0.0, 1.0, count)[:, None] * (end - begin))
    inner = np.concatenate(places) / resolution_m
    is_inside = (np.abs(inner - np.rint(inner)) > 1e-6).all(axis=1)
    return np.floor(inner[is_inside]).astype(int)[:, ::-1]
