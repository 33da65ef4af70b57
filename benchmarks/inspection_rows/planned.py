"""A plan for the drawing of the hold, with its bounds."""

from __future__ import annotations

import time

from benchmarks.inspection_rows.hold import ASKED, HOME_M, WORLD
from inspection.survey.planner import SurveyPlanner
from inspection.survey.surface.reading import read_surface

SEEDS = (11, 12, 13)


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
