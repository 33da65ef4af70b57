"""The pinhole: angles, distances and axes by hand, and the worst direction by a numerical derivative."""

import math

import numpy as np
import pytest

from inspection.survey import SurveyCamera, optical_axes
from inspection.survey.kernels.sight import axes_of, worst_scale


def test_a_camera_of_20_megapixels_and_60_degrees_draws_1_mm_per_pixel_at_4_49_m():
    camera = SurveyCamera()
    assert camera.focal_px == pytest.approx(2592.0 / math.tan(math.radians(30.0)))
    assert camera.distance_m(1.0) == pytest.approx(4.489, abs=1e-3)
    assert camera.distance_m(1.0, incidence_deg=60.0) == pytest.approx(2.245, abs=1e-3)


def test_a_point_is_drawn_where_the_matrix_puts_it_and_not_if_it_is_behind_or_beside():
    camera = SurveyCamera()
    beside_m = 3.0 * camera.half_extents[0] + 0.01
    points_m = np.array(
        ((0.0, 0.0, 2.0), (0.4, -0.3, 1.5), (0.4, -0.3, -1.5), (beside_m, 0.0, 3.0), (0.0, 0.0, 0.0))
    )
    pixels, is_drawn = camera.drawn(points_m)
    assert is_drawn.tolist() == [True, True, False, False, False]
    by_matrix = points_m[:2] @ camera.matrix.T
    np.testing.assert_allclose(pixels[:2], by_matrix[:, :2] / by_matrix[:, 2:], rtol=1e-12)
    assert np.isfinite(pixels).all()


def test_the_view_of_yaw_0_and_tilt_0_looks_along_x_with_the_picture_upright():
    right, down, ahead = optical_axes(0.0, 0.0).T
    np.testing.assert_allclose(right, (0.0, -1.0, 0.0), atol=1e-12)
    np.testing.assert_allclose(down, (0.0, 0.0, -1.0), atol=1e-12)
    np.testing.assert_allclose(ahead, (1.0, 0.0, 0.0), atol=1e-12)


@pytest.mark.table(("yaw", "tilt"), [(0.3, 0.5), (-2.0, -math.pi / 2), (3.0, 1.2)])
def test_optical_axes_are_right_handed_and_the_kernel_has_the_same(yaw, tilt):
    axes = optical_axes(yaw, tilt)
    np.testing.assert_allclose(axes.T @ axes, np.eye(3), atol=1e-12)
    assert np.linalg.det(axes) == pytest.approx(1.0)
    np.testing.assert_allclose(axes_of(yaw, tilt), axes, atol=1e-12)
    assert axes[2, 2] == pytest.approx(math.sin(tilt))


def on_plane(pixel, point, normal):
    """Where the line of sight through a place in the picture (at depth 1) meets a plane."""
    direction = np.array((*pixel, 1.0))
    return direction * (normal @ point) / (normal @ direction)


def test_the_worst_scale_is_the_greatest_stretch_of_the_picture_on_the_surface():
    rng = np.random.default_rng(5)
    for _ in range(50):
        x, y, z = rng.uniform(-0.6, 0.6), rng.uniform(-0.45, 0.45), rng.uniform(0.5, 6.0)
        point = z * np.array((x, y, 1.0))
        normal = rng.normal(size=3)
        normal /= np.linalg.norm(normal)
        if abs(normal @ point) < 0.3 * np.linalg.norm(point):
            continue
        turns = np.linspace(0.0, math.pi, 721)
        steps = 1e-6 * np.stack((np.cos(turns), np.sin(turns)), axis=1)
        moved = np.array([on_plane(np.array((x, y)) + step, point, normal) - point for step in steps])
        expected = np.linalg.norm(moved, axis=1).max() / 1e-6
        assert worst_scale(x, y, z, normal, 0.0) == pytest.approx(expected, rel=1e-4)


def test_a_motion_during_the_exposure_widens_a_pixel_in_quadrature():
    """On a wall that the camera faces, the motion moves the picture by its own length."""
    ahead = np.array((0.0, 0.0, -1.0))
    assert worst_scale(0.0, 0.0, 3.0, ahead, 4.0) == pytest.approx(5.0)
