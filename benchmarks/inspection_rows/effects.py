"""What is found in photographs that look like those of a real hold: with each effect, and with all."""

from __future__ import annotations

import json
import tempfile
import time
from pathlib import Path
from typing import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.inspection_rows.found import OFF_DEG, OFF_M
from benchmarks.inspection_rows.hold import ASKED, WORLD
from flights.inspecting.findings_judge import count_found, disturbed, shows
from flights.photographing.command import photograph
from flights.worlds.defects import write_defects
from inspection.camera.photograph_pose import PhotographPose
from inspection.camera.survey_camera import SurveyCamera, optical_axes
from inspection.findings.parameters import FindingParameters
from inspection.findings.placing import MeshSurface
from inspection.findings.search import find
from inspection.photographs.listing import photographs_in
from inspection.survey.surface.mesh_file import read_mesh
from simulation_tools.camera.defects import Defect, read_defects
from simulation_tools.camera.effects.amounts import EFFECTS, Effects, effects_in
from simulation_tools.camera.metering import asked_m2
from simulation_tools.geometry import Pose, quaternion_from_matrix

NAMES = ("none", *EFFECTS, "all")
SEEDS = (23,)
"""Of defects, effects and poses. `findings` was developed with the seeds 1 and 7."""
SHARE = 0.5
"""Of the marks that a world has."""
AWAY_M, TURN_DEG = (1.4, 2.2), 25.0
"""Of a camera before a mark; and how far it is aside of the mark's normal, at most."""
MOST, BRIEF_MOST = 12, 2
"""Photographs for each effect."""
RAYS = 32
"""Along each side of a picture, by which the area is measured that it shows."""


def look(seed: int, most: int, names: Sequence[str]) -> dict[str, dict]:
    """Photograph the same places with each effect that is named, and look for the defects there.

    Poses that `findings` is told are off as in the row findings. Return the counts by the effects' names.
    """
    camera, rows = SurveyCamera(), {}
    mesh = read_mesh(WORLD)
    with tempfile.TemporaryDirectory() as name:
        marks = Path(name) / "defects.yaml"
        write_defects(WORLD, marks, seed, SHARE)
        defects, surface = read_defects(marks).defects, MeshSurface(mesh.triangles_m)
        taken = before_marks(defects, surface, camera, most, np.random.default_rng(seed))
        area_m2 = sum(shown_m2(each, surface, camera) for each in taken)
        for effect in names:
            folder = Path(name) / effect
            _shoot(taken, camera, folder, marks, _effects(effect, seed), seed)
            began_s = time.process_time()
            found = find([folder], mesh, FindingParameters())
            cpu_s = time.process_time() - began_s
            told = count_found(found, defects, taken, camera, ASKED, surface, area_m2)
            kinds = [each.kind for each in told.false]
            rows[effect] = {
                **{
                    key: {"found": each.found, "shown": each.shown}
                    for key, each in (
                        ("rust", told.rust),
                        ("cracks", told.cracks),
                        ("wide_cracks", told.wide_cracks),
                    )
                },
                "false": {"rust": kinds.count("rust"), "cracks": kinds.count("crack")},
                "false_of_each": _of_each(told.false, [path.name for path in photographs_in(folder)]),
                "area_m2": area_m2,
                "photographs": len(taken),
                "cpu_s": cpu_s,
            }
    return rows


def _of_each(false: Sequence, names: Sequence[str]) -> list[int]:
    """Return how many false findings each photograph has part in."""
    return [sum(name in finding.photographs for finding in false) for name in names]


def _effects(name: str, seed: int) -> Effects:
    words = "" if name == "none" else "all=0.6" if name == "all" else name
    return effects_in(f"{words} seed={seed}")


def before_marks(
    defects: Sequence[Defect],
    surface: MeshSurface,
    camera: SurveyCamera,
    most: int,
    rng: np.random.Generator,
) -> list[PhotographPose]:
    """Return poses of cameras that see a mark each, rust and cracks in turn: one before each, as drawn."""
    taken = list[PhotographPose]()
    by_kind = [[each for each in defects if each.kind == kind] for kind in ("rust", "crack")]
    for pair in zip(*by_kind):
        for defect in pair:
            view = _before(defect, rng)
            if len(taken) < most and shows(view, defect, camera, ASKED, surface):
                taken.append(view)
    return taken


