"""Of what several sources tell, the surest counts; what contradicts it is told, what makes no sense too."""

import json
import math

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from own_photographs import store, xmp
from scipy.spatial.transform import Rotation

from inspection.camera.survey_camera import SurveyCamera
from inspection.findings.command import main as findings
from inspection.photograph_poses.command import main
from inspection.photograph_poses.of_flight import Flight, Track
from inspection.photographs.calibration import calibration_of

ANGLES = {"GimbalYawDegree": "+90.0", "GimbalPitchDegree": "+0.0", "GimbalRollDegree": "+0.0"}
OF_35MM = {0xA405: 24}
AHEAD_IS_X = (-0.5, 0.5, -0.5, 0.5)


def place(*arguments, flight=None):
    return main([str(each) for each in arguments], lambda _: flight)


def record_of(path):
    return json.loads(path.with_suffix(".json").read_text())


def deviation_m(path):
    return math.sqrt(max(record_of(path)["covariance"][0:15:7]))


def focal_px(folder):
    return yaml.safe_load((folder / "calibration.yaml").read_text())["camera_matrix"]["data"][0]


def row(number, name, x_m, camera=1):
    """A line of images.txt: a camera at (x, 0, 0) whose axes are the model's."""
    return f"{number} 1 0 0 0 {-x_m} 0 0 {camera} {name}"


def write_model(folder, rows, cameras=("1 PINHOLE 64 48 50 50 32 24",)):
    folder.mkdir()
    (folder / "images.txt").write_text("\n".join(rows))
    (folder / "cameras.txt").write_text("\n".join(cameras))
    return folder


def shots(folder, *names, **given):
    folder.mkdir(parents=True)
    return [store(folder / name, **given) for name in names]


@pytest.mark.table("flight", ["north", "south"])
def test_of_two_flights_with_the_same_names_each_has_its_own_poses(tmp_path, capsys, flight):
    names = ("north/1.jpg", "north/2.jpg", "south/1.jpg")  # 2.jpg of the south is not in the model
    model = write_model(
        tmp_path / "m", [line for k, n in enumerate(names) for line in (row(k + 1, n, k), "")]
    )
    shots(tmp_path / "day" / flight, "1.jpg", "2.jpg")
    assert place(tmp_path / "day" / flight, "--colmap", model) == 0
    placed = sorted(path.stem for path in (tmp_path / "day" / flight).glob("*.json"))
    assert placed == (["1", "2"] if flight == "north" else ["1"])
    at_m = record_of(tmp_path / "day" / flight / "1.jpg")["position_m"]
    assert at_m == pytest.approx((0.0 if flight == "north" else 2.0, 0.0, 0.0), abs=1e-9)
    shots(tmp_path / "any", "1.jpg")
    assert place(tmp_path / "any", "--colmap", model) == 1
    said = capsys.readouterr().err
    assert "north/1.jpg" in said
    assert "south/1.jpg" in said


def test_a_table_of_two_flights_has_the_rows_of_its_own(tmp_path):
    (path,) = shots(tmp_path / "b", "1.jpg", block=OF_35MM)
    rows = "name,x,y,z,yaw_deg,tilt_deg\na/1.jpg,5,0,0,0,0\nb/1.jpg,7,0,0,0,0\n"
    (tmp_path / "t.csv").write_text(rows)
    assert place(tmp_path / "b", "--table", tmp_path / "t.csv") == 0
    assert record_of(path)["position_m"][0] == 7.0


def test_with_a_camera_for_each_picture_all_but_the_zoomed_one_are_placed(tmp_path, capsys):
    focal = (49.5, 50.0, 50.5, 70.0, 49.8)
    cameras = [f"{k} SIMPLE_RADIAL 64 48 {f} 32 24 0.001" for k, f in enumerate(focal)]
    rows = [line for k in range(5) for line in (row(k + 1, f"{k}.jpg", k, k), "1.5 2.5 -1")]
    shots(tmp_path / "p", *(f"{k}.jpg" for k in range(5)))
    assert place(tmp_path / "p", "--colmap", write_model(tmp_path / "m", rows, cameras)) == 0
    assert sorted(path.stem for path in (tmp_path / "p").glob("*.json")) == ["0", "1", "2", "4"]
    assert focal_px(tmp_path / "p") == pytest.approx(50.0, abs=0.25)
    assert "3.jpg" in capsys.readouterr().err


@pytest.mark.table("between", [["", ""], ["", "", ""], [], ["1.5 2.5 -1", ""], ["1.5 2.5 -1"]])
def test_empty_lines_in_a_model_do_no_harm(tmp_path, between):
    rows = ["# Image list", ""]
    for k in range(3):
        rows += [row(k + 1, f"{k}.jpg", k), *between]
    paths = shots(tmp_path / "p", *(f"{k}.jpg" for k in range(3)))
    assert place(tmp_path / "p", "--colmap", write_model(tmp_path / "m", rows)) == 0
    assert [record_of(path)["position_m"][0] for path in paths] == pytest.approx([0.0, 1.0, 2.0])


