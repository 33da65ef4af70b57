"""Plates through which beams went are bars, if they are as wide as a ladder; their voxels become cubes."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from flights.photographing.bars import AT_M, BEYOND_M, FLAT, THICK, are_bars, beams_on, cubes_of
from gridslam.volume import CloudNode, Pose
from gridslam.volume.clouds import KeptCloud, rounded
from gridslam.volume.plates import Plates
from inspection.survey.surface.rays import Rays

SIDE_M = 0.2
RESOLUTION_M = 0.2
FACE_M = 0.7
"""Where the fronts of all bars are, along x."""
WALL = trimesh.creation.box(bounds=((0.3, -3.0, -1.0), (0.4, 4.0, 8.0)))
RAILS = [trimesh.creation.box(bounds=((FACE_M - 0.05, y, 0.0), (FACE_M, y + 0.04, 4.0))) for y in (0.0, 0.46)]
RUNGS = [
    trimesh.creation.box(bounds=((FACE_M - 0.03, 0.04, z), (FACE_M, 0.46, z + 0.03)))
    for z in np.arange(0.2, 4.0, 0.3)
]
WEB = trimesh.creation.box(bounds=((FACE_M - 0.02, 0.0, 0.0), (FACE_M, 0.5, 4.0)))


def clouds(*bodies):
    """Clouds of bodies, seen from 15 places before them by beams that are evenly around."""
    sight, nodes = Rays(np.concatenate([each.triangles for each in bodies])), []
    rng = np.random.default_rng(5)
    for number in range(15):
        here_m = np.array((rng.uniform(1.5, 5.0), rng.uniform(-2.8, 3.5), rng.uniform(0.5, 3.5)))
        ways = rng.normal(size=(60_000, 3))
        ways /= np.linalg.norm(ways, axis=1)[:, None]
        range_m = sight.ranges_m(np.tile(here_m, (len(ways), 1)), ways)
        is_hit = np.isfinite(range_m) & (range_m < 30.0)
        points = ways[is_hit] * (range_m[is_hit] + rng.normal(0.0, 0.01, is_hit.sum()))[:, None]
        nodes.append(node(float(number), points, here_m))
    return nodes


def node(stamp_s, points_m, here_m):
    pose = Pose(np.eye(3), np.asarray(here_m, float))
    cloud = KeptCloud.of(rounded(points_m, RESOLUTION_M), RESOLUTION_M)
    return CloudNode(stamp_s, cloud, pose, pose, 5.0)


def upright(columns, rows=20):
    """A plate for each cell of the bars' front, also where one sees through, and the backs of these."""
    low = np.array([(FACE_M, SIDE_M * k, SIDE_M * i) for k in range(columns) for i in range(rows)])
    low = low.reshape(-1, 3)
    square = SIDE_M * np.array(((0, 0, 0), (0, 1, 0), (0, 1, 1), (0, 0, 1)))
    fronts = low[:, None] + square
    corners_m = np.concatenate((fronts, fronts[:, ::-1] - (0.03, 0.0, 0.0)))
    normals = np.repeat(np.array(((1.0, 0.0, 0.0), (-1.0, 0.0, 0.0))), len(low), axis=0)
    return Plates(corners_m, normals)


def test_plates_of_a_ladder_before_a_wall_are_bars():
    plates = upright(columns=3)
    assert are_bars(plates, beams_on(plates, clouds(WALL, *RAILS, *RUNGS))).all()


@pytest.mark.table(
    ("bodies", "columns"),
    [
        pytest.param((WALL, WEB), 3, id="a web"),
        pytest.param((WALL, RAILS[0]), 1, id="a rail alone, which beams pass"),
        pytest.param((WALL,), 0, id="nothing"),
    ],
)
def test_other_plates_are_none(bodies, columns):
    plates = upright(columns)
    assert not are_bars(plates, beams_on(plates, clouds(*bodies))).any()


