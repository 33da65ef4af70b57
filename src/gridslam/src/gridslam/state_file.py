"""The filter's complete state in one file: an .npz of plain arrays and a JSON header, no pickles."""

from __future__ import annotations

import dataclasses
import json
import os
import zipfile
import zlib
from pathlib import Path

import numpy as np

from gridslam.errors import SlamError, StateError
from gridslam.motion_model import Motion
from gridslam.occupancy_grid import OccupancyGrid
from gridslam.parameters import SlamParameters
from gridslam.scan import PlanarScan
from gridslam.trajectory import TrajectoryTree

FORMAT = 3

DAMAGE = (ArithmeticError, EOFError, LookupError, MemoryError, TypeError, ValueError)
DAMAGE += (zipfile.BadZipFile, zlib.error)
"""What reading a damaged or foreign file may raise."""


def write(slam, path) -> None:
    """Write a GridSlam's state; raises StateError when that fails."""
    path = Path(path)
    arrays = {
        "poses": slam._poses,
        "log_weights": slam._log_weights,
        "log_likelihoods": slam._log_likelihoods,
        **slam._tree.to_arrays(),
        **slam._maps.to_arrays(),
        **_motion_arrays(slam._motion),
        **_scan_arrays(slam._scans),
        **_grid_arrays(slam._starting_map),
        "header": np.array(json.dumps(_header(slam))),
    }
    part = path.with_name(f".{path.name}.part")
    try:
        with open(part, "wb") as stream:
            np.savez_compressed(stream, **arrays)
        os.replace(part, path)
    except OSError as error:
        raise StateError(f"The state cannot be written to {path}: {error.strerror}.") from None
    finally:
        part.unlink(missing_ok=True)


def read(cls, path, threads: int | None = None):
    """Return the GridSlam (``cls``) whose state a file holds; raises StateError when there is none in it.

    With ``threads`` it goes on with so many, and not as many as it was saved with: the result is the same.
    """
    path = Path(path)
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
        header = json.loads(str(arrays["header"]))
        if header["format"] != FORMAT:
            raise StateError(f"{path} is of another version ({header['format']}) of gridslam.")
        if threads is not None:
            header["parameters"]["threads"] = threads
        return _restored(cls, header, arrays)
    except OSError as error:
        raise StateError(f"The state cannot be read from {path}: {error.strerror or error}.") from None
    except StateError:
        raise
    except (*DAMAGE, SlamError) as error:
        raise StateError(f"{path} holds no complete state of gridslam ({error}).") from None


def localises(slam) -> bool:
    """Whether a GridSlam leaves its map as it is."""
    return slam._localisation_only


def hand_over_map(source, target) -> None:
    """Let all particles of one GridSlam have the map of another's best one, which is not used any more."""
    source._maps.resample(np.full(source.parameters.particles, source.best_particle))
    target._maps = source._maps


def _header(slam) -> dict:
    return {
        "format": FORMAT,
        "parameters": dataclasses.asdict(slam.parameters),
        "localisation_only": slam._localisation_only,
        "keep_scans": slam._scans is not None,
        "random": slam._rng.bit_generator.state,
    }


def _restored(cls, header: dict, arrays: dict):
    parameters = SlamParameters(**header["parameters"])
    _require_particles(parameters.particles, arrays)
    slam = cls(
        parameters,
        starting_map=_grid(arrays),
        localisation_only=header["localisation_only"],
        keep_scans=header["keep_scans"],
    )
    slam._poses = arrays["poses"]
    slam._log_weights = arrays["log_weights"]
    slam._log_likelihoods = arrays["log_likelihoods"]
    slam._tree = TrajectoryTree.from_arrays(
        *(arrays[name] for name in ("node_poses", "node_parents", "leaves", "stamps_s"))
    )
    slam._maps.restore(arrays)
    slam._motion = _motion(arrays)
    slam._rng.bit_generator.state = header["random"]
    if header["keep_scans"]:
        slam._scans = _scans(arrays)
        if len(slam._scans) != len(slam._tree.stamps_s):
            raise ValueError("there are not as many scans as stamps")
    return slam


def _require_particles(count: int, arrays: dict) -> None:
    shapes = {"poses": (count, 3), "log_weights": (count,), "log_likelihoods": (count,), "leaves": (count,)}
    for name, shape in shapes.items():
        if arrays[name].shape != shape or not np.isfinite(arrays[name]).all():
            raise ValueError(f"{name} are none of {count} particles")


def _motion_arrays(motion) -> dict:
    if motion is None:
        return {}
    numbers = [motion.stamp_s, motion.distance_m, motion.turned_rad]
    return {"motion": np.concatenate((motion.start, motion.now, motion.deviations, numbers))}


def _motion(arrays: dict):
    if "motion" not in arrays:
        return None
    values = arrays["motion"]
    if values.shape != (12,) or not np.isfinite(values).all():
        raise ValueError("the motion is none")
    motion = Motion(values[0:3], float(values[9]))
    motion.now, motion.deviations = values[3:6].copy(), values[6:9].copy()
    motion.distance_m, motion.turned_rad = float(values[10]), float(values[11])
    return motion


def _scan_arrays(scans) -> dict:
    if not scans:
        return {}
    return {
        "scan_beams": np.array([scan.ranges_m.size for scan in scans]),
        "scan_angles": np.concatenate([scan.angles_rad for scan in scans]),
        "scan_ranges": np.concatenate([scan.ranges_m for scan in scans]),
        "scan_rest": np.array([(scan.stamp_s, *scan.lidar_in_base, scan.range_max_m) for scan in scans]),
    }


def _scans(arrays: dict) -> list[PlanarScan]:
    if "scan_beams" not in arrays:
        return []
    beams = arrays["scan_beams"]
    lengths = arrays["scan_ranges"].size, len(arrays["scan_rest"])
    if (beams < 0).any() or (beams.sum(), len(beams)) != lengths:
        raise ValueError("the scans' beams do not add up")
    ends = np.cumsum(beams)[:-1]
    angles, ranges = np.split(arrays["scan_angles"], ends), np.split(arrays["scan_ranges"], ends)
    return [
        PlanarScan(float(rest[0]), angle, distance, tuple(rest[1:4].tolist()), float(rest[4]))
        for angle, distance, rest in zip(angles, ranges, arrays["scan_rest"])
    ]


def _grid_arrays(grid: OccupancyGrid | None) -> dict:
    if grid is None:
        return {}
    return {"start_cells": grid.cells, "start_place": np.array((grid.resolution_m, *grid.origin_xy_m))}


def _grid(arrays: dict) -> OccupancyGrid | None:
    if "start_cells" not in arrays:
        return None
    resolution, x, y = arrays["start_place"].tolist()
    return OccupancyGrid(arrays["start_cells"], resolution, (x, y))
