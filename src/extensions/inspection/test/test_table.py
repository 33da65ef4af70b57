"""Tables as people write them: no row is lost, none is read as another one."""

import numpy as np
import pytest

from flight_basics.errors import ReportError
from inspection.camera.survey_camera import SurveyCamera, optical_axes
from inspection.files.table import TableError, number_of, read_table
from inspection.photograph_poses.pose import Names
from inspection.photograph_poses.table import poses_of_table
from inspection.report.gauging.readings import read_readings
from inspection.ship.ship_file import parse_ship
from inspection.survey.poses import read_photograph_poses

HEAD = "frame,strake,side,original_mm,forward_mm,aft_mm,remark\n"
SHIP = parse_ship(
    {
        "ap": [0, 0, 0],
        "frames": [{"from": -4, "to": 8, "spacing": 1000, "at": -4.0}],
        "strakes": [{"name": "W"}],
    }
)


def readings(tmp_path, text):
    """Return frame, original, forward and aft reading of each row."""
    path = tmp_path / "t.csv"
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    rows = read_readings(path, SHIP).rows
    return [(each.plate.first, each.original_mm, each.forward_mm, each.aft_mm) for each in rows]


@pytest.mark.table(
    "text",
    [
        HEAD + "#5,W,P,14.0,9.1,9.7,\n",
        "# " + HEAD + "# measured by hand\n5,W,P,14.0,9.1,9.7,\n",
        (HEAD + "5,W,P,14.0,9.1,9.7,\n").replace("\n", "\r"),
        (HEAD + "Fr. no. 5,W,P,14.0 mm,9.1\u00a0mm,9.7mm,\n").encode("utf-16"),
        "Frame No.;Strake;Side (P/S);Original [mm];Forward (mm);Aft, mm\nFrame 5;W;PS;14,0;9,1;9,7\n",
        "| frame | strake | side | original | fwd | aft |\n|---|---|:--|--:|---|---|\n|5|W|P|14|9.1|9.7|\n",
        HEAD + '5,W,P,14.0,9.1,9.7,"pit\nnear the weld, wet"\n',
    ],
)
def test_one_reading_however_it_is_written(tmp_path, text):
    assert readings(tmp_path, text) == [(5, 14.0, 9.1, 9.7)]


def test_a_frame_below_zero_with_a_printers_minus(tmp_path):
    assert readings(tmp_path, HEAD + "\u22123,W,P,14.0,9.1,9.7,\n") == [(-3, 14.0, 9.1, 9.7)]
    assert number_of("\u22120,5") == -0.5


@pytest.mark.table(
    "rows",
    [
        '5,W,P,14.0,13.1,13.7,"pit\n6,W,P,14.0,8.0,8.1,\n',  # the second row would be a remark
        '5,W,P,14.0,13.1,13.7,"pit\n6,W,P,14.0,8.0,8.1,deep"\n',
        "5,W,P,14,9,1,10,\n",  # 14 mm, 9.1 mm and 10 mm: the aft reading would be 1 mm
    ],
)
def test_a_row_that_would_be_read_as_another_one_is_refused(tmp_path, rows):
    with pytest.raises(ReportError, match=r"t\.csv, line"):
        readings(tmp_path, HEAD + rows)


def test_a_pose_that_is_a_remark_stays_one(tmp_path):
    path = tmp_path / "t.csv"
    path.write_text("x,y,z\n# 1,2,3\n4,5,6\n")
    assert [each.values["x"] for each in read_table(path, {"x": (), "y": (), "z": ()}, "xyz").rows] == ["4"]
    path.write_text('x,y,z\n1,2,"3" m\n')
    with pytest.raises(TableError, match="line 2"):
        read_table(path, {"x": (), "y": (), "z": ()}, "xyz")


def test_a_camera_that_is_rolled(tmp_path):
    """A camera that looks along x and is rolled by 90 deg to its right has its right side below."""
    path = tmp_path / "t.csv"
    path.write_text("name,x,y,z,yaw_deg,tilt_deg,roll_deg,gain\na.jpg,1,2,3,0,0,90,7\n")
    photograph = tmp_path / "a.jpg"
    poses = poses_of_table(path, tmp_path, [photograph], None)
    said = []
    (taken,), _ = read_photograph_poses(path, SurveyCamera(), said.append)
    expected = np.array(((0, 0, -1), (0, 1, 0), (1, 0, 0)), float).T  # right is down, down is to port
    np.testing.assert_allclose(taken.axes, expected, atol=1e-12)
    x, y, z, w = poses.of[photograph].orientation_xyzw
    right = (1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w))
    np.testing.assert_allclose(right, (0, 0, -1), atol=1e-12)
    np.testing.assert_allclose(optical_axes(0.0, 0.0)[:, 0], (0, -1, 0), atol=1e-12)
    assert "gain" in " ".join(poses.remarks)
    assert any("gain" in each for each in said)


def test_names_that_differ_by_capitals_or_in_how_letters_are_stored(tmp_path):
    files = [tmp_path / name for name in ("A.jpg", "a.jpg", "u\u0308ber.JPG", "b.png")]
    told = ("A.jpg", "a.jpg", "\u00fcber.jpg", "x/b", "A.JPG")
    names = Names(tmp_path, files, told, tmp_path)
    assert [names.find(each) for each in told[:4]] == files
    assert names.find("A.JPG") is None  # it may be either
