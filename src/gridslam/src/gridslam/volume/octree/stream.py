"""OctoMap's streams of a voxel map: the data of its files and messages."""

from __future__ import annotations

from typing import Callable, NamedTuple

import numpy as np

from gridslam.errors import MapError
from gridslam.volume.kernels.octree import BINARY_BYTES_MAX, FULL_BYTES_MAX, TILE_LEVEL, encode_tiles
from gridslam.volume.kernels.octree_reading import IS_CUT, IS_TOO_DEEP, fill_leaves, read_leaves
from gridslam.volume.kernels.octree_top import assemble, grow_levels
from gridslam.volume.kernels.tiles import KEY_MAX, SIDE, SIDE_BITS
from gridslam.volume.parameters import VolumeParameters
from gridslam.volume.tile_table import TileTable
from gridslam.volume.voxel_map import VoxelMap

AT_ONCE = 256
"""Tiles that are written at once: more would need memory in proportion."""
TILES_MAX = 1 << 17
"""Of a stream that is read: 2 GB."""
UPPER = TILE_LEVEL + 1
COLOUR_BYTES = {"OcTree": 0, "1": 0, "OcTreeStamped": 0, "ColorOcTree": 3}
"""Bytes of colour in each node of a full stream, by the kinds that can be read. Old files call OcTree 1."""
VALUE_BYTES = 4
"""Of a node's log-odds, which colour and one byte of children follow."""

Cubes = Callable[[np.ndarray], np.ndarray]


class OctreeStream(NamedTuple):
    """An octree's data as OctoMap writes it, and what its file's header tells."""

    data: bytes
    nodes: int
    is_binary: bool
    """Whether voxels are free or occupied only (.bt), or have their log-odds (.ot)."""


def stream_of(voxel_map: VoxelMap, is_binary: bool) -> OctreeStream:
    """Return a map's octree."""
    return stream_of_cubes(voxel_map, is_binary, lambda places: cubes_of(voxel_map, places))


