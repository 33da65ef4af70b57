"""A whole survey without a flight: coverage, grades and findings beside the truth."""

from __future__ import annotations

import tempfile
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Sequence

import numpy as np

from benchmarks.inspection_rows.found import shoot
from benchmarks.inspection_rows.hold import ASKED, HOME_M
from benchmarks.inspection_rows.parts import only
from benchmarks.inspection_rows.rusted import true_rust
from flights.inspecting.findings_judge import JudgedFindings, judge_findings
from inspection.camera.photograph_pose import PhotographPose
from inspection.camera.survey_camera import SurveyCamera
from inspection.findings.merging import Finding
from inspection.findings.parameters import FindingParameters
from inspection.findings.search import search_folders
from inspection.photographs.searched import countable
from inspection.report.grades import AreaGrade, GradeRules, areas_graded
from inspection.ship.ship_file import read_ship
from inspection.survey.coverage import Coverage, coverages_on
from inspection.survey.parameters import SurveyParameters
from inspection.survey.plan import SurveyPlan
from inspection.survey.planner import SurveyPlanner
from inspection.survey.poses import photograph_poses_in
from inspection.survey.surface.edges import edge_places
from inspection.survey.surface.of_mesh import patches_of_mesh
from inspection.survey.surface.reading import Surface, read_surface
from simulation_tools.camera.defects import beside, read_defects

SEEDS = (305,)
MOST, BRIEF_MOST = 10000, 3
"""Photographs."""
PACKAGE = Path(__file__).resolve().parents[2] / "src/extensions/flights"


@dataclass(frozen=True)
class Place:
    """A world that is surveyed. home_m: where the UAV takes off; None: as the planner chooses."""

    asked: SurveyParameters
    camera: SurveyCamera
    home_m: tuple[float, float, float] | None = None


PLACES = {
    "ballast_tank": Place(
        SurveyParameters(resolution=4.0, radius=0.2, margin=0.1), SurveyCamera(1296, 972), None
    ),
    "hold_3d": Place(replace(ASKED, resolution=2.0), SurveyCamera(2592, 1944), HOME_M),
}
"""By the name of the world and of its ship. Their cameras are small: an hour becomes some minutes."""


def survey(name: str, seed: int, most: int) -> dict:
    """Plan, photograph with poses that are off, search, grade, and tell what is true."""
    began_s, rng, place = time.process_time(), np.random.default_rng(seed), PLACES[name]
    world = PACKAGE / f"worlds/{name}.world"
    surface = read_surface(world, place.asked, place.home_m)
    planner = SurveyPlanner(
        surface.room, surface.patches, surface.ranges_m, asked=place.asked, camera=place.camera, source=name
    )
    *_, whole = (each.plan for each in planner.improve(seed, 0.0, bound=False))
    with tempfile.TemporaryDirectory() as kept:
        folder, marks = Path(kept) / "photographs", beside(world)
        plan = only(whole, whole.views[:most])
        true = shoot(world, plan, folder, marks, seed, rng)
        listing = countable(folder)
        true = [replace(each, name=path.name, path=path) for each, (path, _) in zip(true, listing.whole)]
        found = list(search_folders([folder], surface.mesh, FindingParameters()).findings)
        told, camera = photograph_poses_in(folder, listing, plan.camera)
        by_told, by_true = coverages_on(surface, (told, true), camera, place.asked)
        judged = _judged(found, world, true, plan, surface)
    grades = _grades(name, world, surface, by_told, found)
    return {
        "photographs": len(true),
        "reachable_m2": by_true.reachable_m2,
        "share": {"told": by_told.share(), "true": by_true.share()},
        "shares": {key: [told, by_true.share(part)] for part, key, told in _shares(by_told)},
        "areas": {key: _row(*both) for key, both in grades.items()},
        **judged,
        "cpu_s": time.process_time() - began_s,
    }


def summary(rows: Sequence[dict]) -> dict:
    """Return what all surveys of one place have together."""
    areas = [area for row in rows for area in row["areas"].values() if area["told"][0] is not None]
    return {
        "surveys": len(rows),
        "areas_graded": len(areas),
        "grades_right": sum(each["told"][0] == each["true"][0] for each in areas),
        "told_above_true": max(row["share"]["told"] - row["share"]["true"] for row in rows),
        "each": list(rows),
    }


def _shares(coverage: Coverage) -> list[tuple[int, str, float]]:
    return [
        (part, name, share)
        for part, name in enumerate(coverage.patches.names)
        if (share := coverage.share(part)) is not None
    ]


def _judged(
    found: Sequence[Finding], world: Path, true: Sequence[PhotographPose], plan: SurveyPlan, surface: Surface
) -> dict:
    fine = replace(plan.asked, patch=0.5 * plan.asked.patch)
    patches = patches_of_mesh(surface.mesh, surface.room, surface.samples, surface.near, fine)
    defects = read_defects(beside(world)).defects
    judged: JudgedFindings = judge_findings(
        found, defects, true, plan.camera, plan.asked, surface.mesh, patches
    )
    counts = {"rust": judged.rust, "cracks": judged.cracks, "wide_cracks": judged.wide_cracks}
    kinds = [each.kind for each in judged.false]
    return {
        **{key: {"found": each.found, "shown": each.shown} for key, each in counts.items()},
        "findings": {kind: sum(each.kind == kind for each in found) for kind in ("rust", "crack")},
        "false": {"rust": kinds.count("rust"), "cracks": kinds.count("crack")},
        "off_p95_m": float(np.percentile(judged.off_m, 95)) if judged.off_m else None,
    }


def _grades(
    name: str, world: Path, surface: Surface, by_told: Coverage, found: Sequence[Finding]
) -> dict[str, tuple[AreaGrade, AreaGrade]]:
    """Return the grade told and the true one of each area. The truth counts what was not seen, too."""
    ship, record = read_ship(PACKAGE / f"config/ships/{name}.yaml"), by_told.record()
    edges_m = edge_places(surface.mesh.triangles_m, surface.mesh.part)
    whole, rust = replace(record, shown=record.reachable), true_rust(world, beside(world))
    told, true = (
        {each.name: each for each in areas_graded(ship, shown, edges_m, findings, GradeRules())}
        for shown, findings in ((record, list(found)), (whole, rust))
    )
    return {key: (each, true[key]) for key, each in told.items() if key in true}


def _row(told: AreaGrade, true: AreaGrade) -> dict:
    both = {
        key: [each.grade, round(each.rust_share, 4), round(each.edge_share, 4)]
        for key, each in (("told", told), ("true", true))
    }
    return {**both, "other": told.other_grade, "area_m2": round(told.area_m2, 1), "seen": round(told.seen, 3)}
