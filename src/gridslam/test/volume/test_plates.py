"""Given points on planes that are known, the plates lie on them; each side of a thin plate has its own."""

import numpy as np
import pytest

from gridslam.volume import CloudNode, KeptCloud, Pose
from gridslam.volume.kernels.plates import around, refit
from gridslam.volume.plates import PlateParameters, plates_of, points_of

NOISE_M = 0.008
SIDE_M = 2.0


def node_at(sensor_m, points_m):
    """A node whose cloud are these points (n, 3) of the map."""
    pose = Pose(np.eye(3), np.asarray(sensor_m, float))
    cloud = KeptCloud.of((points_m - pose.translation).astype(np.float32), 0.2)
    return CloudNode(0.0, cloud, pose, pose, 1.0)


def on_square(rng, first, second, corner_m=(0.0, 0.0, 0.0), count=4000):
    """Points (n, 3) on a square of SIDE_M along two unit vectors, with the noise of a lidar across it."""
    first, second = np.asarray(first, float), np.asarray(second, float)
    along = rng.uniform(0.0, SIDE_M, (count, 2))
    off_m = rng.normal(0.0, NOISE_M, (count, 1))
    return (
        np.asarray(corner_m) + along[:, :1] * first + along[:, 1:] * second + off_m * np.cross(first, second)
    )


def areas_of(plates):
    diagonals = plates.corners_m[:, 2:] - plates.corners_m[:, :2]
    return 0.5 * np.linalg.norm(np.cross(diagonals[:, 0], diagonals[:, 1]), axis=1)


def degrees_off(plates, normal):
    return np.degrees(
        np.arccos(np.clip(plates.normals @ (np.asarray(normal) / np.linalg.norm(normal)), -1, 1))
    )


@pytest.mark.table("normal", [(0.0, 0.0, 1.0), (0.3, 0.1, 1.0), (-1.0, 0.2, 0.6), (0.7, -0.7, 0.3)])
@pytest.mark.table("seed", [1, 2])
def test_a_wall_across_the_cells_gets_plates_on_it_that_fill_it_once(normal, seed):
    rng, normal = np.random.default_rng(seed), np.asarray(normal) / np.linalg.norm(normal)
    first = np.cross(normal, (0.0, 1.0, 0.1))
    first /= np.linalg.norm(first)
    points_m = on_square(rng, first, np.cross(normal, first))
    middle_m = points_m.mean(axis=0)
    plates = plates_of(points_of([node_at(middle_m + 3.0 * normal, points_m)]), rng)
    assert np.percentile(degrees_off(plates, normal), 95) < 4.0
    assert np.percentile(np.abs((plates.centres_m - middle_m) @ normal), 95) < 0.012
    across = np.cross(*np.diff(plates.corners_m[:, :3], axis=1).transpose(1, 0, 2))
    assert ((across * plates.normals).sum(axis=1) > 0.0).all()
    assert 0.95 < areas_of(plates).sum() / SIDE_M**2 < (1.1 if normal[2] == 1.0 else 1.6)  # they overlap


@pytest.mark.table("height_m", [0.0, 0.1, 0.19])
def test_a_floor_with_few_points_has_no_gaps_also_on_the_border_of_cells(height_m):
    rng = np.random.default_rng(9)
    side_m, cell_m = 4.0, PlateParameters().cell
    columns = np.stack(np.meshgrid(*[np.arange(0.0, side_m, cell_m)] * 2), axis=-1).reshape(-1, 2)
    columns = np.repeat(columns, rng.integers(2, 6, len(columns)), axis=0)  # two to five points in each
    along_m = columns + rng.uniform(0.0, cell_m, columns.shape)
    points_m = np.column_stack((along_m, height_m + rng.normal(0.0, NOISE_M, len(along_m))))
    plates = plates_of(points_of([node_at((2.0, 2.0, 3.0), points_m)]), rng)
    inside = np.arange(0.1, side_m, 0.02)
    places_m = np.stack(np.meshgrid(inside, inside), axis=-1).reshape(-1, 1, 2)
    low_m, high_m = plates.corners_m.min(axis=1)[:, :2], plates.corners_m.max(axis=1)[:, :2]
    over = [((part >= low_m) & (part <= high_m)).all(axis=2).sum(axis=1) for part in np.split(places_m, 39)]
    assert (np.concatenate(over) > 0).mean() > 0.97
    assert (np.concatenate(over) > 1).mean() < 0.05
    assert np.abs(plates.centres_m[:, 2] - height_m).max() < 0.03