def test_xmp_behind_the_pixels_counts(tmp_path):
    (path,) = shots(tmp_path / "p", "1.jpg", gps=(54.0, 10.0, 3.0), block=OF_35MM)
    with path.open("ab") as stream:
        stream.write(bytes(600_000) + xmp(**ANGLES))
    assert place(tmp_path / "p", "--origin", "54,10,0") == 0
    assert record_of(path)["position_m"] == pytest.approx((0.0, 0.0, 3.0), abs=1e-6)


def test_a_height_of_exactly_0_is_none(tmp_path, capsys):
    told = xmp(**ANGLES, AbsoluteAltitude="+103.50")
    both, alone = (
        shots(tmp_path / name, "1.jpg", gps=(54.0, 10.0, 0.0), told=each, block=OF_35MM)[0]
        for name, each in (("both", told), ("alone", xmp(**ANGLES)))
    )
    assert place(both.parent, "--origin", "54,10,100") == 0
    assert record_of(both)["position_m"][2] == pytest.approx(3.5, abs=1e-6)
    assert place(alone.parent, "--origin", "54,10,100") == 1
    assert "1.jpg: It tells no height (GPS)" in capsys.readouterr().err


def test_a_lens_that_is_not_read_leaves_out_its_photographs_only(tmp_path, capsys):
    cameras = [f"{k} PINHOLE 64 48 50 50 32 24 # K\xfcste" for k in (1, 2)]
    cameras.append("3 OPENCV_FISHEYE 64 48 50 50 32 24 0.1 0 0 0")
    rows = [line for k in (1, 2, 3) for line in (row(k, f"{k}.jpg", k, k), "")]
    model = write_model(tmp_path / "m", rows)
    (model / "cameras.txt").write_bytes("\n".join(cameras).encode("latin-1"))
    paths = shots(tmp_path / "p", *(f"{k}.jpg" for k in (1, 2, 3)))
    assert place(tmp_path / "p", "--colmap", model) == 0
    assert [path.with_suffix(".json").exists() for path in paths] == [True, True, False]
    said = capsys.readouterr().err
    assert "3.jpg" in said
    assert "OPENCV_FISHEYE" in said


def test_photographs_that_a_model_has_in_several_folders_are_told(tmp_path, capsys):
    model = write_model(tmp_path / "m", [row(1, "north/1.jpg", 1), "", row(2, "south/2.jpg", 2), ""])
    for folder, is_told in (("any", True), ("south", False)):
        shots(tmp_path / folder, "1.jpg", "2.jpg")
        assert place(tmp_path / folder, "--colmap", model) == 0
        assert ("north and south" in capsys.readouterr().err) is is_told


def test_what_a_calibration_tells_is_no_matter_of_exif(tmp_path, capsys):
    told = xmp(
        **ANGLES, CalibratedFocalLength="50", CalibratedOpticalCenterX="32", CalibratedOpticalCenterY="24"
    )
    (path,) = shots(tmp_path / "p", "1.jpg", gps=(54.0, 10.0, 3.0), told=told)
    assert place(path.parent, "--origin", "54,10,0") == 0
    assert "50 px by XMP, may be wrong" in capsys.readouterr().err  # DJI's manual: the designed focal length
    camera = calibration_of(SurveyCamera(64, 48, 65.0))
    (path.parent / "calibration.yaml").write_text(yaml.safe_dump(camera))
    assert place(path.parent, "--origin", "54,10,0") == 0
    assert "may be wrong by some 2" not in capsys.readouterr().err


def test_heights_that_contradict_each_other_are_told_once(tmp_path, capsys):
    told = xmp(**ANGLES, AbsoluteAltitude="+103.50")
    shots(tmp_path / "p", "1.jpg", "2.jpg", gps=(54.0, 10.0, 50.0), told=told, block=OF_35MM)
    assert place(tmp_path / "p", "--origin", "54,10,100") == 0
    told = [line for line in capsys.readouterr().err.splitlines() if "103.50 m" in line and "50.00 m" in line]
    assert len(told) == 1


def test_a_fix_with_corrections_is_as_sure_as_it_tells(tmp_path):
    stds = {"RtkFlag": "50", "RtkStdLon": "0.012", "RtkStdLat": "0.011", "RtkStdHgt": "0.031"}
    told = xmp(**ANGLES, **stds, AbsoluteAltitude="+3")
    (path,) = shots(tmp_path / "p", "1.jpg", gps=(54.0, 10.0, 3.0), told=told, block=OF_35MM)
    assert place(tmp_path / "p", "--origin", "54,10,0") == 0
    assert deviation_m(path) == pytest.approx(0.031)


