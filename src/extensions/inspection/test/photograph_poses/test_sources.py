"""Given COLMAP's model, a table or a flight, photographs get the poses that one works out by hand."""

import json

import numpy as np
import pytest
from own_photographs import store
from scipy.spatial.transform import Rotation

from inspection.photograph_poses.command import main
from inspection.photograph_poses.of_exif import read_all
from inspection.photograph_poses.of_flight import Flight, Track, poses_of_flight
from inspection.photograph_poses.table import similarity
from inspection.photographs.calibration import read_camera
from inspection.photographs.listing import pictures_in
from inspection.photographs.record import PhotographError

CAMERAS = (
    "# Camera list\n1 OPENCV 64 48 50 51 32.0 24.5 -0.1 0.02 0.001 -0.002\n2 PINHOLE 64 48 50 51 32 24\n"
)
AHEAD_IS_X = (-0.5, 0.5, -0.5, 0.5)
"""Quaternion x, y, z, w of a camera that looks along x, with its right along -y."""


def place(*arguments):
    return main([str(each) for each in arguments], None)


def pose_of(path):
    held = json.loads(path.with_suffix(".json").read_text())
    return np.array(held["position_m"]), Rotation.from_quat(held["orientation_xyzw"]).as_matrix()


def write_model(folder, cameras, *images):
    folder.mkdir(exist_ok=True)
    (folder / "cameras.txt").write_text(cameras)
    lines = []
    for number, (name, place_m, turn, camera) in enumerate(images, start=1):
        x, y, z, w = turn.inv().as_quat()
        shift = -turn.inv().apply(place_m)
        told = " ".join(f"{v:.12g}" for v in (w, x, y, z, *shift))
        lines += [f"{number} {told} {camera} {name}", "1.5 2.5 -1 3.5 4.5 7" if number % 2 else ""]
    (folder / "images.txt").write_text("# Image list\n" + "\n".join(lines) + "\n")
    return folder


TURN = Rotation.from_euler("zyx", (0.4, -0.3, 0.2))


def test_colmaps_poses_and_camera(tmp_path, capsys):
    shots = tmp_path / "shots"
    shots.mkdir()
    for name in ("DJI_1.JPG", "wall 2.png", "other.jpg", "lost.jpg"):
        store(shots / name)
    model = write_model(
        tmp_path / "model", CAMERAS, ("day 1/DJI_1.JPG", (1.0, 2.0, 3.0), TURN, 1),
        ("wall 2.png", (4.0, 5.0, 6.0), TURN, 1), ("other.jpg", (0.0, 0.0, 0.0), TURN, 2),
    )  # fmt: skip
    assert place(shots, "--colmap", model) == 0
    at, axes = pose_of(shots / "DJI_1.JPG")
    assert at == pytest.approx((1.0, 2.0, 3.0), abs=1e-9)
    assert axes == pytest.approx(TURN.as_matrix(), abs=1e-9)
    assert pose_of(shots / "wall 2.png")[0] == pytest.approx((4.0, 5.0, 6.0), abs=1e-9)
    lens = read_camera(shots / "calibration.yaml").lens
    assert lens.centre_px == (31.5, 24.0)  # COLMAP's pixels begin at a corner, ours in the middle
    assert lens.distortion[:4] == (-0.1, 0.02, 0.001, -0.002)
    said = capsys.readouterr().err
    assert "other.jpg: It was taken with another camera" in said
    assert "lost.jpg: It is not in COLMAP's model" in said


def test_a_model_is_moved_turned_and_scaled_to_known_places(tmp_path, capsys):
    shots, scale, shift = tmp_path / "shots", 2.5, (7.0, 8.0, 9.0)
    turn = Rotation.from_euler("zx", (1.0, 2.0))
    shots.mkdir()
    corners = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 2.0, 0.0), (1.0, 1.0, 3.0))
    places = {f"{k}.jpg": np.array(corner) for k, corner in enumerate(corners)}
    rows = ["name;x;y;z"]
    for name, at in places.items():
        store(shots / name)
        rows.append(f"{name};" + ";".join(f"{v:.9f}" for v in scale * turn.apply(at) + shift))
    (tmp_path / "places.csv").write_text("\n".join(rows[:-1]))  # three of four are known
    model = write_model(tmp_path / "model", CAMERAS, *((n, p, TURN, 1) for n, p in places.items()))
    assert place(shots, "--colmap", model, "--places", tmp_path / "places.csv") == 0
    at, axes = pose_of(shots / "3.jpg")
    assert at == pytest.approx(scale * turn.apply(places["3.jpg"]) + shift, abs=1e-6)
    assert axes == pytest.approx((turn * TURN).as_matrix(), abs=1e-6)
    assert "scale is 2.5; the places are 0.000 m off" in capsys.readouterr().err
    (tmp_path / "places.csv").write_text("\n".join(rows[:3]))
    assert place(shots, "--colmap", model, "--places", tmp_path / "places.csv") == 1
    assert "three or more that do not lie on one line" in capsys.readouterr().err


