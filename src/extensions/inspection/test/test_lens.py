"""Given a real lens, pixels and rays are those of OpenCV's model, and what is not read is refused."""

import json
from dataclasses import replace

import numpy as np
import pytest
import yaml
from PIL import Image

from inspection.camera.lens import Lens
from inspection.camera.photograph_pose import PhotographPose
from inspection.camera.survey_camera import SurveyCamera
from inspection.findings.parameters import FindingParameters
from inspection.findings.picture.candidates import Candidate
from inspection.findings.placing import MeshSurface, PosedPhotograph
from inspection.photographs.calibration import calibration_of, read_camera
from inspection.photographs.listing import listed
from inspection.photographs.record import PhotographError
from inspection.survey import SurveyParameters
from inspection.survey.showing import Showing
from inspection.survey.surface.mesh_file import Mesh
from inspection.survey.surface.samples import SurfacePoints
from inspection.survey.views.candidates import View

WIDE = Lens((700.0, 690.0), (655.0, 470.0), (-0.2, 0.04, 0.0006, -0.0004, -0.002, 0.0, 0.0, 0.0))
"""Like that of an action camera; 1280 x 960 px."""
RATIONAL = Lens((700.0, 700.0), (640.0, 480.0), (0.4, 0.1, 0.0, 0.0, 0.01, 0.7, 0.2, 0.02))
CAMERA = SurveyCamera(1280, 960, 85.0, lens=WIDE)


def by_opencv(points_m, lens):
    """projectPoints, as its manual writes it."""
    k1, k2, p1, p2, k3, k4, k5, k6 = lens.distortion
    x, y = points_m[:, 0] / points_m[:, 2], points_m[:, 1] / points_m[:, 2]
    r = np.hypot(x, y)
    scale = (1 + k1 * r**2 + k2 * r**4 + k3 * r**6) / (1 + k4 * r**2 + k5 * r**4 + k6 * r**6)
    u = lens.focal_px[0] * (x * scale + 2 * p1 * x * y + p2 * (r**2 + 2 * x**2)) + lens.centre_px[0]
    v = lens.focal_px[1] * (y * scale + p1 * (r**2 + 2 * y**2) + 2 * p2 * x * y) + lens.centre_px[1]
    return np.column_stack((u, v))


@pytest.mark.table("lens", [WIDE, RATIONAL])
def test_points_are_drawn_where_opencv_draws_them_and_rays_lead_back(lens):
    camera = SurveyCamera(1280, 960, 85.0, lens=lens)
    points_m = np.random.default_rng(1).uniform((-2.0, -1.5, 2.0), (2.0, 1.5, 6.0), (500, 3))
    pixels, drawn = camera.drawn(points_m)
    expected = by_opencv(points_m, lens)
    inside = ((expected >= 0) & (expected <= (1279, 959))).all(axis=1)
    assert inside.sum() > 200
    np.testing.assert_array_equal(drawn, inside)
    np.testing.assert_allclose(pixels[drawn], expected[drawn], atol=1e-9)
    np.testing.assert_allclose(camera.rays(pixels[drawn]), points_m[drawn] / points_m[drawn, 2:], atol=2e-5)


def test_without_distortion_it_is_the_pinhole():
    pinhole = SurveyCamera(1280, 960, 85.0)
    same = replace(pinhole, lens=Lens((pinhole.focal_px,) * 2, pinhole.centre_px))
    points_m = np.random.default_rng(2).uniform(-3.0, 3.0, (200, 3))
    (pixels, drawn), (others, others_drawn) = pinhole.drawn(points_m), same.drawn(points_m)
    np.testing.assert_array_equal(drawn, others_drawn)
    np.testing.assert_allclose(pixels[drawn], others[drawn], atol=1e-9)
    np.testing.assert_allclose(same.half_extents, pinhole.half_extents, rtol=1e-9)
    assert same.longest_ray == pytest.approx(pinhole.longest_ray)