def straight_flight(speed_m_s):
    """Along x, level; the camera looks ahead. Known from 1000 to 1010 s."""
    stamps_s = 1000.0 + np.arange(101) / 10.0
    places = np.column_stack((speed_m_s * (stamps_s - 1000.0), np.zeros((101, 2))))
    track = Track(stamps_s, places, np.tile((0.0, 0.0, 0.0, 1.0), (101, 1)))
    return Flight(track, track, lambda _: ((0.0, 0.0, 0.0), AHEAD_IS_X))


WHOLE = {0x9003: "1970:01:01 00:16:43", 0x9011: "+00:00", 0xA405: 24}
"""1003 s."""


def test_a_time_in_whole_seconds_is_as_sure_as_the_uav_was_slow(tmp_path, capsys):
    (path,) = shots(tmp_path / "p", "1.jpg", block=WHOLE)
    assert place(tmp_path / "p", "--bag", "f.bag", flight=straight_flight(2.0)) == 0
    # some time from 1003 to 1004 s, evenly: 1003.5 s, and a standard deviation of 1 / sqrt(12) s
    assert record_of(path)["position_m"][0] == pytest.approx(2.0 * 3.5, abs=1e-6)
    assert deviation_m(path) == pytest.approx(2.0 / math.sqrt(12.0), abs=1e-6)
    assert "whole seconds" in capsys.readouterr().err


@pytest.mark.table(("name", "stamp_s"), [("1003.250000.jpg", 1003.25), ("1009.250000.jpg", 1003.5)])
def test_a_name_that_is_a_stamp_tells_the_part_of_a_second_unless_it_contradicts(tmp_path, name, stamp_s):
    (path,) = shots(tmp_path / "p", name, block=WHOLE)
    assert place(tmp_path / "p", "--bag", "f.bag", flight=straight_flight(2.0)) == 0
    assert record_of(path)["stamp_s"] == pytest.approx(stamp_s)


WHOLE_SIZE = (512, 384)


@settings(max_examples=20)
@given(
    share=st.sampled_from((1.0, 0.5, 0.25, 0.125)),
    size=st.sampled_from(("kept", "rewritten", "lost")),
    kind=st.sampled_from(("calibrated", "dewarp", "both")),
    equivalent=st.booleans(),
)
def test_a_copy_of_any_size_has_the_share_of_the_calibrated_focal_length(
    tmp_path_factory, share, size, kind, equivalent
):
    folder = tmp_path_factory.mktemp("p")
    copy = tuple(int(share * each) for each in WHOLE_SIZE)
    told = {"CalibratedOpticalCenterX": "256", "CalibratedOpticalCenterY": "192"}
    told |= {"CalibratedFocalLength": "400"} if kind != "dewarp" else {}
    told |= {"DewarpData": "d;400,400,0,0,0,0,0,0,0"} if kind != "calibrated" else {}
    block = {"kept": WHOLE_SIZE, "rewritten": copy, "lost": ()}[size]
    block = dict(zip((0xA002, 0xA003), block)) | (
        {0xA405: 27} if equivalent else {}
    )  # 27 * 640 / 43.27 = 399
    store(folder / "1.jpg", size=copy, gps=(54.0, 10.0, 3.0), told=xmp(**ANGLES, **told), block=block)
    assert place(folder, "--origin", "54,10,0") == 0
    assert focal_px(folder) == pytest.approx(400.0 * share, rel=1e-6)


def test_a_calibration_that_the_equivalent_focal_length_contradicts_does_not_count(tmp_path, capsys):
    """A copy of an eighth, of which nothing but the 35 mm equivalent tells the size."""
    told = xmp(**ANGLES, DewarpData="d;400,400,0,0,0,0,0,0,0")
    shots(tmp_path / "p", "1.jpg", gps=(54.0, 10.0, 3.0), told=told, block={0xA405: 27})
    assert place(tmp_path / "p", "--origin", "54,10,0") == 0
    assert focal_px(tmp_path / "p") == pytest.approx(27.0 * 80.0 / math.hypot(36.0, 24.0))
    assert "DewarpData" in capsys.readouterr().err


def test_a_model_of_reduced_copies_gives_the_camera_of_the_originals(tmp_path):
    shots(tmp_path / "p", "1.jpg")
    model = write_model(tmp_path / "m", [row(1, "1.jpg", 0.0), ""], ["1 PINHOLE 32 24 25 25 16 12"])
    assert place(tmp_path / "p", "--colmap", model) == 0
    told = yaml.safe_load((tmp_path / "p" / "calibration.yaml").read_text())
    assert (told["image_width"], told["image_height"]) == (64, 48)
    assert told["camera_matrix"]["data"][:3] == pytest.approx([50.0, 0.0, 31.5])


