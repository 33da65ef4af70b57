"""Sight between voxels, frontiers and the lattice, each against a slow and obvious reference."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from exploration.next_view.frontiers import KnownBorder, frontier_voxels, in_cells
from exploration.next_view.kernels.best_view import best_view
from exploration.next_view.kernels.lattice import lattice_ways, most_room
from exploration.next_view.kernels.views import is_open, mark_seen, seen_from, sights_of
from exploration.next_view.parameters import ExplorerParameters
from exploration.next_view.roadmap import Roadmap
from exploration.next_view.views.kept_gains import KeptGains
from exploration.next_view.views.scene import Scene
from exploration.planning import FREE, UNKNOWN, PlannerParameters
from exploration.planning.closures import Closure
from exploration.planning.kernels.neighbours import STEPS
from exploration.planning.space import Space
from exploration.planning.voxel_grid import VoxelGrid
from flight_limits import Limits

SEEDS = st.integers(0, 2**32 - 1)


def drawn_kinds(rng, free=0.9, shape=(6, 7, 8)):
    return np.where(rng.random(shape) < free, FREE, rng.integers(0, 3, shape)).astype(np.uint8)


def unknown(places):
    """What none of the places is known to show."""
    return np.full(len(places), -1)


def run_through(a, b):
    """The voxels that a line between two voxels' centres runs through."""
    points = np.asarray(a) + 0.5 + np.linspace(0.0, 1.0, 4001)[:, None] * (np.asarray(b) - a)
    inside = np.abs(points - np.round(points)).min(axis=1) > 1e-3
    return {tuple(voxel) for voxel in np.floor(points[inside]).astype(int).tolist()}


@given(SEEDS)
def test_a_view_is_open_if_all_that_it_runs_through_before_its_end_is_free(seed):
    rng = np.random.default_rng(seed)
    kinds = drawn_kinds(rng)
    a, b = rng.integers(0, kinds.shape), rng.integers(0, kinds.shape)
    assert is_open(kinds, a, b) == all(
        kinds[voxel] == FREE for voxel in run_through(a, b) - {tuple(b.tolist())}
    )


@settings(max_examples=20)
@given(SEEDS)
def test_a_place_shows_the_cells_within_reach_and_beams(seed):
    rng = np.random.default_rng(seed)
    kinds = drawn_kinds(rng)
    places, cells = (rng.integers(0, kinds.shape, (n, 3)) for n in (4, 9))
    counts, is_seen = rng.integers(1, 50, 9), np.zeros(9, bool)
    gains = seen_from(kinds, places, cells, counts, (-0.3, 0.2), (1.0, 6.0), is_seen)
    expected, seen = np.zeros(4, int), np.zeros(9, bool)
    for n, place in enumerate(places):
        for m, cell in enumerate(cells):
            dz, level = cell[0] - place[0], math.hypot(*(cell - place)[1:])
            in_beams = -0.3 * level - 0.5 <= dz <= 0.2 * level + 0.5
            if in_beams and 1.0 <= math.dist(place, cell) <= 6.0 and is_open(kinds, place, cell):
                expected[n] += counts[m]
                seen[m] = True
    np.testing.assert_array_equal(gains, expected)
    np.testing.assert_array_equal(is_seen, seen)
    marked = np.zeros(9, bool)
    mark_seen(kinds, places, cells, (-0.3, 0.2), (1.0, 6.0), marked)
    np.testing.assert_array_equal(marked, seen)
    sights = sights_of(kinds, places, cells, (-0.3, 0.2), (1.0, 6.0))
    np.testing.assert_array_equal(sights.any(axis=0), seen)
    np.testing.assert_array_equal(sights @ counts, expected)


@settings(max_examples=20)
@given(SEEDS)
def test_the_best_view_shows_most_for_its_time(seed):
    rng = np.random.default_rng(seed)
    kinds, times_s = drawn_kinds(rng), rng.uniform(1.0, 9.0, 12)
    places, cells = (rng.integers(0, kinds.shape, (n, 3)) for n in (12, 9))
    view = cells, rng.integers(1, 50, 9), (-0.9, 0.8), (1.0, 6.0)
    rates = seen_from(kinds, places, *view, np.zeros(9, bool)) / times_s
    best, gain = best_view(kinds, places, times_s, *view, (1.0, 0.0), unknown(places))
    if rates.max() == 0.0:
        assert (best, gain) == (-1, 0)
    else:
        assert gain / times_s[best] == rates.max() == rates[best]
    assert best_view(kinds, places, times_s, *view, (1.0, rates.max()), unknown(places)) == (-1, 0)