def wall(far_m=3.0):
    return np.array([[(far_m, -90.0, -90.0), (far_m, 90.0, -90.0), (far_m, 0.0, 180.0)]])


def test_a_spot_at_the_edge_of_a_distorted_picture_is_placed_and_measured():
    """A round spot of 0.1 m radius on a wall 3 m ahead along x, near the picture's corner."""
    turn = PhotographPose.of_view(View((0.0, 0.0, 0.0), 0.0, 0.0)).axes
    middle_yz = np.array((1.75, 1.15))
    v, u = np.mgrid[0:960, 0:1280]
    pixels = np.column_stack((u.ravel(), v.ravel())).astype(float)
    rays = CAMERA.rays(pixels) @ turn.T
    places = rays[:, 1:] / rays[:, :1] * 3.0
    inside = np.hypot(*(places - middle_yz).T) < 0.1
    # the rays themselves are checked against OpenCV's formula above
    spot = Candidate("rust", pixels[inside][::3], int(inside.sum()))
    taken = PhotographPose.of_view(View((0.0, 0.0, 0.0), 0.0, 0.0))
    placed = PosedPhotograph(MeshSurface(wall()), CAMERA, taken, FindingParameters(), "1.jpg").place(spot)
    np.testing.assert_allclose(placed.points_m.mean(axis=0), (3.0, *middle_yz), atol=0.003)
    assert placed.area_m2 == pytest.approx(np.pi * 0.01, rel=0.02)
    # Taken for a pinhole of the same focal length it lies far off, and is too small
    naive = SurveyCamera(1280, 960, 85.0)
    off = PosedPhotograph(MeshSurface(wall()), naive, taken, FindingParameters(), "1.jpg").place(spot)
    assert np.linalg.norm(off.points_m.mean(axis=0) - (3.0, *middle_yz)) > 0.1


def test_coverage_ends_where_the_distorted_picture_does():
    y, z = (each.ravel() for each in np.meshgrid(np.arange(-4.0, 4.0, 0.02), np.arange(-4.0, 4.0, 0.02)))
    points_m = np.column_stack((np.full(y.size, 3.0), y, z))
    normals = np.tile((-1.0, 0.0, 0.0), (y.size, 1))
    points = SurfacePoints(points_m, normals, np.full(y.size, 4e-4), np.zeros(y.size, int))
    mesh = Mesh(wall(3.0), ("wall",), np.zeros(1, int))
    taken = PhotographPose.of_view(View((0.0, 0.0, 0.0), 0.0, 0.0))
    shown = Showing(mesh, points, CAMERA, SurveyParameters(resolution=50.0, incidence=80.0)).by([taken])
    pixels = by_opencv(points_m @ taken.axes, WIDE)
    aside = np.hypot(y, z) / 3.0
    inside = ((pixels >= 0) & (pixels <= (1279, 959))).all(axis=1) & (aside < 1.8)
    assert (shown == inside).mean() > 0.9999


def calibration(**more):
    return {**calibration_of(CAMERA), **more}


def test_a_calibration_comes_back_as_it_was(tmp_path):
    path = tmp_path / "calibration.yaml"
    for camera in (CAMERA, SurveyCamera(1280, 960, 85.0, lens=RATIONAL), SurveyCamera(1280, 960, 85.0)):
        path.write_text(yaml.safe_dump(calibration_of(camera)))
        assert read_camera(path).lens == camera.lens
        np.testing.assert_allclose(read_camera(path).matrix, camera.matrix, rtol=1e-6)


