"""Given photographs with GPS and a gimbal's angles, their poses are those that one works out by hand."""

import json
import math

import numpy as np
import pytest
from own_photographs import store, xmp
from PIL.TiffImagePlugin import IFDRational
from scipy.spatial.transform import Rotation

from flight_basics.errors import FlightBasicsError
from inspection.camera.survey_camera import SurveyCamera
from inspection.photograph_poses.command import main
from inspection.photograph_poses.exif import read_exif
from inspection.photograph_poses.world_frame import WorldFrame
from inspection.photographs.calibration import read_camera
from inspection.photographs.folder import PhotographFolder
from inspection.photographs.listing import listed
from inspection.photographs.record import PhotographRecord

FOCAL = {0x920A: IFDRational(88, 10), 0xA405: 24}
LEVEL_EAST = xmp(GimbalYawDegree="+90.00", GimbalPitchDegree="+0.00", GimbalRollDegree="+0.00")


def place(*arguments):
    return main([str(each) for each in arguments], None)


def axes_of(path):
    held = json.loads(path.with_suffix(".json").read_text())
    return np.array(held["position_m"]), Rotation.from_quat(held["orientation_xyzw"]).as_matrix()


@pytest.mark.table("as_elements", [False, True])
def test_place_and_direction_follow_gps_and_gimbal(tmp_path, capsys, as_elements):
    # 0.001 deg of latitude at 54 deg N is 111.305 m of the meridian; 0.001 deg of longitude 65.58 m
    angles = xmp(as_elements, GimbalYawDegree="+0.00", GimbalPitchDegree="-30.00", GimbalRollDegree="+0.00")
    path = store(tmp_path / "DJI_0012.JPG", gps=(54.001, 10.001, 32.5), told=angles, block=FOCAL)
    assert place(tmp_path, "--origin", "54,10,30") == 0
    at, axes = axes_of(path)
    assert at == pytest.approx((65.58, 111.305, 2.5), abs=0.01)
    assert axes[:, 2] == pytest.approx((0.0, math.cos(math.radians(30)), -0.5), abs=1e-6)  # north and down
    assert axes[:, 0] == pytest.approx((1.0, 0.0, 0.0), abs=1e-6)  # east is to the right
    held = json.loads(path.with_suffix(".json").read_text())
    assert (held["exposure_s"], held["iso"], held["lux"]) == (0.002, 200.0, None)
    said = capsys.readouterr()
    assert "Places by EXIF's GPS may be wrong by some 6.6 m" in said.err
    assert "without distortion" in said.err
    assert "placed: 1 of 1" in said.out
    assert len(listed(tmp_path).whole) == 1


def test_the_map_may_be_turned_and_its_heights_may_be_those_above_the_take_off(tmp_path):
    angles = xmp(GimbalYawDegree="+120.0", GimbalPitchDegree="+0", RelativeAltitude="+7.25", RtkFlag="50")
    path = store(tmp_path / "a.jpeg", gps=(-54.001, -10.0, 99.0), told=angles, block=FOCAL)
    assert place(tmp_path, "--origin=-54,-10", "--heading", "30") == 0  # x to 30 deg from north
    at, axes = axes_of(path)
    # 111.3 m south: against x by cos 30, and to the left by sin 30
    assert at == pytest.approx((-111.305 * math.cos(math.radians(30)), -111.305 * 0.5, 7.25), abs=0.01)
    assert axes[:, 2] == pytest.approx((0.0, -1.0, 0.0), abs=1e-6)  # 90 deg to the right of x


def test_a_roll_to_the_right_lowers_the_right_side():
    axes = WorldFrame(0.0, 0.0).axes(0.0, 0.0, 10.0)
    assert axes[2, 0] == pytest.approx(-math.sin(math.radians(10)))


def test_straight_down_the_top_of_the_picture_is_where_the_gimbal_points():
    axes = WorldFrame(0.0, 0.0).axes(0.0, -90.0, 0.0)
    assert axes[:, 2] == pytest.approx((0.0, 0.0, -1.0), abs=1e-9)
    assert -axes[:, 1] == pytest.approx((0.0, 1.0, 0.0), abs=1e-9)  # north


