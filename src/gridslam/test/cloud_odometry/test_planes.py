"""The table of voxels, the planes and the match beside slow references."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from gridslam.cloud_odometry.kernels.planes import IS_PLANE, MIDDLE, NORMAL, normal_equations
from gridslam.cloud_odometry.kernels.table import EMPTY, key_of, slot_of
from gridslam.cloud_odometry.matching import PoseInSpace, match
from gridslam.cloud_odometry.parameters import CloudOdometryParameters
from gridslam.cloud_odometry.plane_map import POINTS_MIN, PlaneMap, thinned

PLACES = st.tuples(st.integers(0, 3), *[st.integers(-500_000, 500_000)] * 3)
P = CloudOdometryParameters()
MIDDLE_M = np.array((0.0, 0.0, 0.5))
"""A place over the floor and under the slope of `patches`."""


@given(st.lists(PLACES, min_size=2, max_size=50, unique=True))
def test_every_voxel_has_a_key_and_a_slot_of_its_own(places):
    keys, slots = np.full(64, EMPTY, dtype=np.int64), {}
    for place in places:
        key = key_of(*place)
        assert key >= 0
        slot = slot_of(keys, key)
        assert keys[slot] == EMPTY
        keys[slot], slots[place] = key, slot
    assert all(slot_of(keys, key_of(*place)) == slot for place, slot in slots.items())
    assert len(set(slots.values())) == len(places)


@given(st.integers(0, 2**32), st.integers(0, 300))
def test_thinned_keeps_the_first_point_of_each_cube(seed, number):
    points = np.random.default_rng(seed).uniform(-1.0, 1.0, (number, 3))
    first = {}
    for point in points:
        first.setdefault(tuple(np.floor(point / 0.3)), point)
    np.testing.assert_array_equal(thinned(points, 0.3), np.array(list(first.values())).reshape(-1, 3))


def patches(rng, number=4000):
    """Points on the floor, on a wall and on a slope, with 5 mm of noise."""
    u, v = rng.uniform(-3.0, 3.0, (2, number))
    kind = np.arange(number) % 3
    points = np.where(
        (kind == 0)[:, None],
        np.column_stack((u, v, 0 * u)),
        np.where(
            (kind == 1)[:, None], np.column_stack((0 * u + 2.1, u, v)), np.column_stack((u, v, 0.5 * u + 1.3))
        ),
    )
    return points + rng.normal(0.0, 0.005, points.shape)


def slow_planes(points):
    """Plane of each voxel by numpy: {(level, i, j, k): (normal, mean) or None}."""
    found = {}
    for level, side in enumerate(P.levels_m):
        places = np.floor(points / side).astype(int)
        for place in np.unique(places, axis=0):
            inside = points[(places == place).all(axis=1)]
            variances, axes = np.linalg.eigh(np.cov(inside.T, bias=True)) if len(inside) > 1 else (None, None)
            is_plane = len(inside) >= POINTS_MIN[level]
            is_plane = is_plane and variances[0] < P.flatness_m**2 and variances[1] > (0.12 * side) ** 2
            found[(level, *place)] = (axes[:, 0], inside.mean(axis=0)) if is_plane else None
    return found


def test_planes_are_those_of_numpy():
    rng = np.random.default_rng(3)
    points = patches(rng)
    planes = PlaneMap(P)
    planes.add(points, MIDDLE_M)
    expected = slow_planes(points)
    assert len(planes) == len(expected)
    assert sum(plane is not None for plane in expected.values()) > 100
    for place, plane in expected.items():
        slot = slot_of(planes.keys, key_of(*place))
        row = planes.planes[slot]
        assert planes.keys[slot] != EMPTY
        assert bool(row[IS_PLANE]) == (plane is not None)
        if plane is not None:
            normal, mean = plane
            assert abs(row[NORMAL : NORMAL + 3] @ normal) == pytest.approx(1.0, abs=1e-6)
            np.testing.assert_allclose(row[MIDDLE : MIDDLE + 3], mean, atol=1e-9)


def test_a_table_that_grows_keeps_its_planes():
    rng = np.random.default_rng(4)
    points = rng.uniform(-60.0, 60.0, (30_000, 3))
    points[:, 2] = 0.01 * rng.normal(size=len(points))
    planes = PlaneMap(P)
    slots = len(planes.keys)
    for part in np.array_split(points, 6):
        planes.add(part, np.array((0.0, 0.0, 1.0)))
    assert len(planes.keys) > slots
    assert len(planes) == len(slow_planes_count(points))


def slow_planes_count(points):
    return {
        (level, *place)
        for level, side in enumerate(P.levels_m)
        for place in np.floor(points / side).astype(int).tolist()
        for place in [tuple(place)]
    }


def test_normal_equations_are_those_of_numpy():
    rng = np.random.default_rng(6)
    planes = PlaneMap(P)
    planes.add(patches(rng), MIDDLE_M)
    expected = slow_planes(patches(np.random.default_rng(6)))
    pose = PoseInSpace(np.array([0.02, -0.03, 0.04]), Rotation.from_rotvec([0.01, -0.02, 0.03]).as_matrix())
    points, weights = patches(rng, 300), rng.uniform(0.5, 2.0, 300)
    information, pull, count, near = np.zeros((6, 6)), np.zeros(6), 0, 0
    for point, weight in zip(points, weights):
        turned = pose.rotation @ point
        there = turned + pose.place
        places = [(level, *np.floor(there / side).astype(int)) for level, side in enumerate(P.levels_m)]
        plane = next((expected[place] for place in places if expected.get(place)), None)
        if plane is None:
            continue
        normal, mean = plane
        e = normal @ (there - mean)
        jacobian = np.concatenate((normal, np.cross(turned, normal)))
        weight = weight / (1 + (e / 0.1) ** 2) ** 2
        information += weight * np.outer(jacobian, jacobian)
        pull -= weight * e * jacobian
        count += 1
        near += abs(e) <= 0.1
    ours, our_pull = np.empty((6, 6)), np.empty(6)
    found, found_near = normal_equations(
        points,
        weights,
        np.zeros(3),
        pose.rotation,
        pose.place,
        planes.levels_m,
        0.1,
        planes.keys,
        planes.planes,
        ours,
        our_pull,
    )
    assert found == count > 100
    assert found_near == near > 50
    np.testing.assert_allclose(ours, information, rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(our_pull, pull, rtol=1e-6, atol=1e-6)


@settings(max_examples=15)
@given(st.integers(0, 2**32))
def test_a_match_finds_the_pose_from_nearby(seed):
    """Moved by up to 0.15 m and turned by up to 3 degrees, with a prediction that is hardly trusted."""
    rng = np.random.default_rng(seed)
    planes = PlaneMap(P)
    planes.add(patches(np.random.default_rng(1), 12_000), MIDDLE_M)
    true = PoseInSpace(
        MIDDLE_M + rng.uniform(-0.1, 0.1, 3), Rotation.from_rotvec(rng.uniform(-0.03, 0.03, 3)).as_matrix()
    )
    seen = (patches(rng, 2000) - true.place) @ true.rotation
    guess = true.moved(np.concatenate((rng.uniform(-0.09, 0.09, 3), rng.uniform(-0.03, 0.03, 3))))
    weights = np.full(len(seen), 1.0 / (P.points_per_reading * P.point_noise_m**2))
    found = match(planes, seen, weights, np.zeros(3), guess, 1e-3 * np.eye(6), P)
    off = found.pose.difference(true)
    told = np.array([True, False, True])  # nothing tells y: floor, wall and slope are all parallel to it
    assert np.abs(off[:3][told]).max() < 0.01
    assert found.known > 0.6
    assert found.agreement > 0.9
    (direction,) = found.untold(P.told_m)
    assert abs(direction[1]) > 0.99


def level_points(rng, height_m):
    """Points of a level surface, 3 m wide."""
    x, y = rng.uniform(-1.5, 1.5, (2, 4000))
    return np.column_stack((x, y, np.full(4000, height_m))) + rng.normal(0.0, 0.005, (4000, 3))


def found_on(planes, points, place):
    """How many points (n, 3) of the map, seen from a place, find a plane."""
    information, pull, table = np.empty((6, 6)), np.empty(6), (planes.keys, planes.planes)
    seen = points - place, np.ones(len(points)), np.zeros(3), np.eye(3), place
    return normal_equations(*seen, planes.levels_m, 0.3, *table, information, pull)[0]


def test_a_plane_counts_for_who_is_on_its_side():
    """A deck 0.15 m thick: who climbs through a hole in it takes its top for no part of its underside."""
    rng = np.random.default_rng(8)
    below, above = np.array((0.0, 0.0, -1.0)), np.array((0.0, 0.0, 1.0))
    planes, underside, top = PlaneMap(P), level_points(rng, 0.05), level_points(rng, 0.2)
    planes.add(level_points(rng, 0.05), below)
    assert found_on(planes, underside, below) == len(underside)
    assert found_on(planes, top, above) == found_on(planes, top, np.array((0.0, 0.0, 0.15))) == 0


def test_few_points_of_its_top_make_a_deck_no_thin_plate():
    """They come into the voxels of its underside, whose planes are fitted anew for other points."""
    rng = np.random.default_rng(10)
    below, above = np.array((0.0, 0.0, -1.0)), np.array((0.0, 0.0, 1.0))
    planes, top = PlaneMap(P), level_points(rng, 0.2)
    for _ in range(2):
        planes.add(level_points(rng, 0.05), below)
        planes.add(top[::200], above)
    assert found_on(planes, top, above) == 0


def test_a_deck_has_two_sides_in_the_same_voxels():
    """Each side is where it is, and only who can see it finds it, whichever was seen first."""
    rng = np.random.default_rng(11)
    below, above = np.array((0.0, 0.0, -1.0)), np.array((0.0, 0.0, 1.0))
    for first, second in ((below, above), (above, below)):
        planes, seen = PlaneMap(P), {below[2]: level_points(rng, 0.05), above[2]: level_points(rng, 0.2)}
        for eye in (first, second):
            planes.add(seen[eye[2]], eye)
        for eye in (below, above):
            assert found_on(planes, seen[eye[2]], eye) > 0.95 * len(seen[eye[2]])
            assert mean_distance_m(planes, seen[eye[2]], eye) == pytest.approx(0.0, abs=0.003)


def test_the_rim_of_an_opening_makes_a_deck_no_thin_plate():
    """From above, the rim's side is seen near the underside's plane, and the top 0.15 m off it."""
    rng = np.random.default_rng(12)
    below, above = np.array((0.0, 0.0, -1.0)), np.array((0.0, 0.0, 1.0))
    planes, top = PlaneMap(P), level_points(rng, 0.2)
    planes.add(level_points(rng, 0.05), below)
    planes.add(np.vstack((top[:2000], level_points(rng, 0.05)[:200])), above)
    assert abs(mean_distance_m(planes, top, above)) < 0.01


def mean_distance_m(planes, points, place):
    """How far points (n, 3), seen from a place, lie above their planes in the mean, each alike."""
    information, pull, table = np.empty((6, 6)), np.empty(6), (planes.keys, planes.planes)
    seen = points - place, np.ones(len(points)), np.zeros(3), np.eye(3), place
    normal_equations(*seen, planes.levels_m, 1e3, *table, information, pull)
    return -pull[2] / information[2, 2]


def test_a_thin_plate_counts_for_both_sides_once_it_was_seen_from_both():
    rng = np.random.default_rng(9)
    below, above = np.array((0.0, 0.0, -1.0)), np.array((0.0, 0.0, 1.0))
    planes = PlaneMap(P)
    planes.add(level_points(rng, 0.05), below)
    planes.add(level_points(rng, 0.06), above)
    points = level_points(rng, 0.055)
    assert found_on(planes, points, below) > 0.9 * len(points)
    assert found_on(planes, points, above) > 0.9 * len(points)
