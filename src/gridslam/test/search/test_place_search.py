"""Places are found wherever they are, as an exhaustive search finds them, with rivals and covariance."""

import math

import numpy as np
import pytest
from planar_world import Lidar, scan_at
from rooms import WALLS
from scipy.ndimage import distance_transform_edt

from gridslam import OccupancyGrid, se2
from gridslam.evaluation import Walls
from gridslam.kernels.places import squared_distances
from gridslam.search import LikelihoodField, PlaceSearch, SearchSettings, Window
from gridslam.search.field import FULL, UNSEEN

LIDAR = Lidar(2.0 * math.pi, 180, 10.0, 0.01, 10.0)


def grid_of(walls: Walls, seen: float = 6.0, resolution_m: float = 0.05) -> OccupancyGrid:
    """A map of walls within `seen` metres of the origin, free everywhere else."""
    side = int(2 * seen / resolution_m)
    cells = np.zeros((side, side), np.int8)
    for x0, y0, x1, y1 in walls.ends_m:
        count = int(math.hypot(x1 - x0, y1 - y0) / resolution_m * 4) + 2
        along = np.linspace(0.0, 1.0, count)[:, None]
        points = np.array([x0, y0]) + along * np.array([x1 - x0, y1 - y0])
        column, row = np.floor((points + seen) / resolution_m).astype(int).T
        inside = (column >= 0) & (column < side) & (row >= 0) & (row < side)
        cells[row[inside], column[inside]] = 100
    return OccupancyGrid(cells, resolution_m, (-seen, -seen))


def points_at(walls: Walls, pose, seed: int = 0) -> np.ndarray:
    """The ends of beams, in the base frame, seen from a pose."""
    scan = scan_at(walls, np.array(pose), LIDAR, np.random.default_rng(seed))
    seen = np.isfinite(scan.ranges_m)
    bearings = scan.angles_rad[seen]
    return scan.ranges_m[seen, None] * np.column_stack([np.cos(bearings), np.sin(bearings)])


def fit(field: LikelihoodField, points: np.ndarray, column: int, row: int, angle: float) -> float:
    """The mean fit of points from the middle of a cell, one by one."""
    total = 0.0
    for x, y in points:
        right = math.floor((math.cos(angle) * x - math.sin(angle) * y) / field.resolution_m + 0.5) + column
        up = math.floor((math.sin(angle) * x + math.cos(angle) * y) / field.resolution_m + 0.5) + row
        inside = 0 <= right < field.table.shape[1] and 0 <= up < field.table.shape[0]
        total += field.table[up, right] if inside else UNSEEN
    return total / FULL / len(points)


@pytest.mark.table(("seed", "score_min"), [(0, 0.0), (1, 0.0), (2, 0.0), (2, 0.4)])
def test_best_score_is_that_of_an_exhaustive_search(seed, score_min):
    # given a small map of noise, on which bounds help little
    rng = np.random.default_rng(seed)
    field = LikelihoodField.from_masks(
        rng.random((24, 31)) < 0.05, rng.random((24, 31)) < 0.3, np.array([2.0, -1.0]), 0.1, 0.1
    )
    points = 0.1 + 0.4 * np.array([(-2, 1), (-1, -1), (0, 2), (1, 0), (1, 1), (0, -2)])
    window = Window(np.array([3.4, 0.2, 0.3]), 0.7, 0.2)
    found = PlaceSearch(field).find(points, SearchSettings(score_min=score_min, places_max=1), window)
    # then no pose of the window fits better; headings as close as the search's own
    angles = 0.3 + np.linspace(-0.2, 0.2, 2 * math.ceil(0.2 * 1.0 / 0.2) + 1)
    scores = [
        fit(field, points, column, row, angle)
        for angle in angles
        for column in range(14 - 7, 14 + 7 + 1)
        for row in range(12 - 7, 12 + 7 + 1)
    ]
    assert found[0].score == pytest.approx(max(scores), abs=1e-9)


@pytest.mark.table("pose", [(2.0, -1.5, 0.4), (-3.0, 1.0, 3.0), (3.3, 0.4, -2.0)])
def test_a_pose_is_found_without_any_prior(pose):
    search = PlaceSearch(LikelihoodField.from_grid(grid_of(WALLS)))
    found = search.find(points_at(WALLS, pose), SearchSettings())
    error = se2.between(np.array(pose), found[0].pose)
    assert math.hypot(error[0], error[1]) < 0.06
    assert abs(error[2]) < 0.03
    assert found[0].score > 0.8
    again = search.find(points_at(WALLS, pose), SearchSettings())
    assert [place.pose.tolist() for place in again] == [place.pose.tolist() for place in found]