@pytest.mark.table(
    ("more", "told"),
    [
        ({"distortion_model": "equidistant"}, "equidistant"),
        ({"distortion_coefficients": {"data": [0.1] * 12}}, "12 distortion coefficients"),
        ({"distortion_coefficients": {"data": [-3.0, 0, 0, 0, 0]}}, "cannot be undone"),
        ({"distortion_coefficients": {"data": [float("nan")] * 5}}, "distortion"),
        ({"camera_matrix": {"data": [700.0]}}, "nine numbers"),
        ({"camera_matrix": {"data": [700.0, 9.0, 640, 0, 700, 480, 0, 0, 1]}}, "not that of a camera"),
        ({"camera_matrix": {"data": [0.0, 0, 640, 0, 0, 480, 0, 0, 1]}}, "focal_px"),
        ({"camera_matrix": {"data": ["a"] * 9}}, "calibration"),
        ({"camera_matrix": {"data": [1400.0, 0, 1310, 0, 1380, 940, 0, 0, 1]}}, "principal point"),  # twice
        ({"camera_matrix": {"data": [560.0, 0, 524, 0, 552, 376, 0, 0, 1]}}, "principal point"),  # 0.8 times
        (
            {"camera_matrix": {"data": [805.0, 0, 753.3, 0, 793.5, 540.6, 0, 0, 1]}},
            "principal point",
        ),  # 1.15 times
        ({"camera_matrix": {"data": [700.0, 0, 655, 0, 525, 470, 0, 0, 1]}}, "another shape"),  # 4:3 as 16:9
        (
            {"distortion_model": "", "distortion_coefficients": {"data": [-0.2, 0.04, 0, 0]}},
            "four distortion",
        ),
        ({"fisheye_model": 1}, "fisheye"),
        ({"camera_matrix": {"data": [700.0, float("nan"), 640, 0, 700, 480, 0, 0, 1]}}, "line 4: .+ is nan"),
        ({"distortion_coefficients": {"rows": 1, "cols": 5, "data": [0.1] * 4}}, "4 numbers for 1 x 5"),
        ({"image_width": 10**400}, "image_width is 1000.+; it must be a whole number"),
        ({"focal_deviation": -1.0}, "focal_deviation"),
    ],
)
def test_a_calibration_that_is_not_read_is_refused(tmp_path, more, told):
    (tmp_path / "calibration.yaml").write_text(yaml.safe_dump(calibration(**more)))
    with pytest.raises(PhotographError, match=told):
        read_camera(tmp_path / "calibration.yaml")


def test_a_calibration_of_opencvs_samples_is_read(tmp_path):
    told, path = calibration_of(CAMERA), tmp_path / "calibration.yaml"
    lines = ["%YAML:1.0", "---", "image_Width: 1280", "image_Height: 960"]
    for name, key, rows, cols in (
        ("Camera_Matrix", "camera_matrix", 3, 3),
        ("Distortion_Coefficients", "distortion_coefficients", 5, 1),
    ):
        data = ", ".join(f"{each!r}" for each in told[key]["data"])
        lines += [f"{name}: !!opencv-matrix", f"   rows: {rows}", f"   cols: {cols}", "   dt: d"]
        lines += [f"   data: [ {data} ]"]
    path.write_text("\n".join(lines) + "\n")
    assert read_camera(path).lens == CAMERA.lens
    path.write_text("%YAML:1.0\n---\ncamera_matrix: [1\n")
    with pytest.raises(PhotographError) as refused:
        read_camera(path)
    assert "\n" not in str(refused.value)


def test_a_reduced_copy_is_left_out(tmp_path):
    (tmp_path / "calibration.yaml").write_text(yaml.safe_dump(calibration()))
    for name, size in (("1.jpg", (1280, 960)), ("2.jpg", (640, 480)), ("3.jpg", (960, 1280))):
        Image.new("RGB", size, (120, 120, 120)).save(tmp_path / name)
        pose = {"position_m": [0.0, 0.0, 0.0], "orientation_xyzw": [0.0, 0.0, 0.0, 1.0]}
        (tmp_path / name).with_suffix(".json").write_text(json.dumps(pose))
    listing = listed(tmp_path)
    assert [path.name for path, _ in listing.whole] == ["1.jpg"]
    assert ["640 x 480 px" in listing.left_out[0].why, "960 x 1280 px" in listing.left_out[1].why] == [
        True,
        True,
    ]