@settings(max_examples=20)
@given(SEEDS)
def test_the_best_view_of_a_place_much_larger_than_the_reach(seed):
    rng = np.random.default_rng(seed)
    kinds, times_s = drawn_kinds(rng, 0.97, (12, 60, 70)), rng.uniform(1.0, 90.0, 80)
    places, cells = (rng.integers(0, kinds.shape, (n, 3)) for n in (80, 150))
    low, high = np.sort(rng.uniform(-1.0, 1.0, 2))
    view = cells, rng.integers(1, 50, 150), (low, high), (1.0, rng.uniform(2.0, 20.0))
    rates = seen_from(kinds, places, *view, np.zeros(150, bool)) / times_s
    best, gain = best_view(kinds, places, times_s, *view, (1.0, 0.0), unknown(places))
    assert (best, gain) == (-1, 0) if rates.max() == 0.0 else gain / times_s[best] == rates.max()


@settings(max_examples=20)
@given(SEEDS)
def test_frontiers_are_unknown_voxels_beside_free_ones(seed):
    kinds = drawn_kinds(np.random.default_rng(seed), free=0.5)
    expected = set()
    for voxel in np.argwhere(kinds == UNKNOWN).tolist():
        for axis in range(3):
            for step in (-1, 1):
                other = list(voxel)
                other[axis] += step
                inside = 0 <= other[axis] < kinds.shape[axis]
                if inside and kinds[tuple(other)] == FREE:
                    expected.add(tuple(voxel))
    assert {tuple(voxel) for voxel in frontier_voxels(kinds).tolist()} == expected


def test_cells_count_their_voxels_and_stay_when_the_map_grows():
    voxels = np.array([(0, 0, 0), (0, 0, 1), (0, 0, 2), (5, 5, 5)])
    cells = in_cells(voxels, 3, np.zeros(3, int))
    assert sorted(cells.counts.tolist()) == [1, 3]
    assert cells.places[np.argmax(cells.counts)].tolist() == [0, 0, 1]
    grown = in_cells(voxels + 7, 3, np.full(3, -7))
    np.testing.assert_array_equal(grown.places, cells.places + 7)