def _before(defect: Defect, rng: np.random.Generator) -> PhotographPose:
    """Return a camera before a mark, turned aside, that looks at a place near it."""
    normal = np.array(defect.normal)
    aside = np.array(defect.along) * rng.uniform(-1.0, 1.0) + np.cross(normal, defect.along) * rng.uniform(
        -1.0, 1.0
    )
    way = normal + np.tan(np.radians(TURN_DEG)) / np.sqrt(2.0) * aside
    place_m = np.array(defect.position_m) + rng.uniform(*AWAY_M) * way / np.linalg.norm(way)
    ahead = np.array(defect.position_m) + rng.uniform(-0.3, 0.3, 3) - place_m
    tilt = np.arctan2(ahead[2], np.hypot(ahead[0], ahead[1]))
    return PhotographPose(place_m, optical_axes(float(np.arctan2(ahead[1], ahead[0])), float(tilt)))


def shown_m2(taken: PhotographPose, surface: MeshSurface, camera: SurveyCamera) -> float:
    """Return the area that a photograph shows as finely as it is asked for, m2."""
    across, down = ((np.arange(RAYS) + 0.5) / RAYS * size - 0.5 for size in (camera.width, camera.height))
    x, y = (each.ravel() for each in np.meshgrid(across, down))
    aside = (np.column_stack((x, y)) - camera.centre_px) / camera.focal_px
    slants = np.hypot(1.0, np.hypot(*aside.T))
    rays = np.column_stack((aside, np.ones(len(x)))) @ taken.axes.T / slants[:, None]
    hits_m, normals = surface.hits(taken.place_m, rays)
    met = np.isfinite(hits_m).all(axis=1)
    facing = np.abs(np.einsum("ij,ij->i", normals, rays))[met]
    depths_m = np.linalg.norm(hits_m - taken.place_m, axis=1)[met] / slants[met]
    areas_m2 = asked_m2(depths_m, slants[met], facing, camera.focal_px, 1e-3 * ASKED.resolution)
    steep = facing >= np.cos(np.radians(ASKED.incidence))
    return float(areas_m2[steep].sum()) * camera.width * camera.height / RAYS**2


def _shoot(
    taken: Sequence[PhotographPose],
    camera: SurveyCamera,
    folder: Path,
    marks: Path,
    effects: Effects,
    seed: int,
) -> None:
    """Store photographs from true poses. Their files tell disturbed ones, the same with each effect."""
    poses = [Pose.checked(tuple(each.place_m), quaternion_from_matrix(each.axes)) for each in taken]
    for _ in photograph(WORLD, poses, folder, camera, seed, marks, 1e-3 * ASKED.resolution, effects):
        pass
    rng = np.random.default_rng(seed)
    for path, true in zip(photographs_in(folder), taken):
        told, record = disturbed(true, rng, OFF_M, OFF_DEG), json.loads(path.with_suffix(".json").read_text())
        record["position_m"] = told.place_m.tolist()
        record["orientation_xyzw"] = Rotation.from_matrix(told.axes).as_quat().tolist()
        path.with_suffix(".json").write_text(json.dumps(record))


def summary(rows: Sequence[dict]) -> dict:
    """Return what all seeds together have of one effect."""
    area_m2 = sum(row["area_m2"] for row in rows)
    of_each = [count for row in rows for count in row["false_of_each"]]
    counts = {
        key: {what: sum(row[key][what] for row in rows) for what in ("found", "shown")}
        for key in ("rust", "cracks", "wide_cracks")
    }
    return {
        **counts,
        **{
            f"false_{kind}_per_100_m2": 100.0 * sum(row["false"][kind] for row in rows) / max(area_m2, 1e-9)
            for kind in ("rust", "cracks")
        },
        "false_a_picture": float(np.mean(of_each)),
        "false_of_the_worst": max(of_each),
        "area_m2": area_m2,
        "photographs": len(of_each),
        "cpu_s": sum(row["cpu_s"] for row in rows),
    }
