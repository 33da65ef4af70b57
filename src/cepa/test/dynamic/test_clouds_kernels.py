"""The kernels for clouds against slow, plain references."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cepa.dynamic.constants.remembered import BESIDE_UP_M, PARTS_OF_A_MISS
from cepa.dynamic.cost_to_go.kernels.slowness import best_layers
from cepa.dynamic.free_space.kernels.clouds import level, open_empty, stamp_seen
from cepa.dynamic.free_space.kernels.unseen import unseen_layers
from cepa.dynamic.kernels.distance_layers import distance_layers, squares_for
from cepa.dynamic.remembered.kernels.voxels import NOBODY, Voxels, forget_far, have_stood, recall, remember

seeds = st.integers(0, 2**32 - 1)
CELL_M, FAR_M, SIDE, LAYERS, LAYER_M, BELOW_M, ABOVE_M = 0.1, 0.8, 31, 5, 0.15, 0.4, 0.25
SEEN = np.array([0.2, 0.15])
CELLS = [(i - 13, j - 13, k - 8) for i, j, k in np.ndindex(26, 26, 16)]
"""Those in reach of a UAV near the world's origin; indices y, x, z."""
NEVER_S, NOW_S, OLDEST_S = -math.inf, 10.0, 5.0


def turned(rng):
    """Return a random rotation matrix."""
    q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return q * np.sign(np.linalg.det(q))