def test_the_sides_of_its_rails_are_bars_and_the_deck_at_its_foot_is_none():
    deck = trimesh.creation.box(bounds=((0.0, -3.0, -0.1), (6.0, 4.0, 0.0)))
    front = upright(columns=3)
    # Their plates are wider than they are: points are off, and plates reach over gaps
    low = np.array([(FACE_M - 0.12, 0.0, SIDE_M * k) for k in range(20)])
    sides = low[:, None] + np.array(((0, 0, 0), (0.14, 0, 0), (0.14, 0, SIDE_M), (0, 0, SIDE_M)))
    low = np.array([(FACE_M - 0.1 + SIDE_M * k, SIDE_M * i, 0.0) for k in (-1, 0, 1) for i in range(3)])
    floor = low[:, None] + SIDE_M * np.array(((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)))
    facing = np.array(((0.0, -1.0, 0.0),) * len(sides) + ((0.0, 0.0, 1.0),) * len(floor))
    plates = Plates(np.concatenate((front.corners_m, sides, floor)), np.concatenate((front.normals, facing)))
    found = are_bars(plates, beams_on(plates, clouds(WALL, deck, *RAILS, *RUNGS)))
    assert found[: len(front)].all()
    assert found[len(front) : len(front) + len(sides)].mean() > 0.9
    assert not found[len(front) + len(sides) :].any()


def test_plates_that_no_beam_tells_about_are_none():
    plates = upright(columns=3)
    assert not are_bars(plates, beams_on(plates, [])).any()


@given(st.integers(0, 10_000))
def test_beams_are_counted_as_one_by_one(seed):
    rng = np.random.default_rng(seed)
    plates, here_m = turned_plates(rng), rng.uniform(-0.2, 0.2, 3)
    points_m = rounded(rng.uniform(-4.0, 4.0, (60, 3)), RESOLUTION_M)
    counted = beams_on(plates, [node(0.0, points_m, here_m)], every=1)
    through, met = np.zeros(len(plates), int), np.zeros(len(plates), int)
    for point_m in points_m.astype(float):
        for k, corners_m in enumerate(plates.corners_m):
            told = plain(corners_m, plates.normals[k], here_m, here_m + point_m)
            through[k] += told == "through"
            met[k] += told == "met"
    # A beam on the line of two thresholds may fall to either side: the sums are in float32
    assert np.abs(counted.through - through).sum() + np.abs(counted.met - met).sum() <= 2


def turned_plates(rng):
    """Five plates that face anywhere, one behind the other."""
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    square = rng.uniform(0.5, 1.5) * np.array(((-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0.0)))
    heights = 0.5 + np.cumsum(rng.uniform(0.03, 0.5, 5))
    corners_m = (square + np.c_[np.zeros((5, 2)), heights][:, None]) @ turn.T
    return Plates(corners_m, np.tile(turn[:, 2], (5, 1)))


def plain(corners_m, normal, here_m, end_m):
    """What a beam from here to its end does to a plate: met, through, or nothing."""
    way = (end_m - here_m) / np.linalg.norm(end_m - here_m)
    if np.linalg.norm(end_m - here_m) <= AT_M or abs(way @ normal) <= FLAT:
        return ""
    place_m = here_m + (corners_m[0] - here_m) @ normal / (way @ normal) * way
    along, up = corners_m[1] - corners_m[0], corners_m[3] - corners_m[0]
    shares = (place_m - corners_m[0]) @ along / (along @ along), (place_m - corners_m[0]) @ up / (up @ up)
    if (place_m - here_m) @ way <= 0.0 or not all(0.0 <= share <= 1.0 for share in shares):
        return ""
    behind_m = (end_m - place_m) @ way * abs(way @ normal)
    return "through" if behind_m > BEYOND_M else "met" if abs(behind_m) < AT_M else ""


def test_cubes_are_where_the_points_of_their_voxels_are_and_face_out():
    low_m = np.array((-1.0, 2.0, 0.5))
    faces_m = np.concatenate([faces_of(low_m + SIDE_M * np.array(each)) for each in ((3, 1, 4), (3, 1, 5))])
    own_m = low_m + SIDE_M * np.array((3, 1, 4)) + ((0.02, 0.05, 0.1), (0.04, 0.05, 0.12))
    corners_m, quads = cubes_of(faces_m, SIDE_M, low_m, np.vstack((own_m, (9.0, 9.0, 9.0))))
    cubes = trimesh.Trimesh(corners_m, np.concatenate((quads[:, [0, 1, 2]], quads[:, [0, 2, 3]])))
    assert cubes.is_watertight
    assert cubes.volume == pytest.approx(2 * (THICK * SIDE_M) ** 3)
    middles_m = corners_m.reshape(2, 8, 3).mean(axis=1)
    np.testing.assert_allclose(middles_m[0], own_m.mean(axis=0))
    np.testing.assert_allclose(middles_m[1], low_m + SIDE_M * np.array((3.5, 1.5, 5.5)))


def faces_of(low_m):
    """The six faces of a voxel, which face out."""
    corner = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    quads = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    return low_m + SIDE_M * corner[np.array(quads)]