def test_gps_that_contradicts_a_model_is_told(tmp_path, capsys):
    given = {"gps": (54.001, 10.0, 3.0), "told": xmp(**ANGLES, AbsoluteAltitude="3"), "block": OF_35MM}
    shots(tmp_path / "p", "1.jpg", **given)  # 111 m north of the map's origin; the model says: 0 m
    model = write_model(tmp_path / "m", [row(1, "1.jpg", 0.0), ""])
    assert place(tmp_path / "p", "--colmap", model, "--origin", "54,10,3") == 0
    assert "111.3" in capsys.readouterr().err
    assert place(tmp_path / "p", "--colmap", model, "--origin", "54.001,10,3") == 0
    assert "EXIF" not in capsys.readouterr().err


def test_known_places_tell_how_sure_a_model_is(tmp_path):
    at = {f"{k}.jpg": np.array(p, float) for k, p in enumerate(((0, 0, 0), (4, 0, 0), (0, 4, 0), (4, 4, 0)))}
    paths = shots(tmp_path / "p", *at)
    rows = [f"{k} 1 0 0 0 {-x} {-y} {-z} 1 {name}\n" for k, (name, (x, y, z)) in enumerate(at.items(), 1)]
    signs = (1.0, -1.0, -1.0, 1.0)  # of heights that no turn, shift or scale makes good
    known = [f"{name},{x},{y},{z + 0.2 * s}" for (name, (x, y, z)), s in zip(at.items(), signs)]
    (tmp_path / "k.csv").write_text("\n".join(["name,x,y,z", *known]))
    model = write_model(tmp_path / "m", rows)
    assert place(tmp_path / "p", "--colmap", model, "--places", tmp_path / "k.csv") == 0
    assert [deviation_m(path) for path in paths] == pytest.approx([0.2] * 4, rel=1e-6)


def test_a_photograph_that_the_corrected_table_leaves_out_loses_its_pose_unless_it_is_kept(tmp_path, capsys):
    first, second = shots(tmp_path / "p", "1.jpg", "2.jpg", block=OF_35MM)
    (tmp_path / "wrong.csv").write_text("name,x,y,z,yaw_deg,tilt_deg\n1.jpg,9,0,0,0,0\n2.jpg,9,0,0,0,0\n")
    (tmp_path / "right.csv").write_text("name,x,y,z,yaw_deg,tilt_deg\n1.jpg,1,0,0,0,0\n")
    assert place(first.parent, "--table", tmp_path / "wrong.csv") == 0
    assert place(first.parent, "--table", tmp_path / "right.csv", "--keep") == 0
    assert "2.json" in capsys.readouterr().err
    assert record_of(second)["position_m"][0] == 9.0
    second.with_suffix(".json").write_text(second.with_suffix(".json").read_text())
    assert place(first.parent, "--table", tmp_path / "right.csv") == 0
    assert "2.json" in capsys.readouterr().err
    assert not second.with_suffix(".json").exists()
    assert (record_of(first)["position_m"][0], record_of(first)["source"]) == (1.0, "right.csv")


def test_a_calibration_that_an_earlier_call_wrote_yields_to_a_surer_one(tmp_path):
    shots(tmp_path / "p", "1.jpg", gps=(54.0, 10.0, 3.0), told=xmp(**ANGLES), block=OF_35MM)
    assert place(tmp_path / "p", "--origin", "54,10,0") == 0
    model = write_model(tmp_path / "m", [row(1, "1.jpg", 0.0), ""])
    assert place(tmp_path / "p", "--colmap", model) == 0
    assert focal_px(tmp_path / "p") == pytest.approx(50.0)
    assert Rotation.from_quat(record_of(tmp_path / "p" / "1.jpg")["orientation_xyzw"]).magnitude() < 1e-9


def test_a_calibration_of_another_camera_than_the_pictures_tell_of_is_told(tmp_path, capsys):
    (path,) = shots(tmp_path / "p", "1.jpg", block=OF_35MM)  # 24 * 80 / 43.27 = 44 px
    (tmp_path / "t.csv").write_text("name,x,y,z,yaw_deg,tilt_deg\n1.jpg,0,0,0,0,0\n")
    assert place(path.parent, "--table", tmp_path / "t.csv") == 0
    wall = tmp_path / "wall.obj"
    wall.write_text("v 3 -9 -9\nv 3 9 -9\nv 3 0 9\nf 1 2 3\n")
    capsys.readouterr()
    for camera, is_told in ((SurveyCamera(64, 48, 71.0), False), (SurveyCamera(64, 48, 40.0), True)):
        (path.parent / "calibration.yaml").write_text(yaml.safe_dump(calibration_of(camera)))
        assert findings([str(path.parent), "--mesh", str(wall)]) == 0
        said = capsys.readouterr().err
        assert ("88 px" in said and "44 px" in said) == is_told  # 32 / tan 20 deg
