"""Where the photographs of a plan would place rust on a map. No pixel is drawn: a spot is an ellipse."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Sequence

import numpy as np

from benchmarks.inspection_rows.hold import ASKED, WORLD
from flights.inspecting.findings_judge import NEAR_M, disturbed, shows
from flights.worlds.defects import write_defects
from inspection.camera.survey_camera import SurveyCamera
from inspection.findings.merging import merged
from inspection.findings.parameters import FindingParameters
from inspection.findings.picture.candidates import Candidate
from inspection.findings.placing import MeshSurface, Placed, PosedPhotograph
from inspection.findings.several_views import where_sights_cross
from inspection.survey.plan import SurveyPlan
from inspection.survey.poses import PhotographPose
from inspection.survey.surface.mesh_file import Mesh
from simulation_tools.camera.defects import Defect, read_defects

OFF_M, OFF_DEG = 0.025, 0.3
"""Of the poses, medians: 0.02 m in flights with SLAM, and a larger angle than theirs."""
HIDDEN_M = 0.03
"""A place that is so far from where its ray ends is hidden."""
INSIDE = np.array(
    [(u, v) for u in np.linspace(-1, 1, 11) for v in np.linspace(-1, 1, 11) if u * u + v * v <= 1]
)
"""Places of an ellipse, as shares of its half length and half width."""


def place_rust(plan: SurveyPlan, on: Mesh, true: Mesh, seed: int) -> dict:
    """Return how many spots of a seeded world are shown and found, and how many findings are false.

    on: mesh of the map. true: of the drawing.
    """
    with tempfile.TemporaryDirectory() as name:
        marks = Path(name) / "defects.yaml"
        write_defects(WORLD, marks, seed)
        defects = read_defects(marks).defects
    spots = [each for each in defects if each.kind == "rust"]
    taken = [PhotographPose.of_view(each) for each in plan.views]
    surface, p = MeshSurface(true.triangles_m), FindingParameters().for_mesh(on)
    placed = _placed(spots, taken, plan.camera, surface, MeshSurface(on.triangles_m), p, seed)
    findings = merged(where_sights_cross(placed, p.crossing, p.distance), p.apart)
    shown = [
        k for k, spot in enumerate(spots) if any(shows(t, spot, plan.camera, ASKED, surface) for t in taken)
    ]
    told_m, true_m = (np.array([each.position_m for each in all_]) for all_ in (findings, spots))
    off_m = np.linalg.norm(told_m[:, None] - true_m[None], axis=2)
    nearest_m = off_m.min(axis=1)
    return {
        "shown": len(shown),
        "found": int((off_m[:, shown].min(axis=0) < NEAR_M).sum()),
        "false": int((nearest_m >= NEAR_M).sum()),
        "off_p95_m": float(np.percentile(nearest_m[nearest_m < NEAR_M], 95)),
    }


def _placed(
    spots: Sequence[Defect],
    taken: Sequence[PhotographPose],
    camera: SurveyCamera,
    true: MeshSurface,
    on: MeshSurface,
    parameters: FindingParameters,
    seed: int,
) -> list[Placed]:
    """Return what photographs with disturbed poses place on a map."""
    rng, placed = np.random.default_rng(seed), []
    for number, each in enumerate(taken):
        told = disturbed(each, rng, OFF_M, OFF_DEG)
        posed = PosedPhotograph(on, camera, told, parameters, str(number))
        seen = [_seen(spot, each, camera, true) for spot in spots]
        found = [posed.place(candidate) for candidate in seen if candidate is not None]
        placed += [each for each in found if each is not None]
    return placed


def _seen(spot: Defect, taken: PhotographPose, camera: SurveyCamera, true: MeshSurface) -> Candidate | None:
    """Return a spot in a photograph, as far as it is in the picture and nothing hides it."""
    along, across = np.array(spot.along), np.cross(spot.normal, spot.along)
    halves_m = 0.5 * np.array((spot.length_m, spot.width_m))
    points_m = np.array(spot.position_m) + (INSIDE * halves_m) @ np.array((along, across))
    pixels, seen = camera.drawn((points_m - taken.place_m) @ taken.axes)
    if not seen.any():
        return None
    far_m = np.linalg.norm(points_m - taken.place_m, axis=1)
    rays = (points_m - taken.place_m) / far_m[:, None]
    seen &= np.linalg.norm(true.hits(taken.place_m, rays)[0] - points_m, axis=1) < HIDDEN_M
    steep = -float(rays.mean(axis=0) @ np.array(spot.normal))
    if not seen.any() or steep <= 0.0:
        return None
    size_px = np.pi * halves_m.prod() * seen.mean() * (camera.focal_px / far_m.mean()) ** 2 * steep
    return Candidate("rust", pixels[seen], max(int(size_px), int(seen.sum())))
