"""Photographs a world from the poses of a survey plan: rosrun flights photograph."""

from __future__ import annotations

from pathlib import Path
from typing import Iterator

import numpy as np

from inspection.camera.survey_camera import SurveyCamera, optical_axes
from inspection.photographs.folder import PhotographFolder
from inspection.photographs.record import PhotographRecord
from inspection.survey.plan import SurveyPlan
from simulation_tools.camera.defects import decals_of, defects_in
from simulation_tools.camera.effects.amounts import Effects
from simulation_tools.camera.optics import CameraOptics
from simulation_tools.camera.renderer import Renderer
from simulation_tools.camera.surfaces import surfaces_of
from simulation_tools.geometry import Pose, quaternion_from_matrix
from simulation_tools.sdf.parser import load_world

SECONDS_APART = 1.0
"""Between the stamps of two photographs."""


def poses_of(plan: SurveyPlan) -> list[Pose]:
    """Return the optical frame's poses in the world, photograph by photograph."""
    axes = [optical_axes(view.yaw_rad, view.tilt_rad) for view in plan.views]
    return [Pose.checked(view.place_m, quaternion_from_matrix(each)) for view, each in zip(plan.views, axes)]


def photograph(
    world: Path,
    poses: list[Pose],
    folder: Path,
    camera: SurveyCamera,
    seed: int,
    defects: Path | None = None,
    detail_m: float = 0.0,
    effects: Effects | None = None,
) -> Iterator[Path]:
    """Store a photograph from each pose, and yield its path. A folder with photographs is continued.

    defects: file of them; None: the one beside the world, if there is one. detail_m: what a pixel covers at
    most of what the photographs are to show, by which they are exposed; 0: all that is in them counts.
    effects: that the photographs show; None: those of the file of defects.
    """
    marks, _ = defects_in(world, defects)
    surfaces = surfaces_of(load_world(str(world)), marks.coatings)
    optics = CameraOptics(camera.width, camera.height, camera.field_of_view, exposure_s=camera.exposure)
    renderer = Renderer(surfaces, decals_of(marks.defects, surfaces), optics, effects or marks.effects)
    store, rng = PhotographFolder(folder, camera), np.random.default_rng(seed)
    start_s = 0.0 if store.last_stamp_s is None else store.last_stamp_s + SECONDS_APART
    for number, pose in enumerate(poses):
        shot = renderer.photograph(pose, rng, detail_m)
        record = PhotographRecord(
            stamp_s=start_s + number * SECONDS_APART,
            position_m=pose.position_m,
            orientation_xyzw=pose.orientation_xyzw,
            exposure_s=optics.exposure_s,
            iso=shot.iso,
            lux=shot.lux,
        )
        yield store.save(shot.picture, record)
