"""The filter's complete state in one file: an .npz of plain arrays and a JSON header, no pickles."""

from __future__ import annotations

import dataclasses
import json
import os
import zipfile
import zlib
from pathlib import Path
from typing import Mapping

import numpy as np

from gridslam.errors import SlamError, StateError, reason_of
from gridslam.filter.motion_model import Motion, is_told
from gridslam.filter.particle_filter import GridSlam
from gridslam.filter.state import FilterState
from gridslam.occupancy_grid import OccupancyGrid
from gridslam.parameters import SlamParameters
from gridslam.scan import scans_from_arrays, scans_to_arrays

FORMAT = 9
PIECES, BEFORE = "pieces_", "before_"
"""Prefixes of the arrays of `Pieces`, and of the scan at which the next step begins."""
TREE_ARRAYS = ("node_poses", "node_parents", "leaves", "stamps_s")

DAMAGE = (
    ArithmeticError,
    EOFError,
    LookupError,
    MemoryError,
    TypeError,
    ValueError,
    zipfile.BadZipFile,
    zlib.error,
)
"""The exceptions for a damaged or foreign file."""


def write(state: FilterState, path: str | Path) -> None:
    """Write a filter's state.

    Raises:
        OSError: the file cannot be written.
    """
    arrays = {
        "poses": state.poses,
        "log_weights": state.log_weights,
        "log_likelihoods": state.log_likelihoods,
        **state.tree,
        **state.maps,
        **_prefixed(PIECES, state.pieces),
        **_prefixed(BEFORE, scans_to_arrays([] if state.before is None else [state.before])),
        **_motion_arrays(state.motion),
        **scans_to_arrays(state.scans or ()),
        **_grid_arrays(state.starting_map),
        "header": np.array(json.dumps(_header(state))),
    }
    with open(path, "wb") as stream:
        np.savez_compressed(stream, **arrays)


def read(path: str | Path, threads: int | None = None, name: str | Path | None = None) -> GridSlam:
    """Return the filter whose state a file holds.

    Args:
        path: of the file.
        threads: number for the filter; None: as many as when it was saved. The result does not depend on it.
        name: the file's name in errors; None: its path.

    Raises:
        StateError: the file cannot be read, or holds no complete state.
    """
    told = path if name is None else name
    try:
        with zipfile.ZipFile(path) as packed:
            require_memory(packed)
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
        header = json.loads(str(arrays["header"]))
        if header["format"] != FORMAT:
            raise StateError(
                f"{told} is of another version ({header['format']}) of gridslam, which reads {FORMAT}: begin "
                "anew, or give the map of that run as starting_map."
            )
        if threads is not None:
            header["parameters"]["threads"] = threads
        return GridSlam.from_state(_state(header, arrays))
    except OSError as error:
        raise StateError(f"The state cannot be read from {told}: {reason_of(error)}.") from None
    except StateError:
        raise
    except (*DAMAGE, SlamError) as error:
        raise StateError(f"{told} holds no complete state of gridslam ({error}).") from None


def require_memory(packed: zipfile.ZipFile) -> None:
    """Refuse a file whose unpacked parts do not fit into this machine's memory.

    Raises:
        ValueError: they do not.
    """
    size, memory = sum(part.file_size for part in packed.infolist()), memory_bytes()
    if size > memory:
        raise ValueError(f"it claims {size / 1e9:.1f} GB, more than this machine's {memory / 1e9:.1f} GB")


def memory_bytes() -> int:
    """Return how much memory this machine has."""
    return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")


def _header(state: FilterState) -> dict:
    return {
        "format": FORMAT,
        "parameters": dataclasses.asdict(state.parameters),
        "localisation_only": state.localisation_only,
        "keep_scans": state.scans is not None,
        "random": state.random,
    }


def _state(header: dict, arrays: dict) -> FilterState:
    parameters = SlamParameters(**header["parameters"])
    _require_particles(parameters.particles, arrays)
    return FilterState(
        parameters,
        _grid(arrays),
        header["localisation_only"],
        arrays["poses"],
        arrays["log_weights"],
        arrays["log_likelihoods"],
        {name: arrays[name] for name in TREE_ARRAYS},
        arrays,
        _without_prefix(PIECES, arrays),
        _motion(arrays),
        next(iter(scans_from_arrays(_without_prefix(BEFORE, arrays))), None),
        scans_from_arrays(arrays) if header["keep_scans"] else None,
        header["random"],
    )


def _prefixed(prefix: str, arrays: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    return {prefix + name: values for name, values in arrays.items()}


def _without_prefix(prefix: str, arrays: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    return {name[len(prefix) :]: arrays[name] for name in arrays if name.startswith(prefix)}


def _require_particles(count: int, arrays: dict) -> None:
    shapes = {"poses": (count, 3), "log_weights": (count,), "log_likelihoods": (count,), "leaves": (count,)}
    for name, shape in shapes.items():
        if arrays[name].shape != shape or not np.isfinite(arrays[name]).all():
            raise ValueError(f"{name} do not fit {count} particles")


def _motion_arrays(motion: Motion | None) -> dict:
    if motion is None:
        return {}
    numbers = [motion.stamp_s, motion.distance_m, motion.turned_rad]
    return {
        "motion": np.concatenate(
            (motion.start, motion.now, motion.deviations, numbers, motion.tried, [motion.due], motion.told)
        ),
        "motion_start_covariance": _optional(motion.start_covariance),
        "motion_covariance": _optional(motion.covariance),
    }


def _optional(covariance: np.ndarray | None) -> np.ndarray:
    return np.empty((0, 3, 3)) if covariance is None else np.array([covariance])


def _motion(arrays: dict) -> Motion | None:
    if "motion" not in arrays:
        return None
    values = arrays["motion"]
    if values.shape != (19,) or not np.isfinite(values).all():
        raise ValueError("the motion is not 19 finite numbers")
    start_covariance, covariance = (
        arrays[name][0] if len(arrays[name]) else None
        for name in ("motion_start_covariance", "motion_covariance")
    )
    if not all(each is None or is_told(each) for each in (start_covariance, covariance)):
        raise ValueError("the motion's covariances are none")
    motion = Motion(values[0:3], float(values[9]), start_covariance)
    motion.covariance = covariance
    motion.now, motion.deviations = values[3:6].copy(), values[6:9].copy()
    motion.distance_m, motion.turned_rad = float(values[10]), float(values[11])
    motion.tried, motion.due, motion.told = values[12:15].copy(), bool(values[15]), values[16:19].copy()
    return motion


def _grid_arrays(grid: OccupancyGrid | None) -> dict:
    if grid is None:
        return {}
    return {"start_cells": grid.cells, "start_place": np.array((grid.resolution_m, *grid.origin_xy_m))}


def _grid(arrays: dict) -> OccupancyGrid | None:
    if "start_cells" not in arrays:
        return None
    resolution, x, y = arrays["start_place"].tolist()
    return OccupancyGrid(arrays["start_cells"], resolution, (x, y))
