"""Given a photograph that is blown out or black in parts, these parts are not shown."""

from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from inspection.camera.photograph_pose import PhotographPose
from inspection.camera.survey_camera import SurveyCamera
from inspection.photographs.exposure import exposed
from inspection.survey import SurveyParameters
from inspection.survey.showing import Showing
from inspection.survey.surface.mesh_file import Mesh
from inspection.survey.surface.samples import SurfacePoints
from inspection.survey.views.candidates import View

GREY, WHITE, BLACK = (120, 125, 120), (255, 255, 255), (1, 0, 2)


@pytest.mark.table(
    ("colour", "is_told"),
    [
        (GREY, True), (WHITE, False), (BLACK, False), ((255, 60, 10), True), ((254, 253, 253), False),
        ((255, 255, 200), True), ((30, 3, 2), True),
    ],
)  # fmt: skip
@pytest.mark.table("suffix", [".jpg", ".png"])
def test_what_is_white_or_black_is_not_told(tmp_path, colour, is_told, suffix):
    Image.new("RGB", (100, 60), colour).save(tmp_path / f"a{suffix}", quality=95)
    told = exposed(tmp_path / f"a{suffix}")
    assert told.shape == (8, 13)
    assert (told == is_told).all()


def test_the_blown_out_part_of_a_wall_counts_as_not_shown(tmp_path):
    """A quarter of the picture is white: its upper left, which is the wall's upper part to port."""
    camera = SurveyCamera(640, 480, 60.0)
    picture = np.full((480, 640, 3), GREY, np.uint8)
    picture[:240, :320] = 255
    Image.fromarray(picture).save(tmp_path / "1.jpg", quality=92)
    y, z = (each.ravel() for each in np.meshgrid(np.arange(-3.0, 3.0, 0.05), np.arange(-3.0, 3.0, 0.05)))
    points_m = np.column_stack((np.full(y.size, 2.0), y, z))
    points = SurfacePoints(
        points_m, np.tile((-1.0, 0.0, 0.0), (y.size, 1)), np.full(y.size, 0.0025), np.zeros(y.size, int)
    )
    wall = np.array([[(2.0, -90.0, -90.0), (2.0, 90.0, -90.0), (2.0, 0.0, 180.0)]])
    showing = Showing(
        Mesh(wall, ("wall",), np.zeros(1, int)), points, camera, SurveyParameters(resolution=50.0)
    )
    taken = PhotographPose.of_view(View((0.0, 0.0, 0.0), 0.0, 0.0))
    whole, told = showing.by([taken]), showing.by([replace(taken, path=tmp_path / "1.jpg")])
    assert told.sum() / whole.sum() == pytest.approx(0.75, abs=0.02)
    lost = points_m[whole & ~told]
    assert (lost[:, 1] > -0.05).all()
    assert (lost[:, 2] > -0.05).all()
