"""Inspections of `hold_3d` without ROS: how good plans are, and what is found in their photographs.

plan: at 1 mm per pixel in the worst direction, incidence up to 60 deg, for the UAV of `inspection.launch`.
The bounds are the LP's of the photographs and the Held-Karp bound of the tour.

findings: photographs of such a plan, drawn so that they show each rust spot and each crack of 1 mm or more
that it shows. The poses that `findings` is told are off by 6 mm and 0.33 deg in the median, as SLAM's are in
flight. Then a second look at 0.3 mm per pixel at each crack found. The judge knows the defects, and counts
those of which half lies in a photograph at 1 mm per pixel and 60 deg. A false alarm is near no defect of its
kind.

flown: the first photographs of such a plan, flown with dynamics and without GNSS by a Puck's odometry, from
take-off to landing. No pixel is rendered. With --battery the UAV comes home for full batteries, else the
battery does not count. With --photographs 0 it flies the whole plan, searched for 20 s, and then photographs
what stays open. The judge takes the true poses. share_of_planned: of what these photographs would show from
their own places. share, shares: of what is reachable, of all and of each thing.

mapped: a plan on the map of an exploration, flown as in `bench explore` with a Puck. share, shares: what its
photographs would show of the drawing, of what is reachable there. mesh_cpu_s: of the map's surface.

Keys: inspection.hold_3d.mapped.{photographs, share, shares, mesh_cpu_s, cpu_s, contacts}, medians, and
inspection.hold_3d.plan.{photographs, lp_ratio, tour_ratio, flights, flight_s, share, cpu_s} and
inspection.hold_3d.{findings, second_look}.{rust, cracks, wide_cracks}.{found, shown},
.false_{rust, cracks}_per_100_m2, .off_p95_m, .area_m2, .photographs, .cpu_s
and inspection.hold_3d.flown.{asked, taken, left_out, shots, contacts, landed, flights, least_charge,
share_planned, share_of_planned, share, shares, m2_per_min, each_s, off_m, off_deg, flight_s}, medians over
the flights; each_s: time of flight for each photograph
"""

from __future__ import annotations

import json
import math
import tempfile
import time
from dataclasses import replace
from pathlib import Path
from typing import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.inspection_rows import mapped
from benchmarks.inspection_rows.hold import ASKED, FLYING, HOME_M, WORLD
from benchmarks.shared.results import Results
from benchmarks.shared.trials import run_crossed, trial_options
from gridslam.volume import VolumeParameters
from inspection_tools.energy import EnergyWatch
from inspection_tools.findings.parameters import FindingParameters
from inspection_tools.findings.placing import MeshSurface
from inspection_tools.findings.search import find
from inspection_tools.inspection import InspectionParameters, PriorMap
from inspection_tools.photographs.folder import photographs_in
from inspection_tools.planning import PlannerParameters
from inspection_tools.survey.closer import closer_plan
from inspection_tools.survey.coverage import judge_on
from inspection_tools.survey.plan import SurveyPlan
from inspection_tools.survey.planner import SurveyPlanner
from inspection_tools.survey.poses import Taken
from inspection_tools.survey.supplement import Supplement
from inspection_tools.survey.surface.of_mesh import patches_of_mesh
from inspection_tools.survey.surface.reading import Surface, read_surface
from inspection_tools.survey.views.candidates import View
from master_thesis.flight.closed_loop import ClosedLoop
from master_thesis.flight.course import Outcome, PhaseLimits
from master_thesis.flight.parameters import ClosedLoopParameters
from master_thesis.inspecting.findings_judge import JudgedFindings, disturbed, judge_findings, shows
from master_thesis.inspecting.flight import InspectingFlight, Photographed, controller_of, regulator
from master_thesis.photographing.command import photograph, poses_of
from master_thesis.worlds.defects import write_defects
from simulation_tools.camera.defects import Defect, decals_of, read_defects
from simulation_tools.camera.optics import CameraOptics
from simulation_tools.camera.renderer import Renderer
from simulation_tools.camera.surfaces import surfaces_of
from simulation_tools.geometry import Pose
from simulation_tools.sdf.parser import load_world
from simulation_tools.simulation import SimulationParameters
from simulation_tools.vehicle.energy.battery import BatteryStart

