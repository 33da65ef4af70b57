"""OctoMap's insertion and streams, written slowly and obviously; and its library as an oracle.

After `OccupancyOcTreeBase.hxx` and `OcTreeBaseImpl.hxx` of OctoMap 1.10, line by line, with dictionaries.
"""

from __future__ import annotations

import math
import struct

import numpy as np

F = np.float32
KEY_MAX = 32768


def key_of(point, resolution):
    """A point's voxel, counted from the origin; None outside of the octree."""
    factor = 1.0 / resolution
    scaled = [math.floor(factor * float(value)) for value in point]
    return tuple(scaled) if all(-KEY_MAX <= value < KEY_MAX for value in scaled) else None


def ray_keys(origin, end, resolution):
    """`computeRayKeys`: voxels from the origin's to the one before the end's; None outside of the octree."""
    first, last = key_of(origin, resolution), key_of(end, resolution)
    if first is None or last is None:
        return None
    if first == last:
        return []
    keys, direction = [first], end - origin
    # A float of OctoMap's, compared as its double; numpy 2 would round the other side of a comparison, too
    length = float(F(norm(direction)))
    direction = direction / F(length)
    step, border, turn = [0, 0, 0], [math.inf] * 3, [math.inf] * 3
    for axis in range(3):
        step[axis] = int(np.sign(direction[axis]))
        if step[axis]:
            edge = (first[axis] + 0.5) * resolution + float(F(step[axis] * resolution * 0.5))
            border[axis] = (edge - float(origin[axis])) / float(direction[axis])
            turn[axis] = resolution / abs(float(direction[axis]))
    key = list(first)
    while True:
        if border[0] < border[1]:
            axis = 0 if border[0] < border[2] else 2
        else:
            axis = 1 if border[1] < border[2] else 2
        key[axis] += step[axis]
        border[axis] += turn[axis]
        if tuple(key) == last or min(border) > length:
            return keys
        keys.append(tuple(key))


def norm(vector):
    x, y, z = vector
    return math.sqrt(float(F(F(F(x * x) + F(y * y)) + F(z * z))))


def log_odds(probability):
    return F(math.log(probability / (1 - probability)))


class PlainVolume:
    """Log-odds by voxel."""

    def __init__(self, resolution=0.1, max_range=-1.0, hit=0.7, miss=0.4, least=0.1192, greatest=0.971):
        self.resolution, self.max_range = resolution, max_range
        self.hit, self.miss, self.least, self.greatest = (log_odds(p) for p in (hit, miss, least, greatest))
        self.voxels = {}

    def insert(self, origin, points):
        origin, points = np.asarray(origin, F), np.asarray(points, F).reshape(-1, 3)
        free, occupied = set(), set()
        for point in points:
            way = norm(point - origin)
            if self.max_range < 0.0 or way <= self.max_range:
                keys, key = ray_keys(origin, point, self.resolution), key_of(point, self.resolution)
                if key is not None:
                    occupied.add(key)
            else:
                end = origin + (point - origin) / F(way) * F(self.max_range)
                keys = ray_keys(origin, end, self.resolution)
            free.update(keys or [])
        for key in free - occupied:
            self._add(key, self.miss)
        for key in occupied:
            self._add(key, self.hit)

    def _add(self, key, update):
        value = F(self.voxels.get(key, F(0.0)) + update)
        self.voxels[key] = min(max(value, self.least), self.greatest)


def dense(voxels, box):
    """Voxels by key as an array (d, h, w) of a box; all must lie in it."""
    values = np.full(np.subtract(box.high, box.low)[::-1], np.nan, F)
    for (x, y, z), value in voxels.items():
        assert (np.array((x, y, z)) >= box.low).all()
        values[z - box.low[2], y - box.low[1], x - box.low[0]] = value
    return values


def leaves_of_full(data):
    """Leaves (x, y, z, side, log-odds) of a stream as `writeData` writes it."""
    leaves, at = [], 0

    def read(x, y, z, side):
        nonlocal at
        value, children = struct.unpack_from("<fB", data, at)
        at += 5
        if not children:
            leaves.append((x, y, z, side, value))
        for child in range(8):
            if children >> child & 1:
                half = side // 2
                read(x + half * (child & 1), y + half * (child >> 1 & 1), z + half * (child >> 2), half)

    if data:
        read(-KEY_MAX, -KEY_MAX, -KEY_MAX, 2 * KEY_MAX)
    assert at == len(data)
    return leaves


def leaves_of_binary(data):
    """Leaves (x, y, z, side, is occupied) of a stream as `writeBinaryData` writes it."""
    leaves, at = [], 0

    def read(x, y, z, side):
        nonlocal at
        kinds, at, half = struct.unpack_from("<H", data, at)[0], at + 2, side // 2
        corners = [(x + half * (i & 1), y + half * (i >> 1 & 1), z + half * (i >> 2)) for i in range(8)]
        for child, corner in enumerate(corners):
            kind = kinds >> 2 * child & 3
            if kind in (1, 2):
                leaves.append((*corner, half, kind == 2))
        for child, corner in enumerate(corners):
            if kinds >> 2 * child & 3 == 3:
                read(*corner, half)

    if data:
        read(-KEY_MAX, -KEY_MAX, -KEY_MAX, 2 * KEY_MAX)
    assert at == len(data)
    return leaves


def filled(leaves, box, kind=F):
    """Leaves as an array (d, h, w) of a box, NaN where there is none; all must lie in it."""
    values = np.full(np.subtract(box.high, box.low)[::-1], np.nan, kind)
    for x, y, z, side, value in leaves:
        low = np.array((z, y, x)) - box.low[::-1]
        assert ((low >= 0) & (low + side <= values.shape)).all(), "a leaf outside of the box"
        values[low[0] : low[0] + side, low[1] : low[1] + side, low[2] : low[2] + side] = value
    return values


def body_of(file):
    """The stream in a file as OctoMap writes it."""
    return file[file.index(b"\ndata\n") + 6 :]