@pytest.mark.table(
    ("given", "why"),
    [
        ({"told": LEVEL_EAST}, "no place"),
        ({"told": LEVEL_EAST, "gps": (0.0, 0.0, 0.0)}, "no place"),
        ({"gps": (54.0, 10.0, 3.0)}, "no direction"),
    ],
)
def test_what_cannot_be_placed_is_named_and_the_others_are_placed(tmp_path, capsys, given, why):
    store(tmp_path / "good.jpg", gps=(54.0, 10.0, 3.0), told=LEVEL_EAST, block=FOCAL)
    store(tmp_path / "bad.jpg", block=FOCAL, **given)
    assert place(tmp_path, "--origin", "54,10,0") == 0
    said = capsys.readouterr().err
    assert "bad.jpg" in said
    assert why in said
    assert not (tmp_path / "bad.json").exists()


def test_without_an_origin_nothing_is_guessed(tmp_path, capsys):
    store(tmp_path / "a.jpg", gps=(54.0, 10.0, 3.0), told=LEVEL_EAST, block=FOCAL)
    assert place(tmp_path) == 1
    assert "--origin" in capsys.readouterr().err
    assert place(tmp_path, "--origin", "first") == 0
    assert axes_of(tmp_path / "a.jpg")[0] == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)


CALIBRATED = xmp(CalibratedFocalLength="47.5", CalibratedOpticalCenterX="32", CalibratedOpticalCenterY="24")


@pytest.mark.table(
    ("block", "told", "focal_px"),
    [
        ({0xA405: 24}, b"", 24.0 * 80.0 / 43.2666),  # of diagonals: 80 px, and 43.27 mm of a full frame
        ({0x920A: IFDRational(10, 1), 0xA20E: IFDRational(50, 1), 0xA210: 3}, b"", 50.0),
        ({0xA405: 24}, CALIBRATED, 47.5),
    ],
)
def test_the_focal_length_in_px(tmp_path, block, told, focal_px):
    path = store(tmp_path / "a.jpg", told=told, block=block)
    assert read_exif(path).camera.value.focal_px == pytest.approx(focal_px)


PLANE = {0x920A: IFDRational(10, 1), 0xA20E: IFDRational(100, 1), 0xA210: 3}  # 100 px a cm, 10 mm: 100 px


@pytest.mark.table(("block", "told"), [(PLANE, b""), ({}, xmp(DewarpData="d;100,100,4,-2,0,0,0,0,0"))])
def test_a_copy_of_half_the_size_has_half_the_focal_length(tmp_path, block, told):
    kept = {**block, 0xA002: 128, 0xA003: 96}  # of the original; the copy has 64 x 48 px
    camera = read_exif(store(tmp_path / "a.jpg", told=told, block=kept)).camera.value
    assert camera.focal_px == pytest.approx(50.0)
    if told:  # from the corner: (63.5 + 4 + 0.5) / 2 = 34 and (47.5 - 2 + 0.5) / 2 = 23
        assert camera.lens.centre_px == pytest.approx((33.5, 22.5))


@pytest.mark.table("original", [(128, 48), (48, 64)])
def test_of_what_is_cut_out_or_turned_nobody_knows_the_camera(tmp_path, original):
    path = store(tmp_path / "a.jpg", block={**PLANE, **dict(zip((0xA002, 0xA003), original))})
    assert read_exif(path).camera is None


def test_djis_own_calibration_has_its_distortion_unless_the_picture_is_undistorted(tmp_path):
    data = "2019-01-01;50,51,0.5,-0.25,-0.1,0.02,0.001,-0.002,0.003"
    lens = read_exif(store(tmp_path / "a.jpg", told=xmp(DewarpData=data, DewarpFlag="0"))).camera.value.lens
    assert (lens.focal_px, lens.centre_px) == ((50.0, 51.0), (32.0, 23.25))
    assert lens.distortion == (-0.1, 0.02, 0.001, -0.002, 0.003, 0.0, 0.0, 0.0)
    lens = read_exif(store(tmp_path / "b.jpg", told=xmp(DewarpData=data, DewarpFlag="1"))).camera.value.lens
    assert not any(lens.distortion)


