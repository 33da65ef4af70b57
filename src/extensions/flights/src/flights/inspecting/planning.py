"""The plan of an inspection: from the world's own shapes, a mesh, or the map of an exploration."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Callable

from flights.inspecting.request import InspectingRequest
from flights.photographing.map_mesh import mesh_of_map
from gridslam.volume.octree.files import read_octree
from inspection.report.plan_page import write_plan_page
from inspection.ship.ship_file import read_ship
from inspection.survey.parameters import SurveyParameters
from inspection.survey.plan import SurveyPlan
from inspection.survey.plan_file import read_plan, write_plan
from inspection.survey.planner import SurveyPlanner
from inspection.survey.surface.reading import Surface, read_surface

SHIPS = Path(__file__).resolve().parents[3] / "config" / "ships"
MAP_SUFFIXES = (".bt", ".ot")


def provide_plan(request: InspectingRequest, out: Path, seed: int, say: Callable[[str], None]) -> SurveyPlan:
    """Write the plan that is flown to a file, and return it: the given one, or one that is made.

    One that is made has a page to print beside it, plan.html. If a draft is asked, it is one: it is completed
    while its photographs are taken.

    If only few photographs are asked, the first plan will do.

    Raises:
        FlightBasicsError, SlamError, FlightsError: one sentence.
    """
    if request.plan is not None:
        plan = read_plan(request.plan)
        source = request.plan.parent / plan.source
        known = source if plan.source and source.exists() else request.drawing
        camera = replace(plan.camera, exposure=request.camera.exposure)
        flying = plan.flying
        if request.flying.passing:
            flying = replace(flying, passing=True, passing_speed=request.flying.passing_speed)
        write_plan(out, replace(plan, source=str(known), camera=camera, flying=flying))
        return read_plan(out)
    x, y, z, _ = request.flight.description.scenario.start_xyz_yaw
    drawing, asked = request.drawing, request.asked
    if drawing.suffix in MAP_SUFFIXES:
        asked = on_map(asked, drawing)
        mesh_of_map(drawing).export(out.with_name("drawing.glb"))
        drawing = out.with_name("drawing.glb")
    say(f"The survey is planned from {request.drawing}.")
    surface = read_surface(drawing, asked, (x, y, z + request.flight.hover_m))
    planner = SurveyPlanner(
        surface.room, surface.patches, surface.ranges_m, request.camera, asked, request.flying, str(drawing)
    )  # fmt: skip
    draft = planner.first_flight(seed, request.search_s) if request.draft else None
    if draft is not None:
        write_plan(out, draft)
        say(f"The first {len(draft.views)} photographs are planned. The others are planned in flight.")
        write_page(request, out, surface)
        return draft
    for progress in planner.improve(seed, request.search_s, bound=False):
        write_plan(out, progress.plan)
        figures = progress.plan.figures
        say(
            f"{progress.stage}: {figures['photographs']:.0f} photographs show {100 * figures['share']:.1f} % "
            f"of {figures['reachable_m2']:.0f} m2."
        )
        if request.photographs:
            break
    write_page(request, out, surface)
    return read_plan(out)


def write_page(request: InspectingRequest, plan_file: Path, surface: Surface | None = None) -> None:
    """Write the page of a plan beside it. surface: of its mesh; None: it is read.

    Raises:
        FlightBasicsError: the plan, the surface or the ship cannot be read, or the page not written.
    """
    plan, ship = read_plan(plan_file), ship_file(request)
    known = surface or read_surface(Path(plan.source), plan.asked, plan.home_m)
    write_plan_page(plan_file.with_suffix(".html"), plan, known.patches, read_ship(ship) if ship else None)


def on_map(asked: SurveyParameters, path: Path) -> SurveyParameters:
    """Return what is asked of a plan on a map of voxels, a .bt or .ot file.

    A plan without margin is for manholes. The rim of one fills voxels that it only touches, so the manhole of
    the map is narrower than the true one, by up to a voxel at each side. Such a plan counts it as free.
    """
    if asked.margin > 0.0:
        return asked
    return replace(asked, margin=asked.margin - read_octree(path).resolution_m)


def ship_file(request: InspectingRequest) -> Path | None:
    """Return the file of frames and strakes that belongs to the world; None: there is none."""
    path = SHIPS / f"{request.flight.description.scenario.world_path.stem}.yaml"
    return path if path.is_file() else None
