"""Reads what is to be surveyed from a file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Sequence

import numpy as np

from flight_basics.errors import SurveyError
from inspection.survey.parameters import SurveyParameters
from inspection.survey.surface.mesh_file import Mesh, read_mesh
from inspection.survey.surface.of_mesh import patches_of_mesh, room_of_mesh
from inspection.survey.surface.patches import Patches
from inspection.survey.surface.rays import Rays
from inspection.survey.surface.room import Room
from inspection.survey.surface.samples import Samples
from inspection.survey.views.candidates import Ranges


@dataclass(frozen=True)
class Surface:
    """The room, the patches, and rays through what hides.

    mesh: as read. samples: of the triangles `near` (m,) of it that reach into the room.
    """

    room: Room
    patches: Patches
    ranges_m: Ranges
    mesh: Mesh
    samples: Samples
    near: np.ndarray

    @property
    def figures(self) -> dict[str, float]:
        """What a plan tells of the choice of the room: of the whole mesh, of this room, and of the others."""
        own, *others = self.room.regions or (None,)
        return {
            "mesh_m2": self.mesh.area_m2,
            "room_m3": 0.0 if own is None else own.flyable_m3,
            "other_rooms": float(len(others)),
            "largest_other_room_m3": max((each.flyable_m3 for each in others if each), default=0.0),
        }


def read_surface(path: Path, asked: SurveyParameters, home_m: Sequence[float] | None = None) -> Surface:
    """Read a mesh or an SDF world.

    Raises:
        SurveyError: the file cannot be used, or the UAV fits nowhere in it.
    """
    home = None if home_m is None else np.asarray(home_m, float)
    if home is not None and not np.isfinite(home).all():
        raise SurveyError("The home is not three finite numbers.")
    mesh = read_mesh(path)
    room, samples, near = room_of_mesh(mesh, asked, home)
    patches = patches_of_mesh(mesh, room, samples, near, asked)
    return Surface(room, patches, Rays(mesh.triangles_m[near]).ranges_m, mesh, samples, near)


def read_room(path: Path, asked: SurveyParameters, home_m: Sequence[float] | None = None) -> Room:
    """Read only the room of a mesh or an SDF world; raises SurveyError as `read_surface`."""
    return room_of_mesh(read_mesh(path), asked, None if home_m is None else np.asarray(home_m, float))[0]