def test_a_picture_zoomed_in_is_no_picture_of_this_camera(tmp_path, capsys):
    for name, focal in (("a", 24), ("b", 24), ("c", 70)):
        store(tmp_path / f"{name}.jpg", gps=(54.0, 10.0, 3.0), told=LEVEL_EAST, block={0xA405: focal})
    assert place(tmp_path, "--origin", "54,10,0") == 0
    assert "c.jpg: It was taken with another camera or zoom" in capsys.readouterr().err
    assert not (tmp_path / "c.json").exists()


def test_a_calibration_of_ones_own_stays_and_a_record_of_another_program_does_too(tmp_path, capsys):
    path = store(tmp_path / "a.jpg", gps=(54.0, 10.0, 3.0), told=LEVEL_EAST)
    assert place(tmp_path, "--origin", "54,10,0") == 1
    assert "calibration.yaml" in capsys.readouterr().err  # nothing tells the focal length
    store(path, gps=(54.0, 10.0, 3.0), told=LEVEL_EAST, block=FOCAL)
    assert place(tmp_path, "--origin", "54,10,0") == 0
    before = (tmp_path / "calibration.yaml").read_bytes()
    assert place(tmp_path, "--origin", "54,10,1") == 0  # our own are replaced
    assert axes_of(path)[0][2] == pytest.approx(2.0, abs=1e-6)
    assert (tmp_path / "calibration.yaml").read_bytes() == before
    path.with_suffix(".json").write_text('{"position_m": [0, 0, 0]}')
    assert place(tmp_path, "--origin", "54,10,0") == 1
    assert "--replace" in capsys.readouterr().err
    assert place(tmp_path, "--origin", "54,10,0", "--replace") == 0


@pytest.mark.table("damage", [b"", b"\xff\xd8\xff\xe1\x00\x10Exif\0\0II*\0\xff\xff\xff\xff"])
def test_a_damaged_picture_is_named(tmp_path, damage):
    path = tmp_path / "a.jpg"
    path.write_bytes(damage)
    with pytest.raises(FlightBasicsError, match="cannot be read"):
        read_exif(path)


def test_our_own_photographs_tell_their_camera_and_its_serial_numbers(tmp_path):
    camera = SurveyCamera(64, 48, 60.0)
    folder = PhotographFolder(tmp_path, camera, "B-17", "L-4")
    record = PhotographRecord(1_700_000_000.25, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0), 0.002, 800.0)
    told = read_exif(folder.save(np.full((48, 64, 3), 120, np.uint8), record))
    assert told.serial == "B-17"
    assert told.taken.value == pytest.approx(1_700_000_000.25)
    assert told.has_zone
    assert told.camera.value.focal_px == pytest.approx(camera.focal_px, rel=1e-6)
    assert read_camera(tmp_path / "calibration.yaml") == camera


@pytest.mark.table(
    ("offset", "behind_s"),
    [
        ("+02:00", 7200),
        ("-03:30", -12600),
        ("+0200", 7200),
        ("+14:00", 50400),
        ("Z", 0),
        ("", 0),
        ("+99:99", 0),
    ],
)
def test_the_offset_from_utc_counts_if_it_is_one(tmp_path, offset, behind_s):
    store(tmp_path / "1.jpg", block={0x9003: "2026:05:01 10:15:00", 0x9291: "0", 0x9011: offset})
    told = read_exif(tmp_path / "1.jpg")
    assert told.taken.value == 1777630500 - behind_s
    assert told.has_zone == (behind_s != 0)


def test_degrees_beyond_the_pole_are_no_place(tmp_path):
    store(tmp_path / "1.jpg", gps=(95.0, 10.0, 0.0))
    assert read_exif(tmp_path / "1.jpg").place is None


def test_of_a_large_picture_nobody_warns(tmp_path, monkeypatch, recwarn):
    from PIL import Image

    monkeypatch.setattr(Image, "MAX_IMAGE_PIXELS", 64 * 48 - 1)
    store(tmp_path / "1.jpg", gps=(54.0, 10.0, 0.0))
    assert read_exif(tmp_path / "1.jpg").place.value == pytest.approx((54.0, 10.0))
    assert not recwarn.list
