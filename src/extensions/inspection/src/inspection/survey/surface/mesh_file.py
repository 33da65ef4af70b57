"""Reads a mesh or an SDF world as triangles with the names of the things that they belong to."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from flight_basics.errors import SurveyError
from mesh_files.errors import MeshFileError
from mesh_files.worlds import read_triangles

MOST_TRIANGLES = 2_000_000
ENDLESS_M = 300.0
"""A thing this long is the ground of a world; it does not say how large the room is."""
NOT_SURVEYED = "unknown"
"""Name of a thing that bounds the air and is no surface: what an explored map does not know."""
MAPPED_PLATING, MAPPED_STRUCTURE, MAPPED_BARS = "mapped_plating", "mapped_structure", "mapped_bars"
"""Names of things of sheets that each show their front only: what an explored map knows. Plating is wide, and
between bars one sees through, as between the rungs of a ladder.
"""


def is_mapped(name: str) -> bool:
    """Return whether a thing of this name is what an explored map knows."""
    return name.startswith("mapped")


@dataclass(frozen=True)
class Mesh:
    """triangles_m: (m, 3, 3) corners, map's frame. names: of the things. part: (m,) index of the name."""

    triangles_m: np.ndarray
    names: tuple[str, ...]
    part: np.ndarray

    @property
    def joined(self) -> np.ndarray:
        """(m,) as part, but all that an explored map knows is one thing: its plating ends at no edge."""
        known = np.array([is_mapped(name) for name in self.names])
        return np.where(known[self.part], int(known.argmax()), self.part)

    @property
    def area_m2(self) -> float:
        """Of all faces, each counted once."""
        across = np.cross(*np.moveaxis(self.triangles_m[:, 1:] - self.triangles_m[:, :1], 1, 0))
        return float(0.5 * np.linalg.norm(across, axis=1).sum())

    def bounds_m(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the corners of the box around all but endless ground."""
        kept = np.zeros(len(self.triangles_m), bool)
        for number in range(len(self.names)):
            own = self.part == number
            corners = self.triangles_m[own].reshape(-1, 3)
            kept[own] = np.ptp(corners, axis=0).max() < ENDLESS_M
        corners = self.triangles_m[kept if kept.any() else slice(None)].reshape(-1, 3)
        return corners.min(axis=0), corners.max(axis=0)


def read_mesh(path: Path) -> Mesh:
    """Read an SDF world, or a mesh of the kinds that `mesh_files` knows, in metres, z up.

    Raises:
        SurveyError: the file cannot be read, has no surface, or too many triangles.
    """
    try:
        return Mesh(*read_triangles(path, MOST_TRIANGLES))
    except MeshFileError as error:
        raise SurveyError(f"{path}: {error}.") from None