def test_a_similarity_is_no_mirror_image():
    given = np.array(((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1.0)))
    _, turn, _ = similarity(given, given * (1, 1, -1))
    assert np.linalg.det(turn) == pytest.approx(1.0)


@pytest.mark.table(
    ("cameras", "images", "why"),
    [
        ("1 OPENCV_FISHEYE 64 48 50 50 32 24 0 0 0 0", None, "OPENCV_FISHEYE is not read"),
        ("1 PINHOLE 64 48 50", None, "PINHOLE has 4 parameters"),
        ("2 PINHOLE 64 48 50 50 32 24", None, "no camera 1"),
        (None, "1 1 0 0 0 0 0 0 1 a.jpg\n1.5 2.5\n", "each second line one of points"),
        (None, "1 0 0 0 0 0 0 0 1 a.jpg\n\n", "line 1"),
        (None, "", "there is no photograph"),
        (None, "1 1 0 0 0 0 0 0 1 z.jpg\n\n", "none of its 1 photographs"),
    ],
)
def test_a_model_that_cannot_be_used_is_refused_in_a_sentence(tmp_path, capsys, cameras, images, why):
    shots = tmp_path / "shots"
    shots.mkdir()
    store(shots / "a.jpg")
    model = write_model(tmp_path / "model", cameras or CAMERAS, ("a.jpg", (0.0, 0.0, 0.0), TURN, 1))
    if images is not None:
        (model / "images.txt").write_text(images)
    assert place(shots, "--colmap", model) == 1
    assert why in capsys.readouterr().err
    assert not (shots / "a.json").exists()


def test_a_model_in_binary_is_told_how_to_become_text(tmp_path, capsys):
    store(tmp_path / "a.jpg")
    (tmp_path / "images.bin").write_bytes(b"")
    assert place(tmp_path, "--colmap", tmp_path) == 1
    assert "model_converter" in capsys.readouterr().err


BLOCK = {0xA405: 24}


@pytest.mark.table(
    "table",
    [
        "name,x,y,z,qx,qy,qz,qw,exposure_s,iso,lux\nA,1,2,3,-0.5,0.5,-0.5,0.5,0.01,,90\n",
        "\ufeffFile name;X (m);Y (m);Z (m);Yaw (deg);Tilt (deg)\na.JPG;1,0;2,0;3,0;0;0\n",
        "image\tlatitude\tlongitude\taltitude\tyaw\tpitch\troll\na.JPG\t54\t10\t3\t90\t0\t0\n",
    ],
)
def test_a_table_of_poses(tmp_path, capsys, table):
    path = store(tmp_path / "a.JPG", block=BLOCK)
    (tmp_path / "poses.csv").write_text(table)
    assert place(tmp_path, "--table", tmp_path / "poses.csv", "--origin", "54,10,0") == 0
    at, axes = pose_of(path)
    assert at == pytest.approx((0.0, 0.0, 3.0) if "latitude" in table else (1.0, 2.0, 3.0), abs=1e-6)
    assert axes[:, 2] == pytest.approx((1.0, 0.0, 0.0), abs=1e-6)
    assert axes[:, 0] == pytest.approx((0.0, -1.0, 0.0), abs=1e-6)
    held = json.loads(path.with_suffix(".json").read_text())
    light = (0.01, 200.0, 90.0) if "lux" in table else (0.002, 200.0, None)
    assert (held["exposure_s"], held["iso"], held["lux"]) == light


@pytest.mark.table(
    ("rows", "why"),
    [
        ("a.jpg,1,2,,0,0", "line 2: z must be a finite number"),
        ("a.jpg,1,2,3,nan,0", "line 2: yaw_deg must be"),
        ("a.jpg,1,2,3,0,0\na.jpg,1,2,3,0,0", "line 3: a.jpg has a row before"),
        ("b.jpg,1,2,3,0,0", "b.jpg: It is in poses.csv, but not in the folder"),
    ],
)
def test_a_row_that_cannot_be_used_is_named(tmp_path, capsys, rows, why):
    store(tmp_path / "a.jpg", block=BLOCK)
    (tmp_path / "poses.csv").write_text("name,x,y,z,yaw_deg,tilt_deg\n" + rows)
    assert place(tmp_path, "--table", tmp_path / "poses.csv") == 1
    assert why in capsys.readouterr().err


