"""Given photographs of a flight that planned on its map, the result tells of which surface each share is."""

import json
from pathlib import Path

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from flights.inspecting.coverage import judge_photographs
from flights.inspecting.summary import headline
from inspection.camera.survey_camera import SurveyCamera, optical_axes
from inspection.photographs.folder import PhotographFolder
from inspection.photographs.record import PhotographRecord
from inspection.survey import FlightParameters, SurveyParameters
from inspection.survey.plan import Flight, PlannedView, SurveyPlan
from inspection.survey.plan_file import write_plan
from inspection.survey.views.candidates import View

CAMERA = SurveyCamera(width=648, height=486)
ASKED = SurveyParameters(resolution=8.0, spacing=1.0, voxel=0.1)
PLACE_M = (0.0, 0.0, 1.5)


def drawn(path, parts):
    scene = trimesh.Scene()
    for name, mesh in parts.items():
        scene.add_geometry(mesh, node_name=name)
    scene.export(path)
    return path


@pytest.mark.parametrize("is_mapped", [True, False])
def test_a_web_that_the_map_lacks_is_told_beside_the_share_of_the_map(tmp_path, is_mapped):
    """A room of 6 x 4 x 3 m with a web of 0.3 m all along its floor, of which the map knows nothing."""
    plate = trimesh.creation.box((6.0, 4.0, 3.0))
    plate.apply_translation((0.0, 0.0, 1.5))
    plate.invert()
    web = trimesh.creation.box((5.9, 0.02, 0.3))
    web.apply_translation((0.0, 1.0, 0.15))
    world = drawn(tmp_path / "hull.glb", {"shell": plate, "web": web})
    source = drawn(tmp_path / "drawing.glb", {"mapped_plating": plate}) if is_mapped else world
    photographs = tmp_path / "photographs"
    turn = tuple(Rotation.from_matrix(optical_axes(np.pi / 2, 0.0)).as_quat())
    folder = PhotographFolder(photographs, CAMERA)
    folder.save(
        np.full((486, 648, 3), 128, np.uint8), PhotographRecord(1.0, PLACE_M, turn, 0.002, 100.0, 300.0)
    )
    flight = Flight((PlannedView(View(PLACE_M, np.pi / 2, 0.0)),), 10.0, 2.0)
    plan = SurveyPlan(str(source), PLACE_M, CAMERA, ASKED, FlightParameters(), (flight,))
    write_plan(tmp_path / "plan.yaml", plan)
    judged = judge_photographs(
        photographs, tmp_path / "plan.yaml", plan, {1.0: (PLACE_M, turn)}, 1, Path(world)
    )
    told, true = (json.loads((tmp_path / f"coverage{k}.json").read_text()) for k in ("", "_truth"))
    figures = judged.figures()
    assert figures["of"] == told["of"] == ("map" if is_mapped else "drawing")
    if is_mapped:  # by the same poses, the drawing is covered as it truly is
        drawing = figures["drawing"]
        assert drawing["share_of_reachable"] == pytest.approx(true["share_of_reachable"], abs=0.005)
        assert drawing["classes"]["web"]["not_mapped_m2"] > 1.0
        assert told["reachable_m2"] < drawing["reachable_m2"]
    else:
        assert figures["drawing"] is None
    told_run = {"end": "done", "reason": "-", "taken": 1, "asked": 1, "shots": 1, "open": 0, "left_out": []}
    told_run |= {"swaps": 0, "flight_s": 60.0, "m2_per_min": 1.0, "coverage": figures}
    run = {
        "scenario": "hull", "algorithm": "dynamic", "lidar": "puck", "seed": 1, "reached_goal": True,
        "collision": False, "failure": None,
        **dict.fromkeys(("flight_time_s", "path_length_m", "min_clearance_m", "real_time_factor")),
        **dict.fromkeys(("cepa_computation_ms", "latency_ms")),
    }  # fmt: skip
    words = headline({**run, "inspection": told_run})
    assert f"shown of the {told['of']}" in words
    assert ("not on the map" in words) == is_mapped