def test_equal_rooms_are_rivals():
    # given two equal rooms side by side, and a third that is longer
    def room(x, length):
        return np.array([(x, -1.5), (x + length, -1.5), (x + length, 1.0), (x + 1.2, 1.0), (x, 0.6)])

    walls = Walls.from_polygons([room(-5.5, 3.0), room(-1.5, 3.0), room(2.2, 3.6)])
    search = PlaceSearch(LikelihoodField.from_grid(grid_of(walls)))
    found = search.find(points_at(walls, (0.2, -0.4, 1.0)), SearchSettings())
    # then the first two are the equal ones, 4 m apart and nearly as good as each other
    assert abs(found[0].pose[0] - found[1].pose[0]) == pytest.approx(4.0, abs=0.1)
    assert found[1].score > 0.95 * found[0].score
    # and in the longer room there is one best place
    assert search.find(points_at(walls, (4.5, -0.4, 1.0)), SearchSettings())[0].pose[0] == pytest.approx(
        4.5, abs=0.1
    )


def test_covariance_is_open_along_a_bare_wall_and_closed_across_it():
    # given one straight wall along x, and points on it: only y and yaw are measured
    walls = Walls.from_polygons([np.array([(-20.0, 2.025), (20.0, 2.025)])])
    field = LikelihoodField.from_grid(grid_of(walls), pooled=1)
    points = np.column_stack([np.linspace(-2.0, 2.0, 20), np.full(20, 2.025)])
    window = Window(np.zeros(3), 0.3, 0.1)
    place = PlaceSearch(field).find(points, SearchSettings(point_sigma_m=0.03), window)[0]
    deviation = np.sqrt(np.diag(place.covariance))
    # sigma / sqrt(n), and for the heading sigma / sqrt(sum of x^2)
    assert deviation[1] == pytest.approx(0.03 / math.sqrt(20), rel=0.5)
    assert deviation[2] == pytest.approx(0.03 / math.sqrt((points[:, 0] ** 2).sum()), rel=0.5)
    assert deviation[0] > 0.05


def test_what_is_not_there_is_not_found():
    search = PlaceSearch(LikelihoodField.from_grid(grid_of(WALLS)))
    assert search.find(np.zeros((0, 2)), SearchSettings()) == []
    circle = 0.7 * np.column_stack([np.cos(np.arange(90) / 14.0), np.sin(np.arange(90) / 14.0)])
    assert search.find(circle, SearchSettings(score_min=0.8)) == []


def test_distances_are_those_of_a_plain_transform_as_far_as_they_reach():
    for share in (0.3, 0.01, 0.001):
        occupied = np.random.default_rng(0).random((70, 90)) < share
        found, plain = squared_distances(occupied, 9, 1), distance_transform_edt(~occupied) ** 2
        near = plain <= 81.0
        np.testing.assert_allclose(found[near], plain[near])
        assert (found[~near] > 81).all()


@pytest.mark.table("pooled", [1, 2, 3])
def test_a_field_is_that_of_the_mean_squared_distance_in_each_block(pooled):
    # given a map with empty rows and columns beside what is occupied, and parts that nobody has seen
    rng = np.random.default_rng(1)
    occupied = np.pad(rng.random((25, 31)) < 0.02, ((30, 4), (1, 40)))
    unseen = np.kron(rng.random((10, 12)) < 0.5, np.ones((6, 6)))[:59, :72] > 0
    # when its field is made
    field = LikelihoodField.from_masks(occupied, unseen, np.zeros(2), 0.05, 0.1, pooled)
    # then it is that of a plain distance transform, and unseen cells around the map fill its last blocks
    pad = [(0, -side % pooled) for side in occupied.shape]
    squared = distance_transform_edt(~np.pad(occupied, pad)) ** 2
    unseen = np.pad(unseen, pad, constant_values=True)
    blocks = (squared.shape[0] // pooled, pooled, squared.shape[1] // pooled, pooled)
    mean_m2 = 0.05**2 * squared.reshape(blocks).mean(axis=(1, 3))
    fits = FULL * np.exp(-0.5 * mean_m2 / 0.1**2)
    floor = np.where(unseen.reshape(blocks).all(axis=(1, 3)), UNSEEN, 0)
    np.testing.assert_array_equal(field.table, np.rint(np.maximum(fits, floor)))