@given(SEEDS, st.integers(1, 4))
def test_a_cells_place_is_its_voxel_nearest_to_their_mean(seed, side):
    rng = np.random.default_rng(seed)
    voxels = np.unique(rng.integers(0, 9, (40, 3)), axis=0)
    corner = rng.integers(-5, 5, 3)
    cells, keys = in_cells(voxels, side, corner), (voxels + corner) // side
    assert cells.counts.sum() == len(voxels)
    assert len(cells.counts) == len(np.unique(keys, axis=0))
    for place, count in zip(cells.places, cells.counts):
        own = voxels[(keys == (place + corner) // side).all(axis=1)]
        off = np.square(own - own.mean(axis=0)).sum(axis=1)
        assert (len(own), off.min()) == (count, pytest.approx(np.square(place - own.mean(axis=0)).sum()))


@given(SEEDS)
def test_a_border_and_gains_that_follow_a_growing_map_are_those_of_the_whole_map(seed):
    """Given tiles that come, come again, change and widen the map, when views are chosen each time..."""
    rng, side, p = np.random.default_rng(seed), 4, ExplorerParameters(reach=3.0, near=0.0, cell=0.6)
    grid, known, kept = VoxelGrid(0.2, side), KnownBorder(), KeptGains(p.cell)
    for _ in range(6):
        tiles = np.unique(rng.integers(-3, 4, (rng.integers(1, 12), 3)), axis=0)
        kinds = drawn_kinds(rng, 0.95, (len(tiles), side**3))
        before, known_before = grid.versions.sum(), grid.known
        has_changed = grid.update(tiles, kinds)
        assert grid.versions.sum() - before == has_changed.sum()
        assert not grid.update(tiles, kinds).any()
        assert grid.known == np.count_nonzero(grid.kinds) >= known_before - kinds.size
        space = Space.of(grid, np.zeros(grid.kinds.shape, np.uint16), PlannerParameters(), Limits(), (), 0.0)
        scene = Scene.of(space, p, known)
        np.testing.assert_array_equal(scene.kinds, np.pad(grid.kinds, 1))
        np.testing.assert_array_equal(scene.border, frontier_voxels(scene.kinds))
        cells = scene.cells(p.cell)
        cells = cells.chosen(rng.random(len(cells.counts)) < 0.9)
        places = np.argwhere(grid.kinds == FREE)[::7]
        gains = kept.of(scene, places, cells)
        expected = scene.gains(places, cells)[0]
        is_kept = gains >= 0
        np.testing.assert_array_equal(gains[is_kept], expected[is_kept])
        kept.keep(np.where(rng.random(len(places)) < 0.7, expected, -1))
        again = kept.of(scene, places, cells)
        np.testing.assert_array_equal(again[again >= 0], expected[again >= 0])
        kept.keep(again)


@settings(max_examples=20)
@given(SEEDS, st.integers(1, 3))
def test_ways_are_shortest_over_edges_whose_voxels_all_keep_the_clearance(seed, spacing):
    rng = np.random.default_rng(seed)
    squares = rng.choice([1, 4, 9], (7, 6, 8), p=[0.15, 0.45, 0.4]).astype(np.uint16)
    is_node = squares[::spacing, ::spacing, ::spacing] >= 4
    nodes = np.argwhere(is_node)
    graph = np.zeros((len(nodes), len(nodes)))
    for head, node in enumerate(nodes):
        for step in STEPS:
            tail = np.flatnonzero((nodes == node + step).all(axis=1))
            between = [tuple(node * spacing + k * step) for k in range(1, spacing)]
            if len(tail) and all(squares[voxel] >= 4 for voxel in between):
                graph[head, tail[0]] = spacing * math.sqrt(float((step**2).sum()))
    starts, begun = rng.integers(0, len(nodes), 2), rng.uniform(0.0, 30.0, 2)
    from_each = dijkstra(csr_matrix(graph), indices=starts) + begun[:, None]
    expected = np.full(is_node.shape, np.inf)
    expected[is_node] = from_each.min(axis=0)
    found = lattice_ways(squares, 4, False, spacing, nodes[starts], begun)
    np.testing.assert_allclose(found, expected)


@settings(max_examples=20)
@given(SEEDS, st.integers(1, 4), st.integers(2, 12), st.integers(2, 30))
def test_clearances_at_both_ends_tell_the_same_ways(seed, spacing, need, cut):
    """Given clearances, cut at a distance as the planner's, whatever the voxels between would tell."""
    rng = np.random.default_rng(seed)
    is_blocked = rng.random((14, 16, 18)) < rng.uniform(0.001, 0.03)
    squares = np.minimum(clearances(is_blocked), cut)
    begin = (squares.shape - np.ones(3, int)) // spacing // 2
    ways = [lattice_ways(squares, need, even, spacing, begin[None], np.zeros(1)) for even in (False, True)]
    np.testing.assert_array_equal(*ways)


def clearances(is_blocked):
    """Squared distance from each voxel to the nearest blocked one."""
    return np.rint(ndimage.distance_transform_edt(~is_blocked) ** 2).astype(np.uint16)


@settings(max_examples=20)
@given(SEEDS, st.integers(1, 5))
def test_one_place_of_each_cube_has_most_room(seed, side):
    rng = np.random.default_rng(seed)
    places = np.unique(rng.integers(0, 9, (60, 3)), axis=0)
    room = rng.integers(1, 5, len(places))
    order = np.lexsort((-room, *(places // side).T[::-1]))
    _, first = np.unique(places[order] // side, axis=0, return_index=True)
    np.testing.assert_array_equal(most_room(places, room, side), order[first])
    assert not len(most_room(places[:0], room[:0], side))


def test_a_closed_ball_between_two_nodes_cuts_the_edge():
    """Given the whole clearance at both ends of an edge, and a ball that is closed between them."""
    grid = VoxelGrid(0.1, 16)
    tiles = np.argwhere(np.ones((3, 3, 3), bool))
    grid.update(tiles, np.full((27, 16**3), FREE, np.uint8))
    squares = np.minimum(clearances(np.pad(np.zeros((46, 46, 46), bool), 1, constant_values=True)), 121)
    closed = (Closure((2.75, 2.45, 2.45), 0.25, 9.0),)
    parameters = PlannerParameters(radius=0.3, margin=0.2)
    for closures, is_even in (((), True), (closed, False)):
        space = Space.of(grid, squares.astype(np.uint16), parameters, Limits(), closures, 0.0)
        assert space.is_even is is_even
        roadmap = Roadmap(space, np.full(3, 2.45), 6)
        at = {tuple(node): way for node, way in zip(roadmap.nodes.tolist(), roadmap.ways_m)}
        straight_m = np.linalg.norm(np.array((24.5, 24.5, 30.5)) * 0.1 - 2.45)
        assert (at[24, 24, 30] < straight_m + 1e-6) == is_even
