"""Tiles shared by particles: whatever is written and resampled, their maps are those of plain copies."""

from __future__ import annotations

import os
import resource
from pathlib import Path

import numpy as np
import plain_filter as reference
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from plain_maps import beams_from, plain_of

from gridslam.errors import MapError
from gridslam.kernels.tiles import COUNT_MAX, EMPTY, ENDS, SIDE, TILES
from gridslam.maps import free_space
from gridslam.maps.free_space import FreeSpace
from gridslam.maps.tile_map import TileMaps
from gridslam.maps.tile_pool import TilePool

PARTICLES, DELTA = 4, 0.05
HALF = 4 * SIDE
"""Half the side of the plain copies, in cells about the map's origin."""

pose = st.tuples(st.floats(-2.0, 2.0), st.floats(-2.0, 2.0), st.floats(-3.1, 3.1))
write = st.tuples(
    st.just("write"), st.lists(pose, min_size=PARTICLES, max_size=PARTICLES), st.integers(0, 99)
)
resampling = st.tuples(
    st.just("resample"), st.lists(st.integers(0, PARTICLES - 1), min_size=PARTICLES, max_size=PARTICLES)
)


class PlainCopies:
    """Maps without tiles, each a whole copy of its own."""

    def __init__(self):
        self.maps = [reference.PlainMap.empty(2 * HALF, 2 * HALF) for _ in range(PARTICLES)]

    def insert(self, poses, beams):
        for plain, (x, y, yaw) in zip(self.maps, poses):
            corner = np.array((x, y)) / DELTA + HALF
            lidar, *ends = reference.turned(yaw, np.vstack((beams.lidar, beams.ends))) + corner
            reference.insert(plain, lidar, ends, beams.hits)

    def resample(self, parents):
        self.maps = [self.maps[parent].copy() for parent in parents]


def check_pool(maps: TileMaps) -> None:
    """Every tile is either free or referenced, exactly as often as the tables say; ends likewise by tiles."""
    pool, tiles = maps.pool, maps.pool.tiles
    references = np.bincount(maps.tables.ravel(), minlength=pool.capacity)
    references[EMPTY] = 0
    of_ends = np.bincount(tiles.ends[references > 0], minlength=tiles.end_references.size)
    of_ends[EMPTY] = 0
    for kept, expected, stack, left in (
        (tiles.references, references, tiles.free_tiles, tiles.free[TILES]),
        (tiles.end_references, of_ends, tiles.free_ends, tiles.free[ENDS]),
    ):
        np.testing.assert_array_equal(kept, expected)
        assert sorted(stack[:left]) == np.flatnonzero(expected == 0)[1:].tolist()
    assert not tiles.visits[EMPTY].any()
    assert not tiles.hits[EMPTY].any()


def check_maps(maps: TileMaps, copies: PlainCopies) -> None:
    low = HALF + maps.corner[::-1] * SIDE
    high = low + np.array(maps.tables.shape[1:]) * SIDE
    ours, theirs = np.maximum(-low, 0), np.maximum(low, 0)
    size = np.minimum(high, 2 * HALF) - theirs
    for particle, plain in enumerate(copies.maps):
        seen = plain_of(maps, particle)
        for name in ("hits", "visits"):
            window = getattr(seen, name)[ours[0] : ours[0] + size[0], ours[1] : ours[1] + size[1]]
            whole = getattr(plain, name)
            expected = whole[theirs[0] : theirs[0] + size[0], theirs[1] : theirs[1] + size[1]]
            np.testing.assert_array_equal(window, expected)
            assert getattr(seen, name).sum() == whole.sum()


