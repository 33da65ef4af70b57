"""Given a wall and marks on it, the row `effects` photographs each mark and knows the area that is shown."""

import math

import numpy as np
import pytest

from benchmarks.inspection_rows.effects import before_marks, shown_m2, summary
from benchmarks.inspection_rows.hold import ASKED
from flights.inspecting.findings_judge import shows
from inspection.camera.photograph_pose import PhotographPose
from inspection.camera.survey_camera import SurveyCamera, optical_axes
from inspection.findings.placing import MeshSurface
from simulation_tools.camera.defects import Defect

CORNERS_M = np.array([(0.0, -9.0, -9.0), (0.0, 9.0, -9.0), (0.0, 9.0, 9.0), (0.0, -9.0, 9.0)])
WALL = MeshSurface(CORNERS_M[[[0, 1, 2], [0, 2, 3]]])
CAMERA = SurveyCamera()


def test_the_area_of_a_wall_before_the_camera():
    """2 tan 30 deg wide at 1 m, and three quarters as high. At 5 m a pixel covers more than is asked."""
    near, far = (PhotographPose(np.array((-x, 0.0, 0.0)), optical_axes(0.0, 0.0)) for x in (1.0, 5.0))
    assert shown_m2(near, WALL, CAMERA) == pytest.approx(
        0.75 * (2.0 * math.tan(math.radians(30.0))) ** 2, rel=1e-3
    )
    assert 1e3 * 5.0 / CAMERA.focal_px > ASKED.resolution
    assert shown_m2(far, WALL, CAMERA) == 0.0


def test_each_photograph_shows_its_mark():
    rng = np.random.default_rng(2)
    marks = [
        Defect(kind, (0.0, *rng.uniform(-3.0, 3.0, 2)), (-1.0, 0.0, 0.0), (0.0, 1.0, 0.0), 0.2, width_m)
        for kind, width_m in (("rust", 0.2), ("crack", 0.001)) * 4
    ]
    taken = before_marks(marks, WALL, CAMERA, 6, np.random.default_rng(1))
    assert len(taken) == 6
    in_turn = [each for pair in zip(marks[::2], marks[1::2]) for each in pair]
    assert all(shows(view, mark, CAMERA, ASKED, WALL) for view, mark in zip(taken, in_turn))


def test_rows_of_several_seeds_are_added():
    count = {"found": 1, "shown": 2}
    row = {
        **dict.fromkeys(("rust", "cracks", "wide_cracks"), count), "false": {"rust": 1, "cracks": 2},
        "false_of_each": [3, 0], "area_m2": 25.0, "photographs": 2, "cpu_s": 1.0,
    }  # fmt: skip
    both = summary([row, row])
    assert both["rust"] == {"found": 2, "shown": 4}
    assert (both["false_rust_per_100_m2"], both["false_cracks_per_100_m2"]) == (4.0, 8.0)
    assert (both["false_a_picture"], both["false_of_the_worst"], both["photographs"]) == (1.5, 3, 4)
