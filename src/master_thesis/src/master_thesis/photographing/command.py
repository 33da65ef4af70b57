"""Photographs a world from the poses of a plan: rosrun master_thesis photograph."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Iterator

import numpy as np
import yaml

from inspection_tools.photographs.folder import PhotographFolder, PhotographRecord
from inspection_tools.survey.camera import SurveyCamera, optical_axes
from master_thesis.errors import ScenarioError
from simulation_tools.camera.defects import DefectFile, beside, decals_of, read_defects
from simulation_tools.camera.optics import CameraOptics
from simulation_tools.camera.renderer import Renderer
from simulation_tools.camera.surfaces import surfaces_of
from simulation_tools.geometry import Pose, quaternion_from_matrix
from simulation_tools.sdf.parser import load_world

SECONDS_APART = 1.0
"""Between the stamps of two photographs."""


def read_poses(path: Path) -> list[Pose]:
    """Return the optical frame's poses in the world, from the `photographs` of a YAML file.

    Each has position_m: [x, y, z], yaw_deg (anticlockwise from x) and tilt_deg (0 level, 90 straight up).

    Raises:
        ScenarioError: the file cannot be read, or an entry makes no sense.
    """
    try:
        entries = yaml.safe_load(path.read_text(encoding="utf-8"))["photographs"]
    except OSError as error:
        raise ScenarioError(f"{path}: cannot be read: {error.strerror}.") from None
    except (yaml.YAMLError, KeyError, TypeError, ValueError):
        raise ScenarioError(f"{path}: is no plan; it needs a list called photographs.") from None
    return [_pose(path, number, entry) for number, entry in enumerate(entries or [])]


def _pose(path: Path, number: int, entry: dict) -> Pose:
    try:
        axes = optical_axes(math.radians(float(entry["yaw_deg"])), math.radians(float(entry["tilt_deg"])))
        return Pose.checked(entry["position_m"], quaternion_from_matrix(axes))
    except (KeyError, TypeError, ValueError):
        raise ScenarioError(
            f"{path}: photograph {number} needs position_m: [x, y, z], yaw_deg and tilt_deg, all finite."
        ) from None


def photograph(
    world: Path, poses: list[Pose], folder: Path, camera: SurveyCamera, seed: int
) -> Iterator[Path]:
    """Store a photograph from each pose, and yield its path."""
    path = beside(world)
    marks = read_defects(path) if path.exists() else DefectFile((), {})
    surfaces = surfaces_of(load_world(str(world)), marks.coatings)
    optics = CameraOptics(camera.width, camera.height, camera.field_of_view, exposure_s=camera.exposure)
    renderer = Renderer(surfaces, decals_of(marks.defects, surfaces), optics)
    store, rng = PhotographFolder(folder, camera), np.random.default_rng(seed)
    for number, pose in enumerate(poses):
        shot = renderer.photograph(pose, rng)
        record = PhotographRecord(
            stamp_s=number * SECONDS_APART,
            position_m=pose.position_m,
            orientation_xyzw=pose.orientation_xyzw,
            exposure_s=optics.exposure_s,
            iso=shot.iso,
            lux=shot.lux,
        )
        yield store.save(shot.picture, record)
