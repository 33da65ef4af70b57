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
"""Kind of octree that is written, as OctoMap names it."""
HEADER_MAX = 4096
"""Bytes."""
KEYWORDS = ("id", "size", "res")


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

    Colours and times of an octree's nodes are left out.

    Raises:
        MapError: the file cannot be read, is cut, or holds no octree.
    """
    try:
        content = Path(path).read_bytes()
    except OSError as error:
        raise MapError(f"{path} cannot be read: {reason_of(error)}.") from None
    told, begin = _header(content)
    is_binary = content.startswith(BINARY.encode())
    if not begin or not (is_binary or content.startswith(FULL.encode())):
        raise MapError(
            f"{path} is no octree of OctoMap: it begins with neither of its headers, or ends there."
        )
    resolution_m = _resolution(told.get("res", ""), path)
    settings = dataclasses.replace(parameters or VolumeParameters(), resolution_m=resolution_m)
    try:
        return map_from(content[begin:], is_binary, settings, told.get("id", ""))
    except MapError as error:
        raise MapError(f"{path}: {error}") from None


def _header(content: bytes) -> tuple[dict[str, str], int]:
    """Return what a header tells by keyword, and where the data begin; 0: there are none.

    Blanks and lines are as OctoMap's own `readHeader` takes them: any space parts words, what follows an
    unknown word or # counts up to the line's end, and the data begin in the line after "data".
    """
    told: dict[str, str] = {}
    begin = content.find(b"\n", 0, HEADER_MAX) + 1
    while begin:
        end = content.find(b"\n", begin, HEADER_MAX)
        words = iter(content[begin : max(end, 0)].decode("ascii", "replace").split())
        begin = end + 1
        for word in words:
            if word == "data":
                return told, begin
            if word not in KEYWORDS:
                break
            told[word] = next(words, "")
    return told, 0


def _resolution(text: str, path: str | Path) -> float:
    low, high = RESOLUTIONS_M
    try:
        resolution_m = float(text)
    except ValueError:
        resolution_m = 0.0
    if not low <= resolution_m <= high:
        raise MapError(f'{path} tells no resolution from {low} to {high} m, but "{text}".')
    return resolution_m
