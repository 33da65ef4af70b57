"""Coverage in a closed room: areas in closed form; poses from files, whole or damaged."""

import json

import numpy as np
import pytest
import trimesh

from inspection_tools.errors import SurveyError
from inspection_tools.photographs.folder import PhotographRecord
from inspection_tools.survey import SurveyCamera, SurveyParameters
from inspection_tools.survey.command import main
from inspection_tools.survey.coverage import judge
from inspection_tools.survey.poses import read_taken

CAMERA = SurveyCamera(width=648, height=486)
ASKED = SurveyParameters(resolution=8.0, spacing=1.0, voxel=0.2)
AHEAD = "x,y,z,yaw_deg,tilt_deg,blur_px\n"


@pytest.fixture(scope="module")
def room_file(tmp_path_factory):
    """A room of 6 x 4 x 3 m; the wall ahead is at x = 3."""
    path = tmp_path_factory.mktemp("room") / "room.stl"
    trimesh.creation.box((6.0, 4.0, 3.0)).export(path)
    return path


@pytest.mark.parametrize(("blur_px", "low_m2", "high_m2"), [(0.0, 3.9, 4.6), (2.5, 0.0, 0.0)])
def test_a_photograph_from_2_m_shows_its_frame_and_a_blurred_one_nothing(
    room_file, tmp_path, blur_px, low_m2, high_m2
):
    """2 m away 60 degrees span 2.31 x 1.73 m = 4 m2; pixels of 3.6 mm, with 2.5 px of blur 9.6 mm."""
    (tmp_path / "poses.csv").write_text(AHEAD + f"1,0,0,0,0,{blur_px}\n")
    taken, camera = read_taken(tmp_path / "poses.csv", CAMERA)
    coverage = judge(room_file, taken, camera, ASKED)
    assert low_m2 <= coverage.patches.areas_m2[coverage.shown].sum() <= high_m2
    assert (coverage.patches.points_m[coverage.shown, 0] > 2.99).all()


@pytest.mark.parametrize(
    ("shift_m", "turn_rad", "is_shown"),
    [(0.0, 0.0, True), (0.006, 0.0, True), (0.009, 0.0, False), (0.0, 0.003, True), (0.0, 0.0045, False)],
)
def test_the_motion_of_a_record_counts_on_the_surface_in_place_of_its_longest_blur(
    room_file, shift_m, turn_rad, is_shown
):
    """2 m away in the middle: pixels of 3.6 mm, and a blur of the shift, or of 2 m times the turn."""
    record = PhotographRecord(
        1.0,
        (1.0, 0.0, 0.0),
        (-0.5, 0.5, -0.5, 0.5),
        0.01,
        100.0,
        90.0,
        9.0,
        shift_m=shift_m,
        turn_rad=turn_rad,
    )
    coverage = judge(room_file, [record.taken], CAMERA, ASKED)
    middle = np.linalg.norm(coverage.patches.points_m - (3.0, 0.0, 0.0), axis=1) < 0.2
    assert (coverage.shown[middle] == is_shown).all()


def test_the_command_judges_a_folder_of_photographs(room_file, tmp_path):
    """The optical frame of a camera that looks along x: its z axis is the map's x, its x the map's -y."""
    record = {"position_m": [1, 0, 0], "orientation_xyzw": [-0.5, 0.5, -0.5, 0.5], "blur_px": 0.0}
    (tmp_path / "1.json").write_text(json.dumps(record))
    focal = CAMERA.focal_px
    (tmp_path / "calibration.yaml").write_text(
        f"{{image_width: 648, image_height: 486, camera_matrix: {{data: [{focal}]}}}}"
    )
    asked = [
        "--resolution",
        "8",
        "--spacing",
        "1",
        "--voxel",
        "0.2",
        "--out",
        str(tmp_path / "coverage.json"),
    ]
    assert main(["coverage", "--mesh", str(room_file), "--poses", str(tmp_path), *asked]) == 0
    found = json.loads((tmp_path / "coverage.json").read_text())
    assert 3.9 <= found["shown_m2"] <= 4.6
    assert found["reachable_m2"] == pytest.approx(108.0, rel=0.02)
    assert found["share_of_reachable"] == pytest.approx(found["shown_m2"] / found["reachable_m2"], abs=1e-3)
    opened_m2 = np.array(found["open"])[:, 3].sum()
    assert opened_m2 == pytest.approx(found["reachable_m2"] - found["shown_m2"], rel=0.02)


@pytest.mark.parametrize(
    ("content", "told"),
    [("x,y\n1,2\n", "line 2"), (AHEAD + "1,0,nan,0,0,0\n", "finite"), (AHEAD, "no photograph")],
)
def test_poses_that_make_no_sense_are_refused_with_a_sentence(tmp_path, content, told):
    (tmp_path / "poses.csv").write_text(content)
    with pytest.raises(SurveyError, match=told):
        read_taken(tmp_path / "poses.csv", CAMERA)
