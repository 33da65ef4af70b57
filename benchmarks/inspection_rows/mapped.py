"""A plan on the map of an exploration: what its photographs would show of the drawing, and where rust."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

from benchmarks.inspection_rows.hold import FLYING, HOME_M, WORLD
from benchmarks.inspection_rows.placed import place_rust
from flights.exploring.flight import ExploringFlight
from flights.exploring.places import HOLD, place_of
from flights.flight.closed_loop import ClosedLoop
from flights.photographing.map_mesh import scene_of, surfaces_of_map
from gridslam.volume import stream_of, write_octree
from inspection.survey.coverage import coverages_on
from inspection.survey.planner import SurveyPlanner
from inspection.survey.poses import PhotographPose
from inspection.survey.surface.reading import read_surface

SEEDS = (53, 54)
"""Plans on maps were developed on the flight with seed 1."""
TIME_S, BRIEF_TIME_S = 400.0, 15.0
"""Of simulation; then the UAV flies home, explored or not."""


def fly(seed: int, time_s: float, search_s: float) -> dict:
    """Explore, plan on the map, and judge the plan on the drawing, and the places of rust."""
    place = place_of(HOLD, seed)
    with ClosedLoop(place.loop_parameters(WORLD, seed, 2.0 * time_s)) as loop:
        flight = ExploringFlight(loop, place.planner, place.explorer, place.volume, place.asked(time_s))
        flight.run()
        contact = loop.outcome.collision
    corrected = flight.volume.corrected
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "map.bt"
        write_octree(path, stream_of(corrected.voxels, is_binary=True), place.volume.resolution_m)
        began_s = time.process_time()
        scene_of(surfaces_of_map(path, corrected.nodes)).export(path.with_suffix(".glb"))
        mesh_cpu_s = time.process_time() - began_s
        began_s = time.process_time()
        surface = read_surface(path.with_suffix(".glb"), FLYING, HOME_M)
    planner = SurveyPlanner(surface.room, surface.patches, surface.ranges_m, asked=FLYING)
    *_, made = (each.plan for each in planner.improve(seed, search_s, bound=False))
    cpu_s = time.process_time() - began_s
    drawing = read_surface(WORLD, FLYING, HOME_M)
    (shown,) = coverages_on(
        drawing, ([PhotographPose.of_view(each) for each in made.views],), made.camera, FLYING
    )
    return {
        "photographs": len(made.views),
        "share": shown.share(),
        "shares": {name: shown.share(number) for number, name in enumerate(shown.patches.names)},
        "mesh_cpu_s": mesh_cpu_s,
        "cpu_s": cpu_s,
        "rust": place_rust(made, surface.mesh, drawing.mesh, seed),
        "contacts": contact,
    }
