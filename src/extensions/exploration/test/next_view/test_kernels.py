"""Sight between voxels, frontiers and the lattice, each against a slow and obvious reference."""

import math
import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from exploration.next_view.frontiers import KnownBorder, frontier_voxels, in_cells
from exploration.next_view.kernels.best_view import best_view
from exploration.next_view.kernels.lattice import lattice_ways
from exploration.next_view.kernels.views import is_open, mark_seen, seen_from, sights_of
from exploration.next_view.parameters import ExplorerParameters
from exploration.next_view.views.kept_gains import KeptGains
from exploration.next_view.views.scene import Scene
from exploration.planning import FREE, UNKNOWN, PlannerParameters
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


@settings(max_examples=60, deadline=None)
@given(SEEDS)
def test_a_view_is_open_if_all_that_it_runs_through_before_its_end_is_free(seed):
    rng = np.random.default_rng(seed)
    kinds = drawn_kinds(rng)
    a, b = rng.integers(0, kinds.shape), rng.integers(0, kinds.shape)
    assert is_open(kinds, a, b) == all(
        kinds[voxel] == FREE for voxel in run_through(a, b) - {tuple(b.tolist())}
    )


@settings(max_examples=20, deadline=None)
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


@settings(max_examples=20, deadline=None)
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


@settings(max_examples=20, deadline=None)
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


def test_border_that_is_far_away_costs_hardly_anything():
    # Given a hall, and places and border only in its first part, or in 16 such parts
    rng = np.random.default_rng(1)
    kinds = np.full((20, 1600, 100), FREE, np.uint8)

    def took_s(parts):
        shape = (20, 100 * parts, 100)
        places, cells = (rng.integers(0, shape, (n * parts, 3)) for n in (800, 500))
        times_s = 2.0 + np.linalg.norm(places - (10, 50, 50), axis=1) / 7.5
        view = cells, np.full(len(cells), 20), (-0.27, 0.27), (2.5, 60.0)
        began_s = time.thread_time()
        best_view(kinds, places, times_s, *view, (20.0, 20.0), unknown(places))
        return time.thread_time() - began_s

    took_s(1)  # compiles
    # Then what is far away is not compared with each place: that would take 256 times as long
    assert min(took_s(16) for _ in range(3)) < 25.0 * min(took_s(1) for _ in range(3))


def test_of_a_great_many_places_few_are_looked_from_that_were_not_before():
    rng = np.random.default_rng(1)
    kinds = np.full((10, 300, 300), FREE, np.uint8)
    places, cells = (rng.integers(0, kinds.shape, (n, 3)) for n in (21_000, 2000))
    gains, view = unknown(places), (cells, np.full(len(cells), 20), (-0.3, 0.3), (1.0, 30.0))
    best, gain = best_view(kinds, places, np.full(len(places), 9.0), *view, (20.0, 0.1), gains)
    assert gain == gains.max() == gains[best]
    assert 16 < np.count_nonzero(gains >= 0) <= 16 + 250
    # Then the next decision knows these, and looks from others
    best_view(kinds, places, np.full(len(places), 9.0), *view, (20.0, 0.1), gains)
    assert np.count_nonzero(gains >= 0) <= 16 + 500


@settings(max_examples=20, deadline=None)
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


@settings(max_examples=30, deadline=None)
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


@settings(max_examples=25, deadline=None)
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
        np.testing.assert_array_equal(scene.border, frontier_voxels(np.pad(grid.kinds, 1)))
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


@settings(max_examples=20, deadline=None)
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
    starts, begun = rng.integers(0, len(nodes), 2), rng.uniform(0.0, 3.0, 2)
    from_each = dijkstra(csr_matrix(graph), indices=starts) + begun[:, None]
    expected = np.full(is_node.shape, np.inf)
    expected[is_node] = from_each.min(axis=0)
    found = lattice_ways(squares, 4, spacing, nodes[starts], begun)
    np.testing.assert_allclose(found, expected)
