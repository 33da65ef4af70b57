"""The surface with what photographs showed of it: written beside the coverage record, read by the report."""

from __future__ import annotations

import io
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from flight_basics.errors import SurveyError
from inspection.files.whole import write_whole

NEIGHBOURS = 8
MOST = 0.5
"""Of a patch that counts as shown where it must count as a whole."""
ALIKE = 0.5
"""Least cosine between the normals of a place and of its patch."""


@dataclass(frozen=True)
class SurfaceRecord:
    """Patches of the surface, as `survey.surface.patches.Patches` has them.

    points_m, normals: (n, 3) in the map, normals to the air. areas_m2: (n,). parts: (n,) index in names.
    shown, reachable: (n,) share of the patch, 0..1, that some photograph shows, and that a UAV could have
    shown. side_m: of a patch.
    """

    points_m: np.ndarray
    normals: np.ndarray
    areas_m2: np.ndarray
    parts: np.ndarray
    names: tuple[str, ...]
    shown: np.ndarray
    reachable: np.ndarray
    side_m: float

    @property
    def shown_m2(self) -> np.ndarray:
        """(n,) area of each patch that a photograph shows."""
        return self.areas_m2 * self.shown

    @property
    def open_m2(self) -> np.ndarray:
        """(n,) area of each patch that is within reach, and that no photograph shows."""
        return self.areas_m2 * np.maximum(self.reachable - self.shown, 0.0)

    @property
    def is_shown(self) -> np.ndarray:
        """(n,) whether photographs show most of a patch."""
        most: np.ndarray = self.shown >= MOST
        return most

    @cached_property
    def _tree(self) -> cKDTree:
        return cKDTree(self.points_m)

    def patches_at(
        self, points_m: np.ndarray, normals: np.ndarray | None, within_m: float | None = None
    ) -> np.ndarray:
        """Return (k,) the nearest patch to places (k, 3) that faces the same way; -1: none within_m.

        normals: (k, 3); None: patches that face any way count.
        """
        if not len(points_m):
            return np.zeros(0, int)
        reach = 1.5 * self.side_m if within_m is None else within_m
        count = 1 if normals is None else NEIGHBOURS
        _, near = self._tree.query(points_m, k=[*range(1, count + 1)], distance_upper_bound=reach)
        there = near < len(self.points_m)
        near = np.where(there, near, 0)
        if normals is not None:
            there &= (self.normals[near] * np.asarray(normals)[:, None]).sum(axis=2) > ALIKE
        first = there.argmax(axis=1)
        return np.where(there.any(axis=1), near[np.arange(len(near)), first], -1)


def surface_record_bytes(record: SurfaceRecord) -> bytes:
    """Return a record as the content of an NPZ file."""
    content = io.BytesIO()
    origin_m = np.rint(record.points_m.mean(axis=0))  # float32 tells places 100 km away to 8 mm only
    np.savez_compressed(
        content,
        points_m=(record.points_m - origin_m).astype(np.float32),
        origin_m=origin_m,
        normals=np.rint(127 * record.normals).astype(np.int8),
        areas_m2=record.areas_m2.astype(np.float32),
        parts=record.parts.astype(np.uint16),
        names=np.array(record.names),
        shown=record.shown.astype(np.float32),
        reachable=record.reachable.astype(np.float32),
        side_m=record.side_m,
    )
    return content.getvalue()


def write_surface_record(path: Path, record: SurfaceRecord) -> None:
    """Write a record as NPZ, whole or not at all.

    Raises:
        SurveyError: the file cannot be written.
    """
    try:
        write_whole({path: surface_record_bytes(record)})
    except OSError as error:
        raise SurveyError(f"{path} cannot be written: {error.strerror}.") from None


def read_surface_record(path: Path) -> SurfaceRecord:
    """Read a record.

    Raises:
        SurveyError: the file cannot be read or is damaged.
    """
    try:
        with np.load(path, allow_pickle=False) as held:
            normals = held["normals"].astype(float)
            length = np.linalg.norm(normals, axis=1)[:, None]
            record = SurfaceRecord(
                held["points_m"].astype(float) + held.get("origin_m", 0.0),
                normals / np.maximum(length, 1.0),
                held["areas_m2"].astype(float),
                held["parts"].astype(int),
                tuple(str(each) for each in held["names"]),
                held["shown"].astype(float),
                held["reachable"].astype(float),
                float(held["side_m"]),
            )
        columns = (record.normals, record.areas_m2, record.parts, record.shown, record.reachable)
        if (
            any(len(each) != len(record.points_m) for each in columns)
            or not np.isin(record.parts, np.arange(len(record.names))).all()
        ):
            raise ValueError("its columns do not fit each other")
        return record
    except Exception as error:  # numpy and zipfile raise many kinds for a file that is cut
        raise SurveyError(f"{path}: is no record of a surface ({type(error).__name__}: {error}).") from None
