"""Extruded polylines: volume, surface and openings by closed form. Inside is what an odd number surrounds."""

from __future__ import annotations

import numpy as np
import pytest

from simulation_tools.geometry import Pose
from simulation_tools.sdf.elements import Polyline
from simulation_tools.sdf.parser import SdfError
from simulation_tools.world.shapes.extrusion import prisms
from simulation_tools.world.shapes.meshes import mesh_of
from simulation_tools.world.shapes.terrain import MeshError

from .conftest import mass, model, shape

ELL = ((0, 0), (4, 0), (4, 1), (1, 1), (1, 3), (0, 3))
SQUARE, HOLE = ((0, 0), (4, 0), (4, 4), (0, 4)), ((1, 1), (1, 3), (3, 3), (3, 1))
ISLAND = ((1.5, 1.5), (2.5, 1.5), (2.5, 2.5), (1.5, 2.5))


def sdf(*outlines, height=2.0):
    points = ["".join(f"<point>{x} {y}</point>" for x, y in outline) for outline in outlines]
    return "".join(f"<polyline>{each}<height>{height}</height></polyline>" for each in points)


def corners_of(solid):
    triangles = mesh_of(solid)
    return triangles.vertices[triangles.triangles]


@pytest.mark.table(
    ("outlines", "area_m2", "around_m"),
    [
        ((ELL,), 6.0, 14.0),
        ((ELL[::-1],), 6.0, 14.0),
        (((*ELL, ELL[0]),), 6.0, 14.0),  # closed in the file
        ((SQUARE, HOLE), 12.0, 24.0),
        ((SQUARE, HOLE, ISLAND), 13.0, 28.0),
        ((((0, 0), (3, 0), (0, 4)),), 6.0, 12.0),
        (((*SQUARE[:3], (2, 4), SQUARE[3]),), 16.0, 16.0),  # a corner on a straight side
    ],
)
def test_the_surface_is_closed_and_looks_outwards(outlines, area_m2, around_m):
    solid = Polyline(outlines, 2.0)
    a, b, c = corners_of(solid).transpose(1, 0, 2)
    across = np.cross(b - a, c - a)
    np.testing.assert_allclose(across.sum(axis=0), 0.0, atol=1e-12)
    assert (a * across).sum() / 6 == pytest.approx(2.0 * area_m2)  # divergence theorem, in each axis
    for axis in range(3):
        assert ((a + b + c)[:, axis] * across[:, axis]).sum() / 6 == pytest.approx(2.0 * area_m2)
    assert 0.5 * np.linalg.norm(across, axis=1).sum() == pytest.approx(2.0 * area_m2 + 2.0 * around_m)
    assert (a[:, 2].min(), a[:, 2].max()) == (0.0, 2.0)


def test_random_stars_have_the_volume_of_the_shoelace_formula():
    rng = np.random.default_rng(1)
    for _ in range(20):
        turn = np.sort(rng.uniform(0.0, 2 * np.pi, 12)) + 1e-3 * np.arange(12)
        x, y = rng.uniform(0.5, 3.0, 12) * np.array((np.cos(turn), np.sin(turn)))
        area_m2 = 0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1))
        a, b, c = corners_of(Polyline((tuple(zip(x, y)),), 0.5)).transpose(1, 0, 2)
        assert (a * np.cross(b, c)).sum() / 6 == pytest.approx(0.5 * area_m2)


def test_the_convex_parts_fill_the_shape_and_leave_the_hole_open():
    parts = prisms(Polyline((SQUARE, HOLE), 2.0))
    assert sum(np.ptp(part[:, 0]) * np.ptp(part[:, 1]) for part in parts) == pytest.approx(12.0)
    for part in parts:
        x, y = part[:, :2].mean(axis=0)
        assert not (1 < x < 3 and 1 < y < 3)


@pytest.mark.table("outlines", [(((0, 0), (2, 2), (2, 0), (0, 2)),), (((0, 0), (1, 1), (2, 2)),)])
def test_an_outline_that_crosses_itself_or_surrounds_nothing_is_said(outlines):
    with pytest.raises(MeshError, match="<polyline>"):
        mesh_of(Polyline(outlines, 1.0))


def test_the_elements_are_read_and_the_first_one_has_the_height_of_all():
    body = shape(sdf(SQUARE) + sdf(HOLE, height=9))
    (collision,) = model(f'<link name="l">{body}</link>').links[0].collisions
    assert collision.geometry == Polyline((SQUARE, HOLE), 2.0)
    with pytest.raises(SdfError, match="three different points"):
        model(f'<link name="l">{shape(sdf(SQUARE[:2]))}</link>')


@pytest.mark.parametrize("static", ["<static>1</static>", ""])
def test_bodies_and_rays_meet_it_and_pass_through_its_opening(build, static):
    # Given a frame with an opening, standing or moving, and a ball in its opening
    solid = shape(sdf(SQUARE, HOLE))
    frame = model(f'{static}<link name="l">{mass(1, 1, 1, 1)}{solid}</link>', "frame")
    ball = model(f'<link name="l">{shape("<sphere><radius>0.25</radius></sphere>")}</link>', "ball")
    world = build(frame, ball, gravity=(0, 0, 0))
    for place, free_m in (((2, 2, 1), 0.75), ((5, 2, 1), 0.75), ((2, 2, 3), 2**0.5 - 0.25)):
        assert world.clearance("ball", Pose(place), 5.0) == pytest.approx(free_m, abs=2e-3)
    assert world.clearance("ball", Pose((0.5, 2, 2.1)), 5.0) < 0.0
    down = np.array([[0.0, 0.0, -1.0]])
    ranges = [world.rays.cast(np.array((x, 2.0, 5.0)), down, 9.0)[0] for x in (2.0, 0.5)]
    assert ranges == [np.inf, pytest.approx(3.0)]
