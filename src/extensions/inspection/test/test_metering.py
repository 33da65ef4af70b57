"""Given a picture that is white or black in parts, it is told how much, and which exposure shows more."""

import numpy as np
import pytest

from inspection.camera.photograph_pose import PhotographPose
from inspection.camera.survey_camera import SurveyCamera
from inspection.photographs.metering import linear, metering
from inspection.survey.asked_for import AskedFor
from inspection.survey.surface.mesh_file import Mesh
from inspection.survey.views.candidates import View

MIDDLES = np.array([(x, y) for y in range(4, 80, 8) for x in range(4, 160, 8)], float)
"""Of the blocks of a picture of 160 x 80 px."""


def picture(left, right):
    """Return a picture whose halves have two grey levels."""
    found = np.empty((80, 160, 3), np.uint8)
    found[:, :80], found[:, 80:] = left, right
    return found


@pytest.mark.table(
    ("left", "right", "lost", "low_ev", "high_ev"),
    [
        (118, 118, 0.0, 0.0, 0.0),
        (255, 118, 0.5, -9.0, -2.0),  # white may be two stops above white
        (118, 0, 0.5, 1.9, 2.4),  # black may be two stops below black; the other half has 2.4 up to white
        (255, 255, 1.0, -9.0, -2.0),
        (0, 0, 1.0, 2.0, 9.0),
        (240, 20, 0.0, 0.0, 0.0),
    ],
)
def test_the_lost_share_and_the_next_exposure(left, right, lost, low_ev, high_ev):
    told = metering(picture(left, right), MIDDLES, np.ones(len(MIDDLES)))
    assert told.lost == pytest.approx(lost)
    assert low_ev <= told.change_ev <= high_ev


def test_what_is_not_asked_for_does_not_count():
    """The white half is a near stanchion, which is not asked for, or stands for a hundredth of the area."""
    is_right = MIDDLES[:, 0] > 80.0
    shown = picture(255, 118)
    assert metering(shown, MIDDLES[is_right], np.ones(is_right.sum())) == (0.0, 0.0)
    told = metering(shown, MIDDLES, np.where(is_right, 99.0, 1.0))
    assert told.lost == pytest.approx(0.01)
    assert metering(shown, MIDDLES[:0], np.ones(0)) == (0.0, 0.0)


def test_srgb_is_as_the_standard_says():
    assert linear(np.array((0, 255, 188))).tolist() == pytest.approx([0.0, 1.0, 0.5029], abs=1e-4)


def test_what_is_asked_for_is_near_enough_and_not_too_flat():
    """Before the camera a wall 2 m away, left of it one 8 m away; a floor 0.3 m below hides their feet."""
    low, high = -9.0, 9.0
    near = [
        [(2.0, 0.0, low), (2.0, low, low), (2.0, low, high)],
        [(2.0, 0.0, low), (2.0, low, high), (2.0, 0.0, high)],
    ]
    far = [[(8.0, 30.0, -30.0), (8.0, -30.0, -30.0), (8.0, 0.0, 60.0)]]
    floor = [[(-1.0, -90.0, -0.3), (90.0, 0.0, -0.3), (-1.0, 90.0, -0.3)]]
    corners = np.array(near + far + floor)
    mesh = Mesh(corners, ("all",), np.zeros(len(corners), int))
    camera = SurveyCamera(640, 480, 60.0)
    asked = AskedFor(mesh, camera, incidence_deg=60.0)
    taken = PhotographPose.of_view(View((0.0, 0.0, 0.0), 0.0, 0.0))
    pixels, areas_m2 = asked.of(taken, 4.0 / camera.focal_px)
    assert (pixels[:, 0] > camera.centre_px[0]).all()  # -y is to the right
    width_m, height_m = 2.0 * 320.0 / camera.focal_px, 2.0 * 240.0 / camera.focal_px + 0.3
    step_px = 640 / 48
    assert areas_m2.sum() * step_px**2 == pytest.approx(width_m * height_m, rel=0.02)
    more, _ = asked.of(taken, 9.0 / camera.focal_px)
    assert len(more) > 1.5 * len(pixels)
    assert (more[more[:, 0] < camera.centre_px[0], 1] < 400.0).all()  # the floor is too flat below
