"""A wall with an opening between two places: where it is, and how wide."""

import numpy as np
import pytest
import trimesh

from flights.results.narrow_way import Cushions, narrowest_on_way, what_passes, why_it_stayed
from gridslam.evaluation.volume.surface import Surface

HERE_M, GOAL_M = np.array((1.0, 0.0, 1.5)), np.array((7.0, 0.5, 1.5))
WALL_X_M = 4.05


def wall(width_m, height_m=1.0, y_m=0.0, z_m=1.5):
    """A wall across y from -4 to 4.5 m and z from -2 to 5 m, with an opening about (y, z)."""
    left, right, low, high = y_m - width_m / 2, y_m + width_m / 2, z_m - height_m / 2, z_m + height_m / 2
    parts = [(-4, left, -2, 5), (right, 4.5, -2, 5), (left, right, -2, low), (left, right, high, 5)]
    boxes = [
        trimesh.creation.box(bounds=((WALL_X_M - 0.05, a, c), (WALL_X_M + 0.05, b, d)))
        for a, b, c, d in parts
        if b > a and d > c
    ]
    corners = np.concatenate([np.array(box.triangles) for box in boxes])
    return Surface(corners, ("wall",), np.zeros(len(corners), int))


def narrowest(surface):
    return narrowest_on_way(surface, HERE_M, GOAL_M, np.random.default_rng(1))


@pytest.mark.table(("width_m", "height_m"), [(0.6, 0.8), (1.4, 1.2)])
def test_the_least_side_of_an_opening_is_its_width(width_m, height_m):
    found = narrowest(wall(width_m, height_m))
    assert found.width_m == pytest.approx(min(width_m, height_m), abs=0.15)
    assert found.place_m == pytest.approx((WALL_X_M, 0.0, 1.5), abs=0.3)


def test_a_wide_way_has_no_narrow_place_and_a_closed_wall_no_way():
    assert narrowest(wall(5.0, 4.0)) is None
    assert narrowest(wall(0.0)).width_m == 0.0


def test_the_sentence_names_place_width_and_what_is_needed():
    told = why_it_stayed(wall(0.8), HERE_M, GOAL_M, Cushions(0.8, 0.45), np.random.default_rng(1))
    assert "at (4." in told
    assert "0.7 m wide" in told
    assert "needs 1.6 m" in told
    assert "model:=small_quad" in told
    small = Cushions(0.2, 0.15)
    assert why_it_stayed(wall(5.0, 4.0), HERE_M, GOAL_M, small, np.random.default_rng(1)) == ""


@pytest.mark.table(
    ("width_m", "said"),
    [
        (0.9, "set /cepa r_lb 0.45`"),  # half of it, with 0.1 m beside the body
        (0.8, "set /cepa r_lb 0.4`"),
        (0.7, "needs 0.7 m (body_radius)"),
        (0.5, "model:=small_quad"),  # which may be 0.6 m, by the error of the voxels
        (0.4, "No UAV of this workspace fits"),
    ],
)
def test_it_names_the_cushion_or_the_model_that_would_pass(width_m, said):
    assert said in what_passes(width_m, Cushions(0.5, 0.35))