def stream_of_cubes(voxel_map: TileTable, is_binary: bool, cubes: Cubes) -> OctreeStream:
    """Return the octree of a table's tiles. ``cubes`` gives the log-odds (k, VOXELS) at its places (k, 3)."""
    places = voxel_map.known_places()
    codes = morton_codes(places[:, ::-1] + voxel_map.corner + KEY_MAX // SIDE)
    order = np.argsort(codes)
    places, codes = places[order], codes[order]
    parts, lengths, below = [], np.zeros(len(codes), np.int64), 0
    kinds, values = np.zeros((UPPER, len(codes)), np.uint8), np.zeros((UPPER, len(codes)), np.float32)
    buffer = np.empty(AT_ONCE * (BINARY_BYTES_MAX if is_binary else FULL_BYTES_MAX), np.uint8)
    for first in range(0, len(codes), AT_ONCE):
        some = slice(first, first + AT_ONCE)
        given = cubes(places[some])
        size, nodes = encode_tiles(given, is_binary, kinds[-1, some], values[-1, some], lengths[some], buffer)
        parts.append(buffer[:size].copy())
        below += nodes
    known = kinds[-1] > 0  # a tile may hold no known voxel
    tile_stream = np.concatenate(parts) if parts else np.empty(0, np.uint8)
    return _with_top(
        codes[known], kinds[-1, known], values[-1, known], lengths[known], tile_stream, is_binary, below
    )


def _with_top(
    codes: np.ndarray,
    kinds: np.ndarray,
    values: np.ndarray,
    lengths: np.ndarray,
    tile_stream: np.ndarray,
    is_binary: bool,
    nodes_below: int,
) -> OctreeStream:
    """Return the octree above and below tiles, which are in Morton order."""
    count = len(codes)
    if not count:
        return OctreeStream(b"", 0, is_binary)
    all_codes, all_kinds = np.zeros((UPPER, count), np.int64), np.zeros((UPPER, count), np.uint8)
    all_values, firsts = np.zeros((UPPER, count), np.float32), np.zeros((UPPER, count + 1), np.int64)
    counts = np.zeros(UPPER, np.int64)
    all_codes[-1], all_kinds[-1], all_values[-1], counts[-1] = codes, kinds, values, count
    nodes = grow_levels(all_codes, all_kinds, all_values, firsts, counts)
    starts = np.concatenate(([0], np.cumsum(lengths)))
    stream = np.empty(tile_stream.size + 5 * int(counts.sum()), np.uint8)
    size = assemble(all_codes, all_kinds, all_values, firsts, starts, tile_stream, is_binary, stream)
    return OctreeStream(stream[:size].tobytes(), nodes + nodes_below, is_binary)


def cubes_of(voxel_map: VoxelMap, places: np.ndarray) -> np.ndarray:
    """Return the log-odds (k, VOXELS) of places (k, 3) in the table, z, y, x."""
    return voxel_map.pool.cubes[voxel_map.table[tuple(places.T)]]


def morton_codes(tiles: np.ndarray) -> np.ndarray:
    """Return the Morton codes (n,) of tiles (n, 3), x, y, z, counted from the octree's least corner."""
    codes = np.zeros(len(tiles), np.int64)
    for bit in range(TILE_LEVEL):
        for axis in range(3):
            codes |= (tiles[:, axis] >> bit & 1) << 3 * bit + axis
    return codes


def map_from(stream: bytes, is_binary: bool, parameters: VolumeParameters, kind: str = "OcTree") -> VoxelMap:
    """Return the map of an octree's data. Voxels of a binary one get the least or greatest probability.

    kind: of the octree, as OctoMap names it; colours and times of its nodes are left out.

    Raises:
        MapError: the data are cut, hold more than an octree, or more than fits into memory; or the kind is
            another one.
    """
    if kind not in COLOUR_BYTES:
        kinds = ", ".join(name for name in COLOUR_BYTES if name.isalpha())
        raise MapError(f'The octree is of kind "{kind}"; only {kinds} can be read.')
    if not is_binary:
        stream = _without_colours(stream, COLOUR_BYTES[kind])
    data, model = np.frombuffer(stream, np.uint8), parameters.model
    room = 4 * data.size if is_binary else data.size // 5 + 1
    corners, sides = np.empty((room, 3), np.int64), np.empty(room, np.int64)
    values = np.empty(room, np.float32)
    voxel_map = VoxelMap(parameters)
    if not data.size:
        return voxel_map
    count, used = read_leaves(data, is_binary, model.low, model.high, corners, sides, values)
    if count == IS_CUT:
        raise MapError(f"The octree is cut after {data.size} bytes; write it again, or copy it whole.")
    if count == IS_TOO_DEEP or used < data.size:
        raise MapError(f"The octree's data make no sense at byte {used}; is this another kind of octree?")
    _fill(voxel_map, corners[:count], sides[:count], values[:count])
    return voxel_map


def _without_colours(stream: bytes, colour_bytes: int) -> bytes:
    """Return the nodes of a full stream as those of an OcTree."""
    if not colour_bytes:
        return stream
    node_bytes = VALUE_BYTES + colour_bytes + 1
    whole = len(stream) // node_bytes * node_bytes
    nodes = np.frombuffer(stream[:whole], np.uint8).reshape(-1, node_bytes)
    return nodes[:, [*range(VALUE_BYTES), -1]].tobytes() + stream[whole:]


def _fill(voxel_map: VoxelMap, corners: np.ndarray, sides: np.ndarray, values: np.ndarray) -> None:
    """Enter leaves into an empty map."""
    if not len(sides):
        return
    if (np.maximum(sides / SIDE, 1.0) ** 3)[sides > SIDE].sum() > TILES_MAX:
        raise MapError("The octree's leaves fill more space than fits into memory; is its file damaged?")
    low, high = corners >> SIDE_BITS, (corners + sides[:, None] - 1) >> SIDE_BITS
    voxel_map.cover(low.min(axis=0), high.max(axis=0) + 1)
    needed = np.zeros(voxel_map.table.shape, bool)
    small = sides <= SIDE
    needed[tuple((low[small] - voxel_map.corner)[:, ::-1].T)] = True
    for first, last in zip(
        (low[~small] - voxel_map.corner).tolist(), (high[~small] - voxel_map.corner + 1).tolist()
    ):
        needed[first[2] : last[2], first[1] : last[1], first[0] : last[0]] = True
    count = np.count_nonzero(needed)
    if count > TILES_MAX:
        raise MapError(f"The octree needs {count} blocks of {SIDE} voxels a side, more than fit into memory.")
    voxel_map.stamp += 1
    voxel_map.table[needed] = voxel_map.pool.take(count, voxel_map.stamp)
    fill_leaves(corners, sides, values, voxel_map.table, voxel_map.corner, voxel_map.pool.tiles.log_odds)
