"""Which beams agree with a map, against a plain reference on whole tables."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from plain_maps import SIZE, plain_of

from gridslam.kernels.agreement import NEAR
from gridslam.maps.beams import Beams
from gridslam.maps.tile_map import TileMaps
from gridslam.parameters import SlamParameters
from gridslam.scan import PlanarScan

DELTA = 0.05
HOME = (SIZE / 2 * DELTA, SIZE / 2 * DELTA, 0.3)


def square_scan(half_m: float = 1.0, beams: int = 90) -> PlanarScan:
    angles = np.linspace(-math.pi, math.pi, beams, endpoint=False)
    ranges = half_m / np.maximum(np.abs(np.cos(angles)), np.abs(np.sin(angles)))
    return PlanarScan(0.0, angles, ranges, (0.0, 0.0, 0.0), 10.0)


@pytest.fixture(scope="module")
def room():
    """A square room of 2 m with one map, and the same in plain tables: (maps, plain)."""
    maps = TileMaps(1, DELTA)
    maps.cover((0.5, 0.5), (SIZE * DELTA - 0.5, SIZE * DELTA - 0.5))
    for _ in range(3):
        maps.insert(np.array([HOME]), Beams.from_scan(square_scan(), SlamParameters(delta=DELTA)))
    return maps, plain_of(maps, 0)


def plainly(plain, pose, lidar_xy, ends_xy):
    """Numbers of beams that agree, contradict and say nothing, beam by beam."""
    occupied, counts = plain.occupied, [0, 0, 0]

    def at(table, x, y):
        inside = 0 <= y < table.shape[0] and 0 <= x < table.shape[1]
        return inside and bool(table[y, x])

    turn = np.array([[math.cos(pose[2]), -math.sin(pose[2])], [math.sin(pose[2]), math.cos(pose[2])]])
    start = turn @ lidar_xy + pose[:2]
    for end in ends_xy @ turn.T + pose[:2]:
        x, y = np.floor(end).astype(int)
        near = range(-NEAR, NEAR + 1)
        if any(at(occupied, x + dx, y + dy) for dx in near for dy in near):
            counts[0] += 1
            continue
        steps = int(np.abs(end - start).max())
        way = np.floor(start + np.linspace(0.0, 1.0, steps + 1)[:, None] * (end - start)).astype(int)
        crossed = any(at(occupied, *cell) for cell in way) if steps else at(occupied, x, y)
        counts[1 if crossed or at(plain.visits, x, y) else 2] += 1
    return tuple(counts)


@given(
    st.tuples(st.floats(-20.0, 20.0), st.floats(-20.0, 20.0), st.floats(-3.0, 3.0)),
    st.integers(0, 1000),
)
def test_it_is_the_plain_count(room, offset, seed):
    maps, plain = room
    rng = np.random.default_rng(seed)
    pose = maps.to_cells(np.array(HOME)) + offset
    lidar, ends = rng.uniform(-3.0, 3.0, 2), rng.uniform(-45.0, 45.0, (40, 2))
    beams = Beams(lidar, ends, np.ones(len(ends), bool), np.pad(ends, ((0, 0), (0, 5))))
    found = maps.agreement(0, maps.to_metres(pose), beams)
    assert (found.agreeing, found.clashing, found.unseen) == plainly(plain, pose, lidar, ends)


def test_a_scan_agrees_where_it_was_taken_and_not_elsewhere(room):
    maps, _ = room
    beams = Beams.from_scan(square_scan(), SlamParameters(delta=DELTA))
    here = maps.agreement(0, np.array(HOME), beams)
    assert (here.share(), here.compared_share) == (1.0, 1.0)
    # 0.5 m off to one side, the near wall is 0.5 m behind the map's, and the far one in free space
    aside = maps.agreement(0, np.add(HOME, (0.5, 0.0, 0.0)), beams)
    assert aside.share() < 0.7
    # a room of half the size ends in free space
    small = Beams.from_scan(square_scan(0.5), SlamParameters(delta=DELTA))
    assert maps.agreement(0, np.array(HOME), small).agreeing == 0