@given(seed=seeds, count=st.integers(0, 40))
def test_each_layer_knows_the_distance_to_what_is_at_its_height(seed, count):
    rng = np.random.default_rng(seed)
    points = rng.uniform((-1.5, -1.5, -1), (1.5, 1.5, 1), (count, 3))
    field = np.empty((LAYERS, SIDE, SIDE))
    columns = np.empty((SIDE, SIDE), np.uint64)
    squares = squares_for(SIDE, CELL_M, FAR_M)
    distance_layers(points, 0.0, CELL_M, LAYER_M, BELOW_M, ABOVE_M, FAR_M, columns, squares, field)
    axis = CELL_M * (np.arange(SIDE) - SIDE // 2)
    level_m = LAYER_M / 7  # what 63 bits hold: 4 layers of 7 levels, and 30 for the body
    for layer, distances in enumerate(field):
        height = (layer - LAYERS // 2) * LAYER_M
        for widened, sign in ((0.0, 1), (level_m, -1)):
            low, high = height - BELOW_M, height + ABOVE_M + widened
            x, y = points[(low <= points[:, 2]) & (points[:, 2] <= high), :2].T
            offsets = np.hypot(axis[None, :, None] - x, axis[:, None, None] - y)
            true = np.minimum(offsets.min(axis=2, initial=math.inf), FAR_M)
            rounding_m = 0.5 * CELL_M * (math.sqrt(2.0) - sign)
            assert np.all(sign * (distances - true) <= rounding_m + 1e-6)


@given(seed=seeds, risen=st.sampled_from([-2, -1, 1, 2]))
def test_a_layer_stays_as_it_is_when_the_uav_climbs_into_the_next(seed, risen):
    rng = np.random.default_rng(seed)
    points = rng.uniform((-1.5, -1.5, -1), (1.5, 1.5, 1), (20, 3))
    columns, fields = np.empty((SIDE, SIDE), np.uint64), np.empty((2, LAYERS, SIDE, SIDE))
    squares = squares_for(SIDE, CELL_M, FAR_M)
    for field, risen_m in zip(fields, (0.0, risen * LAYER_M)):
        seen = points - (0.0, 0.0, risen_m)
        distance_layers(seen, 0.0, CELL_M, LAYER_M, BELOW_M, ABOVE_M, FAR_M, columns, squares, field)
    both = slice(max(risen, 0), LAYERS + min(risen, 0)), slice(max(-risen, 0), LAYERS + min(-risen, 0))
    np.testing.assert_array_equal(fields[0][both[0]], fields[1][both[1]])


def plain_layers(points, far_m):
    """The distances of `distance_layers`, layer by layer and obstacle by obstacle."""
    level_m, lowest_m = LAYER_M / 7, -(LAYERS // 2) * LAYER_M - BELOW_M
    columns, rows = (np.floor(points[:, axis] / CELL_M + 0.5).astype(int) + SIDE // 2 for axis in (0, 1))
    levels = np.floor((points[:, 2] - lowest_m) / level_m)
    within = (columns >= 0) & (columns < SIDE) & (rows >= 0) & (rows < SIDE)
    i, j = np.indices((SIDE, SIDE))
    for layer in range(LAYERS):
        top = 7 * layer + math.floor((BELOW_M + ABOVE_M) / level_m)
        counts = within & (7 * layer <= levels) & (levels <= min(63, top))
        squares = np.full((SIDE, SIDE), math.inf, np.float32)
        for row, column in zip(rows[counts], columns[counts]):
            squares = np.minimum(squares, ((i - row) ** 2 + (j - column) ** 2).astype(np.float32))
        yield np.minimum(far_m, np.maximum(0.0, (np.sqrt(squares).astype(float) - 0.5) * CELL_M))


@pytest.mark.table(("far_m", "integers"), [(0.8, np.uint16), (18.5, np.uint32)])
def test_each_layer_is_the_same_to_the_last_bit_as_obstacle_by_obstacle(far_m, integers):
    squares = squares_for(SIDE, CELL_M, far_m)
    assert squares.dtype == integers
    columns, field = np.empty((SIDE, SIDE), np.uint64), np.empty((LAYERS, SIDE, SIDE))
    for seed, count in enumerate((0, 1, 3, 10, 40, 400)):
        points = np.random.default_rng(seed).uniform((-1.7, -1.7, -1), (1.7, 1.7, 1), (count, 3))
        distance_layers(points, 0.0, CELL_M, LAYER_M, BELOW_M, ABOVE_M, far_m, columns, squares, field)
        for distances, expected in zip(field, plain_layers(points, far_m)):
            np.testing.assert_array_equal(distances, expected)


@given(seed=seeds)
def test_a_column_is_as_open_as_its_best_layer(seed):
    rng = np.random.default_rng(seed)
    distance, extra = rng.uniform(0.0, 1.5, (LAYERS, 11, 11)), np.array([0.4, 0.2, 0.0, 0.2, math.inf])
    slowness, offset = np.empty((5, 5)), rng.uniform(-0.1, 0.1, 2)
    best_layers(distance, 0.1, extra, 0.6, 0.5, 1.2, 0.2, offset, slowness)
    cells = 0.2 * (np.arange(5) - 2)
    columns, rows = (np.clip(np.rint((cells - o) / 0.1).astype(int) + 5, 0, 10) for o in offset)
    d = distance[:, rows[:, None], columns]
    cost = np.where(d < 0.6, math.inf, 1.0 + np.maximum(0.0, (1.2 - d) / 0.7)) + extra[:, None, None]
    np.testing.assert_allclose(slowness, cost.min(axis=0))


@given(seed=seeds, number=st.sampled_from([60, 600]))
def test_the_picture_of_a_cloud_holds_the_least_distance_in_each_direction(seed, number):
    rng = np.random.default_rng(seed)
    rotation = turned(rng)
    points = rng.uniform(-3.0, 3.0, (number, 3))
    points[::7], points[3] = math.nan, rotation.T @ (0.0, 0.0, 1.0)  # one is over the lidar
    nearest, levelled = np.empty((32, 24), np.float32), np.empty((number, 3))
    free = np.empty((8, 12), np.float32)
    count = level(points, rotation, 0.5, 4.0, 0.05, levelled, nearest, free)
    ranges = np.linalg.norm(points, axis=1)
    returns = points[(ranges >= 0.5) & (ranges <= 4.0)] @ rotation.T
    np.testing.assert_allclose(levelled[:count], returns, atol=1e-12)
    expected = np.full((32, 24), math.inf)
    for x, y, z in returns:
        h = math.hypot(x, y)
        row = math.floor(z / h / 0.05) + 16
        column = int((math.atan2(y, x) + math.pi) / math.radians(15.0)) % 24
        if 0 <= row < 32:
            expected[row, column] = min(expected[row, column], h)
    np.testing.assert_allclose(nearest, expected, rtol=1e-6)
    np.testing.assert_array_equal(free, nearest.reshape(8, 4, 12, 2).min(axis=(1, 3)))


def test_an_empty_direction_is_free_within_the_field_of_view_alone():
    free = np.full((8, 12), math.inf, np.float32)
    free[4, 0] = 2.0
    view = (math.radians(-15.0), math.radians(15.0)), (-0.5 * math.pi, 0.5 * math.pi)
    open_empty(free, 4, 0.05, np.eye(3), *view, 99.0)
    up = (np.arange(8) - 3.5) * 0.2  # tangents of the rows' middles
    ahead = (np.arange(12) - 5.5) * math.radians(30.0)
    looked = (np.abs(up) < math.tan(math.radians(15.0)))[:, None] & (np.abs(ahead) < 0.5 * math.pi)[None, :]
    expected = np.where(looked, 99.0, 0.0)
    expected[4, 0] = 2.0
    np.testing.assert_array_equal(free, expected)


@settings(max_examples=20)
@given(seed=seeds)
def test_the_field_of_view_of_a_lidar_that_leans_ends_where_its_angles_end(seed):
    rng = np.random.default_rng(seed)
    rotation, free = turned(rng), np.full((8, 12), math.inf, np.float32)
    low, high = np.sort(rng.uniform(-1.5, 1.5, 2))
    left, right = np.sort(rng.uniform(-2.5, 2.5, 2))
    open_empty(free, 4, 0.05, rotation, (low, high), (left, right), 99.0)
    for i, j in np.ndindex(free.shape):
        azimuth = (j + 0.5) * math.radians(30.0) - math.pi
        a, b, c = rotation.T @ (math.cos(azimuth), math.sin(azimuth), (i - 3.5) * 0.2)
        is_seen = low <= math.atan2(c, math.hypot(a, b)) <= high and left <= math.atan2(b, a) <= right
        assert free[i, j] == (99.0 if is_seen else 0.0)


@pytest.mark.table(("elevation", "no_return_m"), [((-2.0, 2.0), 99.0), ((1.58, 2.0), 0.0)])
def test_a_field_of_view_up_to_the_vertical_and_beyond_has_all_or_nothing(elevation, no_return_m):
    free = np.full((8, 12), math.inf, np.float32)
    open_empty(free, 4, 0.05, np.eye(3), elevation, (-math.pi, math.pi), 99.0)
    np.testing.assert_array_equal(free, no_return_m)


def plain_seen(free, row_tan, origin, own, near, before):
    """Return the cells (i, j, k: y, x, z) that are seen, by their definition."""
    rows, bins = free.shape
    seen = set()
    for cell in CELLS:
        y, x, z = (np.array(cell) + 0.5) * (SEEN[0], SEEN[0], SEEN[1]) - origin[[1, 0, 2]]
        if max(abs(x), abs(y)) > 2.0 or abs(z) > 0.8:
            continue
        h = math.hypot(x, y)
        row = math.floor(z / (h * row_tan) + 0.5 * rows)
        column = int((math.atan2(y, x) + math.pi) * bins / (2.0 * math.pi)) % bins
        is_free = 0 <= row < rows and free[row, column] > h + 0.5 * SEEN[0]
        is_own = h < own[0] and -own[1] <= z <= own[2]
        if is_free or is_own or (h < near and cell in before):
            seen.add(cell)
    return seen


def stamped(stamps, since_s):
    """Return the cells whose stamp is not older, for a grid around the world's origin."""
    n, levels = stamps.shape[0], stamps.shape[2]
    return {(i, j, k) for i, j, k in CELLS if stamps[i % n, j % n, k % levels] >= since_s}


@settings(max_examples=5)
@given(seed=seeds)
def test_cells_are_seen_up_to_what_stands_in_their_direction(seed):
    rng = np.random.default_rng(seed)
    stamps = np.full((30, 30, 16), NEVER_S)
    reach, own = np.array([2.0, 0.8]), np.array([0.5, 0.3, 0.2])
    before = set()
    for number in range(2):
        origin = rng.uniform(-0.4, 0.4, 3)
        free = rng.uniform(0.0, 4.0, (10, 24)).astype(np.float32)
        stamp_seen(free, 0.06, origin, NOW_S + number, OLDEST_S, SEEN, reach, own, 1.0, stamps)
        seen = plain_seen(free, 0.06, origin, own, 1.0, before)
        assert stamped(stamps, NOW_S + number) == seen
        before |= seen


@settings(max_examples=5)
@given(seed=seeds)
def test_a_layer_is_unseen_where_the_body_meets_an_unseen_cell(seed):
    rng = np.random.default_rng(seed)
    stamps = np.where(rng.random((30, 30, 24)) < 0.995, NOW_S, 0.0)
    origin, body = rng.uniform(-1.0, 1.0, 3), np.array([0.35, 0.2, 0.1])
    unseen = np.empty((LAYERS, 9, 9), np.bool_)
    heights = np.array([origin[2] - 0.2, 100.0])
    unseen_layers(stamps, origin, OLDEST_S, SEEN, LAYER_M, body, heights, unseen, 0, 9)
    for layer, i, j in np.ndindex(unseen.shape):
        height = (layer - LAYERS // 2) * LAYER_M
        row, column = (math.floor((origin[a] + 0.2 * (n - 4)) / 0.2) for a, n in ((1, i), (0, j)))
        low, high = (math.floor((origin[2] + height + end) / 0.15) for end in (-0.2, 0.1))
        meets = any(
            stamps[(row + di) % 30, (column + dj) % 30, k % 24] < OLDEST_S
            for di, dj in ((0, 0), (0, 1), (0, -1), (1, 0), (-1, 0), (1, 1), (1, -1), (-1, 1), (-1, -1))
            if 0 <= i + di < 9 and 0 <= j + dj < 9
            for k in range(low, high + 1)
        )
        assert unseen[layer, i, j] == (meets or height < -0.2)


class PlainMemory:
    """What `remember` and `recall` do, with a dictionary."""

    def __init__(self):
        self.cells = {}

    def remember(self, points, origin, stamp, reach):
        for point in points:
            if max(abs(point[0]), abs(point[1])) <= reach[0] and abs(point[2]) <= reach[1]:
                at = point + origin
                cell = tuple(np.floor(at / (0.15, 0.15, 0.05)).astype(int))
                begun = self.cells[cell][3] if cell in self.cells else stamp
                self.cells[cell] = [at, stamp, 0, begun]

    def have_stood(self, points, origin, before, apart, up):
        old = np.array([entry[0] for entry in self.cells.values() if entry[3] <= before]).reshape(-1, 3)
        away = np.abs(old - (points + origin)[:, None])
        return ((np.hypot(away[..., 0], away[..., 1]) <= apart) & (away[..., 2] <= up)).any(axis=1)

    def recall(self, origin, stamp, oldest, reach, nearest, row_tan, gap, near, misses):
        for cell, entry in list(self.cells.items()):
            x, y, z = entry[0] - origin
            h = math.hypot(x, y)
            beyond = max(abs(x), abs(y)) > reach[0] or abs(z) > reach[1]
            if entry[1] < oldest or beyond:
                del self.cells[cell]
            elif entry[1] < stamp:
                row = math.floor(z / (h * row_tan) + 0.5 * nearest.shape[0])
                column = int((math.atan2(y, x) + math.pi) * nearest.shape[1] / (2.0 * math.pi))
                columns = np.arange(column - 1, column + 2) % nearest.shape[1]
                inside = 0 < row < nearest.shape[0] - 1
                high = math.floor(BESIDE_UP_M / (h * row_tan))
                rows = np.arange(max(0, row - high - 1), min(nearest.shape[0], row + high + 2))
                around = nearest[np.ix_(rows, columns)] if inside else np.zeros((1, 3))
                looked = rows[np.isfinite(around).any(axis=1)] if inside else rows[:0]
                if (np.abs(looked - row) <= high).any() and around.min() > h + gap:
                    entry[2] += PARTS_OF_A_MISS if row in looked else 1
                    if entry[2] >= misses * PARTS_OF_A_MISS:
                        del self.cells[cell]
                elif h < near:
                    entry[1] = np.nextafter(stamp, -math.inf)
        return np.array(sorted(tuple(entry[0] - origin) for entry in self.cells.values())).reshape(-1, 3)


@settings(max_examples=20)
@given(seed=seeds)
def test_remembered_points_are_those_of_a_plain_dictionary(seed):
    rng = np.random.default_rng(seed)
    capacity, reach = 500, np.array([2.0, 0.8])
    stores = np.empty((capacity, 3)), np.empty(capacity), np.empty(capacity), np.empty(capacity, np.uint8)
    voxels = Voxels(*stores, np.full((40, 40, 48), NOBODY, np.int32), 0.15, 0.05)
    plain, known, recalled, counts = PlainMemory(), 0, np.empty((capacity, 3)), np.zeros(2)
    for number in range(12):
        origin, stamp = np.array([0.2 * number, 0.0, 0.05 * number]), 0.1 * number
        points = rng.uniform((-2.2, -2.2, -1.0), (2.2, 2.2, 1.0), (30, 3))
        nearest = rng.choice([1.0, 2.0, 5.0, math.inf], (40, 24), p=[0.1, 0.1, 0.6, 0.2]).astype(np.float32)
        rules = 0.05, 0.3, 1.0, 2
        known, rest = remember(points, origin, stamp, reach, voxels, known)
        assert not rest.size
        known = recall(origin, stamp, stamp - 0.45, reach, nearest, *rules, voxels, known, recalled)
        plain.remember(points, origin, stamp, reach)
        expected = plain.recall(origin, stamp, stamp - 0.45, reach, nearest, *rules)
        found = np.array(sorted(map(tuple, recalled[:known]))).reshape(-1, 3)
        np.testing.assert_allclose(found, expected, atol=1e-9)
        asked = points + rng.normal(0.0, 0.1, points.shape), origin, stamp - 0.25, 0.15, 0.2
        stood = have_stood(*asked, voxels)
        assert stood.tolist() == plain.have_stood(*asked).tolist()
        counts += stood.sum(), len(stood)
    assert known > 50
    assert 0 < counts[0] < 0.5 * counts[1]


def test_where_numbers_have_no_digits_left_for_cells_points_stay_within_the_grid():
    stores = np.empty((9, 3)), np.empty(9), np.empty(9), np.empty(9, np.uint8)
    voxels = Voxels(*stores, np.full((40, 40, 48), NOBODY, np.int32), 0.15, 0.05)
    origin, reach = np.array([1e18, -1e18, 1e18]), np.array([2.0, 0.8])
    points = np.random.default_rng(4).uniform(-0.8, 0.8, (9, 3))
    known, rest = remember(points, origin, 1.0, reach, voxels, 0)
    assert (known, rest.size) == (1, 0)  # all are at the same place
    assert (voxels.slots != NOBODY).sum() == 1
    i, j, m = (
        math.floor(place / edge) % n
        for place, edge, n in zip(origin[[1, 0, 2]], (0.15, 0.15, 0.05), (40, 40, 48))
    )
    assert voxels.slots[i, j, m] == 0


def test_near_the_lidar_a_beam_beside_a_point_tells_that_it_has_gone_but_slowly():
    # A picture with rows of 0.005; the channels are 10 rows apart, and the point is 3 rows above one: 6 mm
    stores = np.empty((2, 3)), np.empty(2), np.empty(2), np.empty(2, np.uint8)
    voxels = Voxels(*stores, np.full((40, 40, 48), NOBODY, np.int32), 0.15, 0.05)
    nearest = np.full((324, 720), math.inf, np.float32)
    nearest[2::10] = 3.0  # with a channel at row 162: the middle
    here, reach, points = np.zeros(3), np.array([2.0, 0.8]), np.empty((2, 3))
    known, _ = remember(np.array([[0.4, 0.0, 0.007]]), here, 0.0, reach, voxels, 0)
    clouds = 0
    while known:
        clouds += 1
        stamp_s = 0.1 * clouds
        known = recall(
            here, stamp_s, stamp_s - 20.0, reach, nearest, 0.005, 0.3, 1.5, 3, voxels, known, points
        )
    assert clouds == 3 * PARTS_OF_A_MISS


def test_a_full_list_forgets_what_is_far_and_tells_what_found_no_room():
    stores = np.empty((2, 3)), np.empty(2), np.empty(2), np.empty(2, np.uint8)
    voxels = Voxels(*stores, np.full((40, 40, 48), NOBODY, np.int32), 0.15, 0.05)
    points = np.array([[1.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.5, 0.0, 0.0], [0.12, 0.0, 0.0], [9.0, 0.0, 0.0]])
    here, reach = np.zeros(3), np.array([2.0, 0.8])
    known, rest = remember(points, here, 1.0, reach, voxels, 0)
    assert (known, rest.tolist()) == (2, [2])
    relative = voxels.points.copy()
    np.testing.assert_allclose(relative[:, 0], [1.0, 0.12])
    known = forget_far(0.5, voxels, known, relative)
    assert known == 1
    assert relative[0, 0] == voxels.points[0, 0] == pytest.approx(0.12)
    known, rest = remember(points[:3], here, 2.0, reach, voxels, known)
    assert (known, rest.tolist()) == (2, [2])  # the cell of the first point is free again