def flight(mount_m=(0.2, 0.0, 0.1)):
    """Along odometry's x at 1 m/s, level. SLAM's path: odometry, turned left by 90 deg, and moved."""
    odometry_s, path_s = 1000.0 + np.arange(101) / 10.0, 1000.0 + 2.0 * np.arange(6)
    turn = Rotation.from_euler("z", 90, degrees=True).as_quat()
    places = np.column_stack((odometry_s - 1000.0, np.zeros_like(odometry_s), np.full_like(odometry_s, 2.0)))
    in_map = np.column_stack((np.full_like(path_s, 5.0), path_s - 1000.0, np.zeros_like(path_s)))
    return Flight(
        Track(path_s, in_map, np.tile(turn, (len(path_s), 1))),
        Track(odometry_s, places, np.tile((0.0, 0.0, 0.0, 1.0), (len(odometry_s), 1))),
        lambda _: (mount_m, AHEAD_IS_X),
    )


AT_1003_5 = {0x9003: "1970:01:01 01:16:43", 0x9291: "50", 0x9011: "+01:00", 0xA405: 24}


def test_a_flights_photographs_lie_on_slams_path_by_their_times(tmp_path):
    store(tmp_path / "IMG_0001.JPG", block=AT_1003_5)
    (pose,) = poses_of_flight(read_all(pictures_in(tmp_path))[0], flight()).of.values()
    # 3.5 s along y, from (5, 0); the path is one in the plane, so odometry tells the height; the camera is
    # 0.2 m ahead and 0.1 m above
    assert pose.position_m == pytest.approx((5.0, 3.7, 2.1), abs=1e-6)
    axes = Rotation.from_quat(pose.orientation_xyzw).as_matrix()
    assert axes[:, 2] == pytest.approx((0.0, 1.0, 0.0), abs=1e-6)
    assert pose.stamp_s == pytest.approx(1003.5)


def test_a_clock_that_is_behind_is_set_right_and_times_outside_of_the_flight_are_told(tmp_path):
    store(tmp_path / "late.jpg", block={**AT_1003_5, 0x9003: "1970:01:01 01:06:43"})
    with pytest.raises(PhotographError, match=r"from 1000\.000 to 1010\.000 s.*403\.500.*--clock"):
        poses_of_flight(read_all(pictures_in(tmp_path))[0], flight())
    (pose,) = poses_of_flight(read_all(pictures_in(tmp_path))[0], flight(), clock_s=600.0).of.values()
    assert pose.position_m == pytest.approx((5.0, 3.7, 2.1), abs=1e-6)


def test_a_photograph_without_a_time_or_in_a_gap_is_left_out(tmp_path):
    store(tmp_path / "a.jpg", block=AT_1003_5)
    store(tmp_path / "untimed.jpg")
    store(tmp_path / "1001.5.jpg")  # its name is a stamp
    given = flight()
    odometry = Track(*(each[(np.arange(101) < 30) | (np.arange(101) > 40)] for each in given.odometry))
    poses = poses_of_flight(read_all(pictures_in(tmp_path))[0], Flight(given.path, odometry, given.mount))
    assert [path.name for path in poses.of] == ["1001.5.jpg"]
    assert {each.name: each.why for each in poses.left_out} == {
        "untimed.jpg": "It tells no time (EXIF's DateTimeOriginal).",
        "a.jpg": "The bag does not tell where the UAV was at 1003.500 s.",
    }


def test_a_gimbal_keeps_the_camera_level(tmp_path):
    store(tmp_path / "a.jpg", block=AT_1003_5)
    given = flight()
    leaning = np.tile(Rotation.from_euler("x", 0.2).as_quat(), (len(given.odometry.stamps_s), 1))
    tilted = Flight(given.path, given.odometry._replace(turns=leaning), given.mount)
    for is_level, lowered in ((True, 0.0), (False, -np.sin(0.2))):
        (pose,) = poses_of_flight(read_all(pictures_in(tmp_path))[0], tilted, is_level=is_level).of.values()
        right = Rotation.from_quat(pose.orientation_xyzw).as_matrix()[:, 0]
        assert right[2] == pytest.approx(lowered, abs=1e-6)
