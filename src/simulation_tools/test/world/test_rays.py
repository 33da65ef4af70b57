"""Rays against closed forms: boxes, cylinders, spheres and planes, standing and moving."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from simulation_tools.geometry import Pose, quaternion_normalised
from simulation_tools.sdf.elements import Box, Cylinder, Plane, Sphere
from simulation_tools.world.rays import RayScene
from simulation_tools.world.shapes.meshes import SAGITTA_M, mesh_of

FLOAT32_M = 2e-5  # single precision at some tens of metres


def fan(count=720):
    angles = 2 * np.pi * np.arange(count) / count
    return angles, np.column_stack((np.cos(angles), np.sin(angles), np.zeros(count)))


def standing(geometry, pose=None):
    scene = RayScene()
    scene.put("thing", mesh_of(geometry).transformed(pose or Pose()))
    return scene


def to_box(half, origin, directions):
    """Slab method: the distance at which a ray enters a box centred on the origin."""
    with np.errstate(divide="ignore"):
        first, second = (-half - origin) / directions, (half - origin) / directions
    enter, leave = np.minimum(first, second).max(axis=1), np.maximum(first, second).min(axis=1)
    return np.where((enter <= leave) & (enter > 0), enter, np.inf)


def to_circle(radius, offset, directions):
    """Distance at which rays in the plane, from -offset, enter a circle about the origin."""
    along = directions[:, :2] @ offset
    miss = offset @ offset - along**2
    with np.errstate(invalid="ignore"):
        enter = along - np.sqrt(radius**2 - miss)
    return np.where((miss < radius**2) & (along > 0), enter, np.inf)


def test_a_box_is_hit_where_the_slab_method_says():
    _, directions = fan()
    origin = np.array((-5.0, 1.3, 0.1))
    ranges = standing(Box((2.0, 3.0, 1.0))).cast(origin, directions, 50.0)
    expected = to_box(np.array((1.0, 1.5, 0.5)), origin, directions)
    grazing = np.isfinite(ranges) != np.isfinite(expected)
    assert not grazing.any()
    hit = np.isfinite(expected)
    assert 40 < hit.sum() < 200
    np.testing.assert_allclose(ranges[hit], expected[hit], atol=FLOAT32_M)


@pytest.mark.table("radius", [0.1, 0.5, 3.0])
def test_a_cylinder_is_hit_within_the_tolerance_of_its_facets(radius):
    _, directions = fan(7200)
    offset = np.array((4.0, -3.0))
    ranges = standing(Cylinder(radius, 4.0), Pose.from_xyz_rpy(*offset, 0.0)).cast(
        np.zeros(3), directions, 50.0
    )
    expected = to_circle(radius, offset, directions)
    # Facets lie up to SAGITTA_M under the surface: 1 / cos(a) more along a ray at the angle a to the normal.
    along = directions[:, :2] @ offset
    cosine = np.sqrt(np.maximum(1 - (offset @ offset - along**2) / radius**2, 0.0))
    well_hit = np.isfinite(expected) & (cosine > 0.3)
    assert well_hit.sum() > 10
    excess = ranges[well_hit] - expected[well_hit]
    assert excess.min() > -FLOAT32_M
    assert (excess < SAGITTA_M / cosine[well_hit] * 1.3 + FLOAT32_M).all()
    assert np.isinf(ranges[along < 0]).all()


def test_a_sphere_above_and_the_ground_below():
    scene = RayScene()
    scene.put("ball", mesh_of(Sphere(1.0)).transformed(Pose.from_xyz_rpy(0, 0, 5)))
    scene.put("ground", mesh_of(Plane()))
    directions = np.array(((0, 0, 1.0), (0, 0, -1.0), (math.cos(0.1), 0, -math.sin(0.1)), (1.0, 0, 0)))
    ranges = scene.cast(np.array((0.0, 0.0, 2.0)), directions, 100.0)
    np.testing.assert_allclose(ranges, (2.0, 2.0, 2.0 / math.sin(0.1), math.inf), atol=SAGITTA_M)


def test_nothing_beyond_the_greatest_range_and_nothing_in_an_empty_world():
    _, directions = fan(8)
    assert np.isinf(RayScene().cast(np.zeros(3), directions, 10.0)).all()
    scene = standing(Box((1.0, 1.0, 1.0)), Pose.from_xyz_rpy(5, 0, 0))
    assert scene.cast(np.zeros(3), directions, 4.6)[0] == pytest.approx(4.5, abs=1e-5)
    assert np.isinf(scene.cast(np.zeros(3), directions, 4.4)).all()
    assert len(scene.cast(np.zeros(3), np.zeros((0, 3)), 4.4)) == 0


def test_no_ray_slips_through_the_seams_of_a_room():
    rng = np.random.default_rng(1)
    directions = rng.normal(size=(200_000, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    ranges = standing(Box((7.0, 5.0, 3.0))).cast(np.array((0.3, -0.2, 0.1)), directions, 100.0)
    assert np.isfinite(ranges).all()


POSES = st.builds(
    Pose,
    st.tuples(*[st.floats(-4.0, 4.0)] * 3),
    st.tuples(*[st.floats(-1.0, 1.0)] * 4)
    .filter(lambda q: sum(c * c for c in q) > 0.1)
    .map(quaternion_normalised),
)


@given(POSES, POSES)
def test_what_moves_is_hit_as_if_it_stood_there(pose, lidar):
    # Given the same box standing and moving, before a wall (odd numbers: no beam runs along a face)
    pose = pose @ Pose.from_xyz_rpy(0.0137, 0.0271, 0.0193, 0.011, 0.013, 0.017)
    wall = mesh_of(Box((0.1, 20.0, 20.0))).transformed(Pose.from_xyz_rpy(6, 0, 0))
    moving, fixed = RayScene(), RayScene()
    for scene in (moving, fixed):
        scene.put("wall", wall)
    fixed.put("box", mesh_of(Box((1.0, 2.0, 0.5))).transformed(pose))
    moving.put("box", None, [(mesh_of(Box((1.0, 2.0, 0.5))), lambda: pose)])
    # When a tilted lidar looks, then it sees the same
    directions = fan(360)[1] @ lidar.rotation.T
    a, b = (scene.cast(np.array(lidar.position_m), directions, 30.0) for scene in (moving, fixed))
    # (but for rays that graze an edge, which single precision may decide either way)
    differing = ~np.isclose(a, b, atol=1e-3)
    assert differing.sum() <= 2


def test_own_model_is_not_seen_whether_it_moves_or_stands():
    scene = standing(Box((2.0, 2.0, 2.0)))
    scene.put("mover", None, [(mesh_of(Box((1.0, 1.0, 1.0))), Pose)])
    scene.put("wall", mesh_of(Box((1.0, 9.0, 9.0))).transformed(Pose.from_xyz_rpy(5, 0, 0)))
    ahead = np.array(((1.0, 0.0, 0.0),))
    assert scene.cast(np.zeros(3), ahead, 9.0)[0] == pytest.approx(0.5)
    assert scene.cast(np.zeros(3), ahead, 9.0, "mover")[0] == pytest.approx(1.0)
    scene.remove("mover")
    assert scene.cast(np.zeros(3), ahead, 9.0, "thing")[0] == pytest.approx(4.5)


def test_rays_start_at_one_place_or_each_at_its_own():
    scene = standing(Box((2.0, 2.0, 2.0)))
    starts = np.array(((-5.0, 0.0, 0.0), (-3.0, 0.5, 0.0)))
    ahead = np.tile((1.0, 0.0, 0.0), (2, 1))
    np.testing.assert_allclose(scene.cast(starts, ahead, 50.0), (4.0, 2.0), atol=FLOAT32_M)
    np.testing.assert_allclose(scene.cast(starts[1], ahead, 50.0), (2.0, 2.0), atol=FLOAT32_M)
    with pytest.raises(ValueError, match="3 rays cannot start at 2 origins"):
        scene.cast(starts, np.tile((1.0, 0.0, 0.0), (3, 1)), 50.0)
