"""What is found in the photographs of a plan, which are drawn where defects are."""

from __future__ import annotations

import json
import tempfile
import time
from dataclasses import replace
from pathlib import Path
from typing import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.inspection_rows.hold import ASKED, HOME_M, WORLD
from benchmarks.inspection_rows.parts import only
from flights.inspecting.findings_judge import JudgedFindings, disturbed, judge_findings, shows
from flights.photographing.command import photograph, poses_of
from flights.worlds.defects import write_defects
from inspection.findings.parameters import FindingParameters
from inspection.findings.placing import MeshSurface
from inspection.findings.search import find
from inspection.photographs.listing import photographs_in
from inspection.survey.closer import closer_plan
from inspection.survey.plan import SurveyPlan
from inspection.survey.planner import SurveyPlanner
from inspection.survey.poses import PhotographPose
from inspection.survey.surface.of_mesh import patches_of_mesh
from inspection.survey.surface.reading import read_surface
from inspection.survey.views.candidates import View
from simulation_tools.camera.defects import Defect, read_defects

SEEDS = (21, 22)
"""The finder was developed on the defects of the seeds 1 and 7."""
SEARCH_S = 0.0
CLOSER_MM = 0.3
OFF_M, OFF_DEG = 0.006, 0.33
MOST, BRIEF_MOST = 1000, 3
"""Photographs of each look."""


def look(seed: int, most: int) -> dict:
    """Photograph a world with the defects of a seed, look for them, and look again from nearer."""
    surface, rng = read_surface(WORLD, ASKED, HOME_M), np.random.default_rng(seed)
    planner = SurveyPlanner(surface.room, surface.patches, surface.ranges_m, asked=ASKED, source=str(WORLD))
    *_, whole = (each.plan for each in planner.improve(seed, SEARCH_S, bound=False))
    patches = patches_of_mesh(
        surface.mesh, surface.room, surface.samples, surface.near, replace(ASKED, patch=0.5 * ASKED.patch)
    )
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        marks = folder / "defects.yaml"
        write_defects(WORLD, marks, seed)
        defects = read_defects(marks).defects
        views = _views_of(defects, whole, MeshSurface(surface.mesh.triangles_m), rng)[:most]
        taken = shoot(WORLD, only(whole, views), folder / "first", marks, seed, rng)

        def judged(*folders: str) -> tuple[dict, list]:
            began_s = time.process_time()
            found = find([folder / each for each in folders], WORLD, FindingParameters())
            cpu_s = time.process_time() - began_s
            told = judge_findings(found, defects, taken, whole.camera, ASKED, surface.mesh, patches)
            return _row(told, len(taken), cpu_s), found

        row, found = judged("first")
        rows = {"findings": row}
        cracks = [each for each in found if each.kind == "crack"][:most]
        if cracks:
            closer = closer_plan(whole, cracks, surface.room, surface.ranges_m, CLOSER_MM, rng)
            shoot(WORLD, closer.plan, folder / "closer", marks, seed, rng)
            rows["second_look"], _ = judged("first", "closer")
        return rows


def _row(told: JudgedFindings, photographs: int, cpu_s: float) -> dict:
    counts = {"rust": told.rust, "cracks": told.cracks, "wide_cracks": told.wide_cracks}
    kinds = [each.kind for each in told.false]
    return {
        **{key: {"found": each.found, "shown": each.shown} for key, each in counts.items()},
        "false": {"rust": kinds.count("rust"), "cracks": kinds.count("crack")},
        "off_m": list(told.off_m),
        "area_m2": told.area_m2,
        "photographs": photographs,
        "cpu_s": cpu_s,
    }


def _views_of(
    defects: Sequence[Defect], whole: SurveyPlan, surface: MeshSurface, rng: np.random.Generator
) -> list[View]:
    """Return photographs of a plan, drawn until each rust spot and wide crack that it shows is in one."""
    taken = [PhotographPose.of_view(each) for each in whole.views]
    chosen: list[int] = []
    for defect in defects:
        if defect.kind == "rust" or (defect.kind == "crack" and defect.width_m >= 0.001):
            show = [k for k, each in enumerate(taken) if shows(each, defect, whole.camera, ASKED, surface)]
            if show and not set(show) & set(chosen):
                chosen.append(int(rng.choice(show)))
    return [whole.views[k] for k in chosen]


def shoot(
    world: Path, part: SurveyPlan, folder: Path, marks: Path, seed: int, rng: np.random.Generator
) -> list[PhotographPose]:
    """Store photographs with disturbed poses. Return the true ones."""
    detail_m = 1e-3 * part.asked.resolution
    for _ in photograph(world, poses_of(part), folder, part.camera, seed, marks, detail_m):
        pass
    taken = []
    for path in photographs_in(folder):
        record = json.loads(path.with_suffix(".json").read_text())
        true = PhotographPose(
            np.array(record["position_m"]), Rotation.from_quat(record["orientation_xyzw"]).as_matrix()
        )
        told = disturbed(true, rng, OFF_M, OFF_DEG)
        record["position_m"] = told.place_m.tolist()
        record["orientation_xyzw"] = Rotation.from_matrix(told.axes).as_quat().tolist()
        path.with_suffix(".json").write_text(json.dumps(record))
        taken.append(true)
    return taken
