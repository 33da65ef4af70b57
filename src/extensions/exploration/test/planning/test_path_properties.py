"""What holds for every path, in rooms that hypothesis makes, beside slow references."""

import math

import numpy as np
import plain_paths
import pytest
from drawn_voxels import SIDE, planner_on, tiles_of, voxels_on
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy import ndimage

from exploration.planning import FREE, PathPlanner, PlannerParameters
from exploration.planning.clearance import ClearanceMap
from exploration.planning.kernels.search import UNREACHED, search
from exploration.planning.kernels.widest import narrowest_place
from exploration.planning.voxel_grid import VoxelGrid
from flight_basics.errors import NoPathError

SHAPE = (8, 12, 12)
NEED = 2
PARAMETERS = PlannerParameters(radius=math.sqrt(NEED), margin=0.0, comfort=2.0, preference=0.5)
REACH = 5
FACTORS = 1.0 + 0.5 * np.clip((math.sqrt(NEED) + 2.0 - np.sqrt(np.arange(REACH**2 + 1))) / 2.0, 0.0, 1.0)


@st.composite
def rooms(draw):
    """Kinds of voxels: free, with boxes that are unknown or occupied."""
    kinds = np.full(SHAPE, FREE, np.uint8)
    for _ in range(draw(st.integers(0, 5))):
        low = [draw(st.integers(0, size - 1)) for size in SHAPE]
        size = [draw(st.integers(1, 9)) for _ in SHAPE]
        kinds[tuple(slice(a, a + b) for a, b in zip(low, size))] = draw(st.sampled_from([0, 1, 2]))
    return kinds


places = st.tuples(*(st.floats(0.01, size - 0.01) for size in SHAPE[::-1]))


def voxel(place):
    return tuple(np.floor(place).astype(int)[::-1].tolist())


def squares_of(kinds):
    return plain_paths.squared_clearances(kinds != FREE, REACH)


@given(kinds=rooms(), start=places, goal=places)
def test_a_path_is_safe_and_exists_if_and_only_if_the_reference_finds_one(kinds, start, goal):
    squares = squares_of(kinds)
    begin, end = voxel(start), voxel(goal)
    cost = plain_paths.cheapest(squares, NEED, FACTORS, begin, end)
    is_possible = squares[begin] > 0 and squares[end] >= NEED and math.isfinite(cost)
    planner = planner_on(kinds, PARAMETERS)
    if not is_possible:
        with pytest.raises(NoPathError):
            planner.plan(start, goal)
        return
    plan = planner.plan(start, goal)
    assert np.allclose(plan.points_m[[0, -1]], (start, goal))
    assert math.dist(start, goal) - 1e-9 <= plan.length_m <= plan.searched_m + 1e-9
    passed = squares[tuple(voxels_on(plan.points_m).T)]
    assume(len(passed))  # a path may end where it begins, on a voxel's border
    first = np.argmax(passed >= NEED)
    assert (passed[first:] >= NEED).all()  # never nearer than the clearance
    assert (np.diff(passed[: first + 1]) >= 0).all()  # and out of it on the way that leads outward
    assert (passed > 0).all()


@given(kinds=rooms(), start=places, goal=places)
def test_the_search_costs_what_the_reference_costs(kinds, start, goal):
    squares = squares_of(kinds)
    begin, end = voxel(start), voxel(goal)
    assume(squares[begin] > 0)
    came = np.full(SHAPE, UNREACHED, np.int8)
    cost = search(squares.astype(np.uint16), NEED, FACTORS, np.array((begin, end)), came)
    expected = plain_paths.cheapest(squares, NEED, FACTORS, begin, end)
    assert cost == expected or abs(cost - expected) <= 1e-6 * expected


@given(
    kinds=rooms(),
    holes=st.lists(st.tuples(st.integers(0, 7), st.integers(0, 11), st.integers(1, 2)), max_size=3),
)
def test_the_narrowest_place_is_that_of_the_widest_way(kinds, holes):
    kinds[:, :, 6] = 2
    for z, y, size in holes:
        kinds[z : z + size, y : y + size, 6] = FREE
    begin, end = (3, 5, 2), (4, 6, 9)
    for z, y, x in (begin, end):
        kinds[z - 2 : z + 3, y - 2 : y + 3, x - 2 : x + 3] = FREE
    squares = squares_of(kinds)
    labels, _ = ndimage.label(squares >= NEED, np.ones((3, 3, 3)))
    assert labels[begin] != labels[end]  # each hole is too narrow
    came = np.full(SHAPE, UNREACHED, np.int8)
    assert math.isinf(search(squares.astype(np.uint16), NEED, FACTORS, np.array((begin, end)), came))
    assert ((came != UNREACHED) == (labels == labels[begin])).all()
    found = narrowest_place(squares.astype(np.uint16), came, np.array(end))
    expected = plain_paths.widest(squares, came != UNREACHED, end)
    assert (squares.ravel()[found] if found >= 0 else 0) == expected


@given(
    first=rooms(),
    second=rooms(),
    at=st.tuples(*[st.integers(-2, 2)] * 3),
    some=st.lists(st.integers(0, 17), min_size=1, unique=True),
)
def test_clearances_that_follow_changes_are_those_of_the_whole_map(first, second, at, some):
    grid = VoxelGrid(1.0, SIDE)
    clearances = ClearanceMap(grid, REACH)
    tiles, voxels = tiles_of(first)
    grid.update(tiles, voxels)
    clearances.note(tiles)
    clearances.squares()
    tiles, voxels = tiles_of(second, at=at)
    grid.update(tiles[some], voxels[some])
    clearances.note(tiles[some])
    assert (clearances.squares() == squares_of(grid.kinds)).all()


def test_a_large_map_has_the_same_clearances_across_blocks():
    kinds = (np.random.default_rng(1).random((70, 72, 140)) > 0.002).astype(np.uint8)
    grid = VoxelGrid(1.0, SIDE)
    clearances = ClearanceMap(grid, REACH)
    tiles, voxels = tiles_of(kinds)
    grid.update(tiles, voxels)
    clearances.note(tiles)
    assert (clearances.squares() == squares_of(grid.kinds)).all()


def test_the_reference_tells_a_planner_that_cuts_corners():
    """The properties above can fail: with no clearance, the same room has a path that they forbid."""
    kinds = np.full(SHAPE, FREE, np.uint8)
    kinds[:, :9, 6] = 2
    planner = PathPlanner(PlannerParameters(radius=0.05, margin=0.0, comfort=0.0))
    planner.update_map(1.0, SIDE, *tiles_of(np.pad(kinds, 4, constant_values=FREE)))
    plan = planner.plan((7.5, 6.5, 8.5), (13.5, 6.5, 8.5))
    assert plan.length_m > 6.0