def test_two_sides_of_a_thin_plate_stay_apart():
    rng = np.random.default_rng(3)
    thick_m = 0.05
    front = on_square(rng, (0, 1, 0), (0, 0, 1), (5.0, 0.0, 0.0))
    back = on_square(rng, (0, 0, 1), (0, 1, 0), (5.0 - thick_m, 0.0, 0.0))
    nodes = [node_at((8.0, 1.0, 1.0), front), node_at((2.0, 1.0, 1.0), back)]
    plates = plates_of(points_of(nodes), rng)
    for sign, place_m in ((1.0, 5.0), (-1.0, 5.0 - thick_m)):
        own = plates.only(degrees_off(plates, (sign, 0.0, 0.0)) < 5.0)
        assert areas_of(own).sum() == pytest.approx(SIDE_M**2, rel=0.08)
        assert np.abs(own.centres_m[:, 0] - place_m).max() < 0.01


def test_an_edge_between_two_plates_stays_sharp():
    rng = np.random.default_rng(4)
    points_m = np.concatenate((on_square(rng, (1, 0, 0), (0, 1, 0)), on_square(rng, (0, 1, 0), (0, 0, 1))))
    plates = plates_of(points_of([node_at((2.0, 1.0, 2.0), points_m)]), rng)
    off = np.minimum(degrees_off(plates, (0, 0, 1)), degrees_off(plates, (1, 0, 0)))
    assert areas_of(plates)[off < 6.0].sum() == pytest.approx(2.0 * SIDE_M**2, rel=0.08)
    assert areas_of(plates)[off >= 6.0].sum() < 0.05 * SIDE_M**2


def test_a_strip_that_is_too_narrow_for_a_plane_faces_the_sensor():
    rng = np.random.default_rng(5)
    strip = on_square(rng, (0, 0, 1), (1, 0, 0), count=30_000)
    strip = strip[strip[:, 0] < 0.04]
    plates = plates_of(points_of([node_at((0.02, -3.0, 1.0), strip)]), rng)
    assert 0.03 * SIDE_M < areas_of(plates).sum() < 0.12 * SIDE_M
    assert np.median(degrees_off(plates, (0.0, -1.0, 0.0))) < 25.0


def test_single_points_and_no_cloud_give_no_plate():
    rng = np.random.default_rng(6)
    assert len(plates_of(points_of([node_at((0.0, 0.0, 5.0), rng.uniform(-4.0, 4.0, (60, 3)))]), rng)) == 0
    assert len(plates_of(points_of([]), rng)) == 0


def test_the_points_around_a_cell_are_those_of_a_plain_search():
    rng = np.random.default_rng(7)
    points_m = rng.uniform(-1.0, 1.0, (3000, 3))
    cells = np.floor(points_m / 0.2).astype(np.int64)
    order = np.lexsort(cells.T[::-1])
    points_m, cells = points_m[order], cells[order]
    first = np.append(True, (cells[1:] != cells[:-1]).any(axis=1))
    begins = np.append(np.flatnonzero(first), len(cells))
    found = np.empty(3000, np.int64)
    for cell in cells[first][::37]:
        low, high = cell * 0.2 - 0.12, (cell + 1) * 0.2 + 0.12
        count = around(cells[first], begins, cell, low, high, points_m, found)
        inside = ((points_m >= low) & (points_m <= high)).all(axis=1)
        assert set(found[:count]) == set(np.flatnonzero(inside))


def test_a_plane_is_fitted_as_by_plain_principal_components():
    rng = np.random.default_rng(8)
    points_m = on_square(rng, (0.8, 0.6, 0.0), (0.0, 0.0, 1.0), (4.0, -3.0, 2.0), 500)
    weights, ways = rng.uniform(0.1, 1.0, 500), np.tile((0.6, -0.8, 0.0), (500, 1))
    normal, place = np.array((0.6, -0.8, 0.0)), np.array((4.0, -3.0, 2.0))
    taken = np.zeros(500, bool)
    taken[::5] = True
    refit(np.arange(500), taken, points_m, ways, weights, normal, place, 1.0, 0.02)
    kept = ~taken
    middle = np.average(points_m[kept], axis=0, weights=weights[kept])
    _, vectors = np.linalg.eigh(np.cov(points_m[kept].T, aweights=weights[kept]))
    assert place == pytest.approx(middle)
    assert abs(normal @ vectors[:, 0]) == pytest.approx(1.0, abs=1e-9)
    assert normal @ (0.6, -0.8, 0.0) > 0.9