PLAN_SEEDS = (11, 12, 13)
DEFECT_SEEDS = (21, 22)
"""The finder was developed on the defects of the seeds 1 and 7."""
SEARCH_S, BRIEF_SEARCH_S = 20.0, 0.0
CLOSER_MM = 0.3
OFF_M, OFF_DEG = 0.006, 0.33
BRIEF_PHOTOGRAPHS = 3
"""The brief run takes so many of each look."""
ROWS = ("plan", "findings", "flown", "mapped")
FLIGHT_SEEDS, FLOWN, BRIEF_FLOWN = (31, 32, 33), 20, 1
PROGRESS = 25
"""After so many photographs a flight of the whole plan prints a line."""
FLIGHT_S, EACH_S = 300.0, 15.0
"""A flight may last so long, and so much longer for each photograph."""
PLANNER = PlannerParameters(radius=0.35, margin=0.05)
VOLUME = VolumeParameters(resolution_m=0.2, max_range_m=20.0, miss=0.46)
SPEED_M_S = 1.5
SWAPS = 20


def main(arguments: Sequence[str] | None = None) -> None:
    """Plan, photograph, find, print and write."""
    parser = trial_options(__doc__ or "")
    parser.add_argument("--rows", nargs="+", choices=ROWS, default=ROWS)
    parser.add_argument("--seeds", nargs="+", type=int, default=None)
    parser.add_argument("--photographs", type=int, default=FLOWN, help="of a flight; 0: all (%(default)s)")
    parser.add_argument("--battery", action="store_true", help="the battery counts, and is swapped")
    given = parser.parse_args(arguments)
    with Results("inspection", given.results, vars(given)) as results:
        if "plan" in given.rows:
            seeds = given.seeds or PLAN_SEEDS[: 1 if given.brief else None]
            search_s = BRIEF_SEARCH_S if given.brief else SEARCH_S
            plans = run_crossed("inspection_plan", plan, given, seed=seeds, search_s=[search_s])
            _add(results, "inspection.hold_3d.plan", _medians(list(plans.values())))
        if "findings" in given.rows:
            seeds = given.seeds or DEFECT_SEEDS[: 1 if given.brief else None]
            most = BRIEF_PHOTOGRAPHS if given.brief else 1000
            looks = run_crossed("inspection_findings", look, given, seed=seeds, most=[most])
            for name in ("findings", "second_look"):
                rows = [each[name] for each in looks.values() if name in each]
                if rows:
                    _add(results, f"inspection.hold_3d.{name}", _sums(rows))

        if "flown" in given.rows:
            seeds = given.seeds or FLIGHT_SEEDS[: 1 if given.brief else None]
            most = BRIEF_FLOWN if given.brief else given.photographs
            flights = run_crossed(
                "inspection_flown", fly, given, seed=seeds, most=[most], battery=[given.battery]
            )
            _add(results, "inspection.hold_3d.flown", _medians(list(flights.values())))
        if "mapped" in given.rows:
            seeds = given.seeds or mapped.SEEDS[: 1 if given.brief else None]
            time_s = mapped.BRIEF_TIME_S if given.brief else mapped.TIME_S
            search_s = BRIEF_SEARCH_S if given.brief else SEARCH_S
            maps = run_crossed(
                "inspection_mapped", mapped.fly, given, seed=seeds, time_s=[time_s], search_s=[search_s]
            )
            _add(results, "inspection.hold_3d.mapped", _medians(list(maps.values())))


def _add(results: Results, key: str, numbers: dict) -> None:
    results.add(key, numbers)
    print(key, json.dumps(numbers))


def _medians(rows: Sequence[dict]) -> dict:
    return {"seeds": len(rows), **{key: _median([row[key] for row in rows]) for key in rows[0]}}


def _median(values: Sequence) -> float | dict:
    if isinstance(values[0], dict):
        return {key: _median([each[key] for each in values]) for key in values[0]}
    return float(np.median(values))