@given(st.lists(st.one_of(write, resampling), min_size=1, max_size=8))
def test_shared_tiles_equal_plain_copies(actions):
    maps, copies = TileMaps(PARTICLES, DELTA), PlainCopies()
    maps.pool = TilePool(3)  # so that it must grow on the way
    for kind, *given_values in actions:
        if kind == "write":
            poses, seed = np.array(given_values[0]), given_values[1]
            beams = beams_from(np.random.default_rng(seed), 6)
            maps.insert(poses, beams)
            copies.insert(poses, beams)
        else:
            maps.resample(np.array(given_values[0]))
            copies.resample(given_values[0])
        check_pool(maps)
    check_maps(maps, copies)


draw = st.tuples(st.just("draw"), st.integers(0, PARTICLES - 1))
look = st.tuples(st.just("look"), st.integers(0, PARTICLES - 1), st.integers(0, 99))


@given(st.lists(st.one_of(write, resampling, draw, look), min_size=1, max_size=16), st.integers(1, 4))
def test_maps_whose_free_space_waits_equal_plain_copies(actions, scans):
    maps, copies = TileMaps(PARTICLES, DELTA), PlainCopies()
    maps.pool = TilePool(3)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(free_space, "SCANS", scans)
        maps._free_space = FreeSpace(PARTICLES)
        for kind, *given_values in actions:
            if kind == "write":
                poses, beams = (
                    np.array(given_values[0]),
                    beams_from(np.random.default_rng(given_values[1]), 6),
                )
                maps.insert(poses, beams)
                copies.insert(poses, beams)
            elif kind == "resample":
                maps.resample(np.array(given_values[0]))
                copies.resample(given_values[0])
            elif kind == "draw":
                maps.settle(given_values[0])
            else:
                particle, cells = given_values[0], np.random.default_rng(given_values[1])
                cells = cells.integers(-2 * SIDE, 2 * SIDE, (9, 2))
                seen = maps.are_seen(particle, cells - maps.corner * SIDE + 0.5)
                expected = copies.maps[particle].visits[cells[:, 1] + HALF, cells[:, 0] + HALF] > 0
                np.testing.assert_array_equal(seen, expected)
            check_pool(maps)
        check_maps(maps, copies)


