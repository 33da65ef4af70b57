"""OctoMap's files: .bt, in which voxels are free or occupied, and .ot with their log-odds."""

from __future__ import annotations

import dataclasses
from pathlib import Path

from gridslam.errors import MapError, reason_of
from gridslam.files.replacing import replace_file
from gridslam.volume.octree.stream import OctreeStream, map_from
from gridslam.volume.parameters import RESOLUTIONS_M, VolumeParameters
from gridslam.volume.voxel_map import VoxelMap

BINARY, FULL = "# Octomap OcTree binary file", "# Octomap OcTree file"
"""First lines."""
TREE = "OcTree"
"""Kind of octree, as OctoMap names it."""
HEADER_MAX = 4096
"""Bytes."""


def write_octree(path: str | Path, octree: OctreeStream, resolution_m: float) -> None:
    """Write a file that OctoMap's library and its tools read. It replaces an older one when it is complete.

    Raises:
        MapError: it cannot be written.
    """
    first = BINARY if octree.is_binary else FULL
    header = f"{first}\n# written by gridslam\n#\nid {TREE}\nsize {octree.nodes}\nres {resolution_m}\ndata\n"
    try:
        replace_file(path, header.encode() + octree.data)
    except OSError as error:
        raise MapError(f"{path} cannot be written: {reason_of(error)}.") from None


def read_octree(path: str | Path, parameters: VolumeParameters | None = None) -> VoxelMap:
    """Return the map in a file. Its resolution counts, and the sensor model of the parameters.

    Raises:
        MapError: the file cannot be read, is cut, or holds no octree.
    """
    try:
        content = Path(path).read_bytes()
    except OSError as error:
        raise MapError(f"{path} cannot be read: {reason_of(error)}.") from None
    end = content.find(b"\ndata\n", 0, HEADER_MAX)
    first, _, rest = content[: max(end, 0)].decode("ascii", "replace").partition("\n")
    if end < 0 or first not in (BINARY, FULL):
        raise MapError(
            f"{path} is no octree of OctoMap: it begins with neither of its headers, or ends there."
        )
    told = dict(line.split(None, 1) for line in rest.splitlines() if line[:1] != "#" and " " in line)
    if told.get("id", "").strip() != TREE:
        raise MapError(f'{path} holds a tree of kind "{told.get("id", "")}"; only {TREE} can be read.')
    resolution_m = _resolution(told.get("res", ""), path)
    settings = dataclasses.replace(parameters or VolumeParameters(), resolution_m=resolution_m)
    try:
        return map_from(content[end + len(b"\ndata\n") :], first == BINARY, settings)
    except MapError as error:
        raise MapError(f"{path}: {error}") from None


def _resolution(text: str, path: str | Path) -> float:
    low, high = RESOLUTIONS_M
    try:
        resolution_m = float(text)
    except ValueError:
        resolution_m = 0.0
    if not low <= resolution_m <= high:
        raise MapError(f'{path} tells no resolution from {low} to {high} m, but "{text}".')
    return resolution_m