def _sums(rows: Sequence[dict]) -> dict:
    """Return what all worlds together have; of the position error, all distances count."""
    kinds = ("rust", "cracks", "wide_cracks")
    total = {key: {what: sum(row[key][what] for row in rows) for what in ("found", "shown")} for key in kinds}
    area_m2 = sum(row["area_m2"] for row in rows)
    false = {
        f"false_{kind}_per_100_m2": 100.0 * sum(row["false"][kind] for row in rows) / area_m2
        for kind in ("rust", "cracks")
    }
    off_m = np.concatenate([row["off_m"] for row in rows])
    counts = {key: sum(row[key] for row in rows) for key in ("area_m2", "photographs", "cpu_s")}
    off_p95_m = float(np.percentile(off_m, 95)) if len(off_m) else None
    return {"worlds": len(rows), **total, **false, "off_p95_m": off_p95_m, **counts}


def plan(seed: int, search_s: float) -> dict:
    """Plan once."""
    began_s = time.process_time()
    surface = read_surface(WORLD, ASKED, HOME_M)
    planner = SurveyPlanner(surface.room, surface.patches, surface.ranges_m, asked=ASKED)
    cpu_s = made = None
    for progress in planner.improve(seed, search_s):
        if progress.stage != "bound":
            cpu_s, made = time.process_time() - began_s, progress.plan
        figures = progress.plan.figures
    assert made is not None
    return {
        "photographs": figures["photographs"],
        "lp_ratio": figures["photographs"] / figures["photographs_lp_bound"],
        "tour_ratio": figures["tour_s"] / figures["tour_bound_s"],
        "flights": len(made.flights),
        "flight_s": sum(each.time_s for each in made.flights),
        "share": figures["share"],
        "cpu_s": cpu_s,
    }


def look(seed: int, most: int) -> dict:
    """Photograph a world with the defects of a seed, look for them, and look again from nearer."""
    surface, rng = read_surface(WORLD, ASKED, HOME_M), np.random.default_rng(seed)
    planner = SurveyPlanner(surface.room, surface.patches, surface.ranges_m, asked=ASKED, source=str(WORLD))
    *_, whole = (each.plan for each in planner.improve(seed, BRIEF_SEARCH_S, bound=False))
    patches = patches_of_mesh(
        surface.mesh, surface.room, surface.samples, surface.near, replace(ASKED, patch=0.5 * ASKED.patch)
    )
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        marks = write_defects(WORLD, folder / "defects.yaml", seed)
        defects = read_defects(marks).defects
        views = _views_of(defects, whole, MeshSurface(surface.mesh.triangles_m), rng)[:most]
        taken = _shoot(_only(whole, views), folder / "first", marks, seed, rng)

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
            _shoot(closer.plan, folder / "closer", marks, seed, rng)
            rows["second_look"], _ = judged("first", "closer")
        return rows


def fly(seed: int, most: int, battery: bool) -> dict:
    """Fly the first photographs of a plan, or all, and judge what they show. battery: whether it counts."""
    surface = read_surface(WORLD, FLYING, HOME_M)
    planner = SurveyPlanner(surface.room, surface.patches, surface.ranges_m, asked=FLYING, source=str(WORLD))
    if most:
        first = next(planner.improve(seed, BRIEF_SEARCH_S, bound=False)).plan
        part = _only(first, first.views[:most])
    else:
        *_, part = (each.plan for each in planner.improve(seed, SEARCH_S, bound=False))
    simulation = SimulationParameters(
        str(WORLD), lidar="puck", sensors=("range_finder", "range_finder_up"), gnss=False, seed=seed,
        spawn_pose=Pose((*HOME_M[:2], 0.0)), battery=BatteryStart() if battery else None,
    )  # fmt: skip
    parameters = ClosedLoopParameters(
        simulation, goal_xyz_m=None, algorithm="dynamic", range_finders=True, pose_source="odometry",
        limits=PhaseLimits(flight_timeout_s=FLIGHT_S + EACH_S * len(part.views)),
        position_controller=controller_of(SPEED_M_S), yaw_regulator=regulator(),
    )  # fmt: skip
    surfaces = surfaces_of(load_world(str(WORLD)))
    renderer = Renderer(surfaces, decals_of((), surfaces), CameraOptics())
    with ClosedLoop(parameters) as loop:
        prior = PriorMap(surface.room)
        watch = EnergyWatch() if battery else None
        more = None if most else Supplement(part, surface)
        flight = InspectingFlight(
            loop, part, renderer, PLANNER, VOLUME, InspectionParameters(), prior, watch, SWAPS, more
        )
        if not most:
            flight.on_photograph = lambda: _tell(seed, flight, loop)
        photographed, outcome = flight.run(), loop.outcome
    return _flown_row(flight, photographed, outcome, part, surface)


