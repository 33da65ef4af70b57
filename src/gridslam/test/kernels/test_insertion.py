"""Ray insertion and ownership of tiles, against plain tables of cells."""

from __future__ import annotations

import copy

import numpy as np
import plain_filter as reference
from hypothesis import given, settings
from hypothesis import strategies as st
from plain_maps import SIZE, WINDOW, plain_of

from gridslam.kernels.tiles import COUNT_MAX, EMPTY, SIDE
from gridslam.maps.tile_map import TileMaps

inside = st.floats(1.0, SIZE - 1.001)
points = st.tuples(inside, inside)


def window() -> TileMaps:
    """The map of one particle with WINDOW x WINDOW tiles."""
    maps = TileMaps(1, 0.05)
    maps.tables = np.zeros((1, WINDOW, WINDOW), np.int32)
    return maps


def enter(maps: TileMaps, lidar, ends, hits) -> None:
    maps.insert_at(np.zeros((1, 3)), np.vstack((lidar, ends)), hits)


@given(points, st.lists(st.tuples(points, st.booleans()), min_size=1, max_size=20))
def test_insertion_equals_the_reference(lidar, beams):
    lidar, ends = np.array(lidar), np.array([end for end, _ in beams])
    hits = np.array([hit for _, hit in beams])
    maps, plain = window(), reference.PlainMap.empty(SIZE, SIZE)
    for _ in range(2):
        enter(maps, lidar, ends, hits)
        reference.insert(plain, lidar, ends, hits)
    seen = plain_of(maps, 0)
    np.testing.assert_array_equal(seen.hits, plain.hits)
    np.testing.assert_array_equal(seen.visits, plain.visits)
    np.testing.assert_allclose(seen.means, plain.means, atol=1e-4)


@given(points, st.lists(st.tuples(points, st.booleans()), min_size=1, max_size=10))
def test_only_tiles_that_are_written_are_taken(lidar, beams):
    lidar, ends = np.array(lidar), np.array([end for end, _ in beams])
    maps = window()
    enter(maps, lidar, ends, np.array([hit for _, hit in beams]))
    taken = maps.tables[maps.tables != EMPTY]
    assert len(taken) == maps.pool.used
    assert maps.pool.tiles.visits[taken].any(axis=1).all()
    assert not maps.pool.tiles.visits[EMPTY].any()


def test_occupied_bits_follow_the_counts():
    # given a wall that one beam has hit
    maps = window()
    lidar, wall, beyond = np.array([4.5, 4.5]), np.array([[9.5, 4.5]]), np.array([[15.5, 4.5]])
    enter(maps, lidar, wall, np.array([True]))
    assert plain_of(maps, 0).occupied[4, 9]
    # when nine more beams pass, it is hit by a tenth of its beams, and that is not more than FULLNESS
    for passed in range(1, 10):
        enter(maps, lidar, beyond, np.array([False]))
        bits = maps.pool.tiles.occupied[maps.tables[0, 0, 0], 4]
        assert bool(bits >> 9 & 1) == (1 / (1 + passed) > reference.FULLNESS)
    # then it is free, until something hits it again
    enter(maps, lidar, wall, np.array([True]))
    assert maps.pool.tiles.occupied[maps.tables[0, 0, 0], 4] >> 9 & 1


def test_counts_are_halved_before_they_overflow():
    maps = window()
    enter(maps, np.array([4.5, 4.5]), np.array([[9.5, 4.5]]), np.array([True]))
    tile, cell = maps.tables[0, 0, 0], 4 * SIDE + 9
    tiles = maps.pool.tiles
    # given a cell that COUNT_MAX beams have met, of which a hundred hit it
    tiles.visits[tile, cell], tiles.hits[tiles.ends[tile], cell] = COUNT_MAX, 100
    # when one more ends there, or two more cross it
    for end, hits, expected in ((9.5, [True], 51), (15.5, [False, False], 50)):
        again = copy.deepcopy(maps)
        enter(again, np.array([4.5, 4.5]), np.array([[end, 4.5]] * len(hits)), np.array(hits))
        # then half of both are left
        seen = plain_of(again, 0)
        assert (seen.hits[4, 9], seen.visits[4, 9]) == (expected, (COUNT_MAX + len(hits)) // 2)


@settings(max_examples=20)
@given(
    points,
    st.integers(200, 1500),
    st.floats(0.01, 2.0 * np.pi),
    st.floats(-np.pi, np.pi),
    st.integers(0, 2**32 - 1),
)
def test_beams_that_are_too_many_for_a_count(lidar, number, field_of_view, middle, seed):
    # given beams of which most may meet the same cells
    rng = np.random.default_rng(seed)
    bearings = middle + field_of_view * rng.uniform(-0.5, 0.5, number)
    ends = np.clip(lidar + 20.0 * np.stack((np.cos(bearings), np.sin(bearings)), axis=1), 1.0, SIZE - 1.001)
    # when they are entered as misses
    maps, plain = window(), reference.PlainMap.empty(SIZE, SIZE)
    enter(maps, np.array(lidar), ends, np.zeros(number, bool))
    reference.insert(plain, lidar, ends, np.zeros(number, bool))
    # then cells have the reference's counts, or halves of them that a cell can hold
    visits, fits = plain_of(maps, 0).visits, plain.visits <= COUNT_MAX
    np.testing.assert_array_equal(visits[fits], plain.visits[fits])
    assert (visits[~fits] > COUNT_MAX // 2 - 1).all()
