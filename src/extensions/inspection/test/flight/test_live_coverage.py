"""A photograph of a wall of a box colours the patches that it shows, and no others."""

import numpy as np
import pytest
from drawn_inspection import mesh
from scipy.spatial.transform import Rotation

from inspection.camera.photograph_pose import PhotographPose
from inspection.camera.survey_camera import SurveyCamera
from inspection.flight.live_coverage import OFF_SURFACE_M, LiveCoverage
from inspection.photographs.record import PhotographRecord
from inspection.survey.parameters import FlightParameters, SurveyParameters
from inspection.survey.plan import Flight, PlannedView, SurveyPlan
from inspection.survey.views.candidates import View

CAMERA = SurveyCamera(800, 600, 60.0)
WALL_Y_M, AWAY_M = 1.5, 1.0
AHEAD = View((0.0, WALL_Y_M - AWAY_M, 1.0), np.pi / 2, 0.0)
BACK = View((0.0, AWAY_M - WALL_Y_M, 1.0), -np.pi / 2, 0.0)


@pytest.fixture
def live(tmp_path):
    asked = SurveyParameters(resolution=3.0, radius=0.2, voxel=0.1)
    flight = Flight((PlannedView(AHEAD), PlannedView(BACK)), 9.0, 1.0)
    source = str(mesh(tmp_path / "box.stl"))
    return SurveyPlan(source, (0.0, 0.0, 1.0), CAMERA, asked, FlightParameters(), (flight,))


def record(view):
    taken = PhotographPose.of_view(view)
    turn = tuple(Rotation.from_matrix(taken.axes).as_quat())
    return PhotographRecord(0.0, view.place_m, turn, 0.002, 100.0, 100.0)


def test_a_photograph_shows_what_is_in_its_picture(live):
    coverage = LiveCoverage(live)
    assert coverage.so_far.shown_m2 == 0.0
    coverage.add(record(AHEAD))
    p = coverage.patches
    half_x_m, half_z_m = (AWAY_M * size / 2 / CAMERA.focal_px for size in (CAMERA.width, CAMERA.height))
    middle = p.points_m - (0.0, WALL_Y_M, 1.0)
    on_wall = np.abs(middle[:, 1]) < 1e-6
    side_m = p.grid.side_m
    inside = on_wall & (np.abs(middle[:, 0]) < half_x_m - side_m) & (np.abs(middle[:, 2]) < half_z_m - side_m)
    outside = (np.abs(middle[:, 0]) > half_x_m + side_m) | (np.abs(middle[:, 2]) > half_z_m + side_m)
    assert inside.any()
    assert coverage.shown[inside].all()
    assert not coverage.shown[~on_wall | outside].any()


def test_open_is_what_the_photographs_of_the_plan_show(live):
    both, first = LiveCoverage(live), LiveCoverage(live, photographs=1)
    assert both.so_far.planned_m2 == pytest.approx(2.0 * first.so_far.planned_m2, rel=0.1)
    first.add(record(AHEAD))
    np.testing.assert_array_equal(first.shown, first.planned)
    assert first.so_far.shown_m2 == first.so_far.planned_m2
    first.add(record(BACK))  # one that the plan does not have counts as well
    assert first.so_far.shown_m2 == pytest.approx(both.so_far.planned_m2)


def test_squares_are_as_large_as_the_patches_and_lie_just_before_the_surface(live):
    coverage = LiveCoverage(live)
    squares, p = coverage.squares_m(), coverage.patches
    assert squares.shape == (len(p), 4, 3)
    np.testing.assert_allclose(squares.mean(axis=1), p.points_m + OFF_SURFACE_M * p.normals, atol=1e-9)
    sides = np.linalg.norm(np.roll(squares, -1, axis=1) - squares, axis=2)
    np.testing.assert_allclose(sides, sides[:, :1].repeat(4, axis=1))
    assert (sides <= p.grid.side_m).all()
    normals = np.cross(squares[:, 1] - squares[:, 0], squares[:, 2] - squares[:, 1])
    along = np.abs((normals * p.normals).sum(axis=1)) / np.linalg.norm(normals, axis=1)
    np.testing.assert_allclose(along, 1.0, atol=1e-6)