def _tell(seed: int, flight: InspectingFlight, loop: ClosedLoop) -> None:
    todo, taken = flight.inspection.todo, len(flight.photographed.true)
    if taken % PROGRESS == 0:
        print(
            f"seed {seed}: {loop.time_s:.0f} s, {taken} photographs, {len(todo.open)} open, "
            f"{len(todo.left_out)} left out, charge {loop.charge:.2f}",
            flush=True,
        )


def _flown_row(
    flight: InspectingFlight, photographed: Photographed, outcome: Outcome, part: SurveyPlan, surface: Surface
) -> dict:
    """Judge a flight of a plan by the true poses."""
    planned = [Taken.of_view(each) for each in part.views]
    shown, by_plan = judge_on(surface, (photographed.true, planned), part.camera, FLYING)
    areas_m2 = shown.patches.areas_m2
    area_m2 = float(areas_m2[shown.shown].sum())
    off = [a.axes @ b.axes.T for a, b in zip(photographed.true, photographed.told)]
    turned_deg = [math.degrees(math.acos(min(1.0, 0.5 * (np.trace(each) - 1.0)))) for each in off]
    off_m = [np.linalg.norm(a.place_m - b.place_m) for a, b in zip(photographed.true, photographed.told)]
    return {
        "asked": len(part.views),
        "taken": len(photographed.true),
        "left_out": len(flight.inspection.todo.left_out),
        "shots": photographed.shots,
        "contacts": outcome.collision,
        "landed": outcome.landed,
        "flights": len(photographed.flights),
        "least_charge": min(each.charge for each in photographed.flights),
        "share_of_planned": area_m2 / float(areas_m2[by_plan.shown].sum()),
        "share_planned": by_plan.share(),
        "share": shown.share(),
        "shares": {name: shown.share(number) for number, name in enumerate(shown.patches.names)},
        "m2_per_min": 60.0 * area_m2 / photographed.flight_s,
        "each_s": photographed.flight_s / len(photographed.true),
        "flight_s": photographed.flight_s,
        "off_m": float(np.median(off_m)),
        "off_deg": float(np.median(turned_deg)),
    }


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
    taken = [Taken.of_view(each) for each in whole.views]
    chosen: list[int] = []
    for defect in defects:
        if defect.kind == "rust" or (defect.kind == "crack" and defect.width_m >= 0.001):
            show = [k for k, each in enumerate(taken) if shows(each, defect, whole.camera, ASKED, surface)]
            if show and not set(show) & set(chosen):
                chosen.append(int(rng.choice(show)))
    return [whole.views[k] for k in chosen]


def _only(whole: SurveyPlan, views: Sequence[View]) -> SurveyPlan:
    kept = set(views)
    flights = (replace(f, views=tuple(v for v in f.views if v.view in kept)) for f in whole.flights)
    return replace(whole, flights=tuple(flights))


def _shoot(part: SurveyPlan, folder: Path, marks: Path, seed: int, rng: np.random.Generator) -> list[Taken]:
    """Store photographs with disturbed poses. Return the true ones."""
    for _ in photograph(WORLD, poses_of(part), folder, part.camera, seed, marks):
        pass
    taken = []
    for path in photographs_in(folder):
        record = json.loads(path.with_suffix(".json").read_text())
        true = Taken(
            np.array(record["position_m"]), Rotation.from_quat(record["orientation_xyzw"]).as_matrix()
        )
        told = disturbed(true, rng, OFF_M, OFF_DEG)
        record["position_m"] = told.place_m.tolist()
        record["orientation_xyzw"] = Rotation.from_matrix(told.axes).as_quat().tolist()
        path.with_suffix(".json").write_text(json.dumps(record))
        taken.append(true)
    return taken


if __name__ == "__main__":
    main()
