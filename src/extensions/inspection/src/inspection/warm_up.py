"""Compiles planners, explorer and findings ahead of use: ``python -m inspection.warm_up``."""

from __future__ import annotations

import time

import numpy as np
import trimesh

from exploration.warm_up import warm_up_exploration
from inspection.findings.parameters import FindingParameters
from inspection.findings.picture.candidates import candidates_in
from inspection.survey.parameters import SurveyParameters
from inspection.survey.planner import SurveyPlanner
from inspection.survey.surface.mesh_file import Mesh
from inspection.survey.surface.of_mesh import patches_of_mesh, room_of_mesh
from inspection.survey.surface.rays import Rays


def warm_up() -> float:
    """Plan, explore, survey and look at a picture, all small; return the seconds that it took."""
    start = time.perf_counter()
    rough = np.random.default_rng(1).integers(20, 240, (64, 64, 1)).astype(np.uint8)
    candidates_in(np.repeat(rough, 3, axis=2), FindingParameters(), detail_mm=0.5)
    rusty = rough * np.array([[[0.9, 0.4, 0.2]]])
    candidates_in(rusty.astype(np.uint8), FindingParameters().for_pictures())
    _survey()
    warm_up_exploration()
    return time.perf_counter() - start


def _survey() -> None:
    """Plan the survey of a closed room."""
    box = trimesh.creation.box((5.0, 4.0, 3.0))
    mesh = Mesh(np.asarray(box.triangles), ("room",), np.zeros(len(box.faces), np.int64))
    asked = SurveyParameters(voxel=0.25, patch=1.0, spacing=1.5)
    room, samples, near = room_of_mesh(mesh, asked)
    patches = patches_of_mesh(mesh, room, samples, near, asked)
    planner = SurveyPlanner(room, patches, Rays(mesh.triangles_m).ranges_m, asked=asked)
    for _ in planner.improve(search_s=0.0, bound=False):
        pass


if __name__ == "__main__":
    print(f"The planners' kernels are ready after {warm_up():.1f} s.")