@settings(max_examples=10)
@given(st.integers(300, 700), st.integers(0, 2**32 - 1))
def test_free_space_that_waits_is_halved_as_if_it_had_not_waited(count, seed):
    """Counts that overflow are halved, and beams that are many are counted in lots: the order matters."""
    rng = np.random.default_rng(seed)
    beams = beams_from(rng, count)
    scans = [rng.normal(0.0, (0.1, 0.1, 0.5), (PARTICLES, 3)) for _ in range(12)]
    at_once, later = TileMaps(PARTICLES, DELTA), TileMaps(PARTICLES, DELTA)
    for maps in (at_once, later):
        maps._free_space = FreeSpace(PARTICLES) if maps is later else None
        for number, poses in enumerate(scans):
            maps.insert(poses, beams)
            maps._is_mostly_free = lambda: False
            if number % 4 == 3:
                maps.resample(np.array([0, 0, 1, 3]))
            if number == 6:
                later.settle(1)
        assert max(plain_of(maps, particle).visits.max() for particle in range(PARTICLES)) > COUNT_MAX // 2
    for particle in range(PARTICLES):
        one, other = plain_of(at_once, particle), plain_of(later, particle)
        for name in ("visits", "hits", "means"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


def test_resampling_copies_no_tile_and_writing_only_those_it_changes():
    # given two particles that have mapped 20 m apart
    maps, beams = TileMaps(2, DELTA), beams_from(np.random.default_rng(1), 30, reach=10.0)
    maps.insert(np.array([(0.0, 0.0, 0.0), (20.0, 0.0, 0.0)]), beams)
    before = maps.pool.used
    # when the second takes over the first one's map
    maps.resample(np.array([0, 0]))
    shared = np.unique(maps.tables)
    # then all tiles are shared and those of the other are free again
    assert maps.pool.used == len(shared) - 1 < before
    assert (maps.tables[0] == maps.tables[1]).all()
    # and when both write on, far away from what they share, that stays shared
    maps.insert(np.array([(0.0, 20.0, 0.0), (0.0, 20.0, 0.1)]), beams)
    assert set(shared) <= set(maps.tables[0].ravel()) & set(maps.tables[1].ravel())


def resident_mb() -> float:
    return int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize() / 2**20


def test_tiles_take_memory_once_they_are_written_and_give_it_back():
    """A tile of 32 x 32 cells has two counts of a byte, and the mean of its hits in twice two bytes."""
    before = resident_mb()
    for _ in range(3):  # The C library's memory is cleared, and so taken, from the second time on
        pool = TilePool(5000)
        assert resident_mb() - before < 5.0
        pool.tiles.means[:] = 1
        assert resident_mb() - before > 0.9 * 5000 * SIDE**2 * 4 / 2**20
        pool.reserve(20_000)  # whoever grows takes no memory, either, and is not copied
        assert resident_mb() - before < 1.2 * 5000 * SIDE**2 * 4 / 2**20
        assert pool.tiles.means[:5000].all()
        assert not pool.tiles.means[5000:].any()
        del pool
    assert resident_mb() - before < 5.0


def test_a_forked_process_does_not_write_into_the_tiles_of_its_parent():
    tiles = TilePool(64).tiles
    child = os.fork()
    if child == 0:
        for array in (tiles.visits, tiles.occupied, tiles.hits, tiles.means):
            array[:] = 1
        os._exit(0)
    os.waitpid(child, 0)
    assert not any(array.any() for array in (tiles.visits, tiles.occupied, tiles.hits, tiles.means))


@pytest.mark.table("direction", [(1, 0), (-1, 0), (0, 1), (0, -1), (-1, -1)])
def test_the_window_grows_in_every_direction(direction):
    # given something mapped at the origin
    maps, beams = TileMaps(1, DELTA), beams_from(np.random.default_rng(3), 10, reach=5.0)
    maps.insert(np.zeros((1, 3)), beams)
    before = plain_of(maps, 0).visits
    old_corner = maps.corner.copy()
    # when the window is asked to reach 100 m away
    place = 100.0 * np.array(direction)
    maps.cover(np.minimum(place, 0.0), np.maximum(place, 0.0))
    # then it does, and what was there is where it was
    low, size = maps.corner * SIDE * DELTA, np.array(maps.tables.shape[:0:-1]) * SIDE * DELTA
    assert (low <= np.minimum(place, 0.0)).all()
    assert (low + size >= np.maximum(place, 0.0)).all()
    x, y = (old_corner - maps.corner) * SIDE
    after = plain_of(maps, 0).visits
    np.testing.assert_array_equal(after[y : y + before.shape[0], x : x + before.shape[1]], before)
    assert after.sum() == before.sum()


def test_a_map_is_refused_before_its_drawing_would_fill_the_memory():
    # 3 x 3 km of cells of 5 cm would be drawn on 3.6 GB
    maps = TileMaps(1, 0.05)
    with pytest.raises(MapError, match="choose a larger delta"):
        maps.cover((-1500.0, -1500.0), (1500.0, 1500.0))
    # when a square kilometre and a corridor of 100 km are asked for, they are there, and no more is drawn
    for far in ((1000.0, 1000.0), (1e5, 1.0)):
        maps = TileMaps(1, 0.05)
        maps.cover((0.0, 0.0), far)
        assert maps.tables[0].size * SIDE**2 <= 420e6


def test_a_map_of_absurd_size_is_refused_and_nothing_changes():
    maps = TileMaps(2, DELTA)
    maps.cover((0.0, 0.0), (1.0, 1.0))
    shape = maps.tables.shape
    with pytest.raises(
        MapError, match="check whether odometry and ranges are in metres, or choose a larger delta"
    ):
        maps.cover((-1e5, 0.0), (1e5, 1e5))
    assert maps.tables.shape == shape
