"""The plan of an inspection, from the drawing of the ship: the world's own shapes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Callable

from inspection_tools.survey.parameters import FlightParameters
from inspection_tools.survey.plan import SurveyPlan
from inspection_tools.survey.plan_file import read_plan, write_plan
from inspection_tools.survey.planner import SurveyPlanner
from inspection_tools.survey.surface.reading import read_surface
from master_thesis.exploring.request import HOVER_M
from master_thesis.inspecting.request import InspectingRequest


def provide_plan(request: InspectingRequest, out: Path, seed: int, say: Callable[[str], None]) -> SurveyPlan:
    """Write the plan that is flown to a file, and return it: the given one, or one that is made.

    If only few photographs are asked, the first plan will do.

    Raises:
        InspectionToolsError: one sentence.
    """
    flown = request.flight.description.scenario
    if request.plan is not None:
        plan = read_plan(request.plan)
        source = request.plan.parent / plan.source
        write_plan(
            out, replace(plan, source=str(source if plan.source and source.exists() else flown.world_path))
        )
        return read_plan(out)
    x, y, z, _ = flown.start_xyz_yaw
    say("The survey is planned from the drawing of the world.")
    surface = read_surface(flown.world_path, request.asked, (x, y, z + HOVER_M))
    planner = SurveyPlanner(
        surface.room, surface.patches, surface.ranges_m, request.camera, request.asked, FlightParameters(),
        str(flown.world_path),
    )  # fmt: skip
    for progress in planner.improve(seed, request.search_s, bound=False):
        write_plan(out, progress.plan)
        figures = progress.plan.figures
        say(
            f"{progress.stage}: {figures['photographs']:.0f} photographs show {100 * figures['share']:.1f} % "
            f"of {figures['reachable_m2']:.0f} m2."
        )
        if request.photographs:
            break
    return read_plan(out)
