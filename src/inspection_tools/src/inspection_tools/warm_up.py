"""Compiles planners, explorer and findings ahead of use: ``python -m inspection_tools.warm_up``."""

from __future__ import annotations

import time

import numpy as np
import trimesh

from inspection_tools.errors import NoPathError
from inspection_tools.exploration.explorer import Explorer
from inspection_tools.exploration.parameters import ExplorerParameters
from inspection_tools.findings.candidates import candidates_in
from inspection_tools.findings.parameters import FindingParameters
from inspection_tools.planning.planner import PathPlanner
from inspection_tools.planning.voxel_grid import FREE, OCCUPIED
from inspection_tools.survey.parameters import SurveyParameters
from inspection_tools.survey.planner import SurveyPlanner
from inspection_tools.survey.surface.mesh_file import Mesh
from inspection_tools.survey.surface.of_mesh import Sight, patches_of_mesh, room_of_mesh

SIDE = 16


def warm_up() -> float:
    """Plan, explore, survey and look at a picture, all small; return the seconds that it took."""
    start = time.perf_counter()
    candidates_in(np.full((32, 32, 3), 100, np.uint8), FindingParameters())
    _survey()
    planner = PathPlanner()
    kinds = np.full((SIDE, SIDE, SIDE), FREE, np.uint8)
    planner.update_map(0.2, SIDE, np.zeros((1, 3), np.int64), kinds.reshape(1, -1))
    planner.is_clear(planner.plan(np.array((0.9, 1.5, 1.5)), np.array((2.1, 1.5, 1.5))).points_m)
    for parameters in (ExplorerParameters(), ExplorerParameters(rate_min=1e3, reach=0.5)):  # it sees nothing
        Explorer(parameters).decide(planner.space(0.0, np.array((0.9, 1.5, 1.5))), np.array((0.9, 1.5, 1.5)))
    kinds[:, :, SIDE // 2] = OCCUPIED
    planner.update_map(0.2, SIDE, np.zeros((1, 3), np.int64), kinds.reshape(1, -1))
    try:
        planner.plan(np.array((0.75, 1.5, 1.5)), np.array((2.35, 1.5, 1.5)))
    except NoPathError:
        return time.perf_counter() - start
    raise AssertionError("a path leads through a wall")


def _survey() -> None:
    """Plan the survey of a closed room."""
    box = trimesh.creation.box((5.0, 4.0, 3.0))
    mesh = Mesh(np.asarray(box.triangles), ("room",), np.zeros(len(box.faces), np.int64))
    asked = SurveyParameters(voxel=0.25, patch=1.0, spacing=1.5)
    room, samples, near = room_of_mesh(mesh, asked)
    patches = patches_of_mesh(mesh, room, samples, near, asked)
    planner = SurveyPlanner(room, patches, Sight(mesh.triangles_m).ranges_m, asked=asked)
    for _ in planner.improve(search_s=0.0, bound=False):
        pass


if __name__ == "__main__":
    print(f"The planners' kernels are ready after {warm_up():.1f} s.")
