"""The cushions against values worked out by hand, and the compiled form of 6.7 against the written one."""

import math

import numpy as np
import pytest

from cepa import view
from cepa.scan import Grid
from cepa.thesis.cushion import improved_cushion, original_cushion

DEGREE = math.pi / 180.0


@pytest.mark.table("cushion", [original_cushion, improved_cushion])
def test_sides_and_back(cushion):
    # |v| T = 3 m, r = 0.5 m: the sides are 0.5 m away from the line of travel, the back is a half circle
    edge = cushion(
        [30 * DEGREE, -30 * DEGREE, 60 * DEGREE, 90 * DEGREE, 135 * DEGREE, math.pi], 2.0, 0.5, 1.5
    )
    assert edge == pytest.approx([1.0, 1.0, 0.5 / math.sin(60 * DEGREE), 0.5, 0.5, 0.5])


def test_the_originals_end_is_a_half_circle_about_the_point_reached():
    psi = np.linspace(-0.16, 0.16, 9)  # gamma = atan(0.5 / 3) = 0.165
    edge = original_cushion(psi, 2.0, 0.5, 1.5)
    assert edge[4] == pytest.approx(3.5)
    assert np.hypot(edge * np.cos(psi) - 3.0, edge * np.sin(psi)) == pytest.approx(0.5)


def test_the_improveds_end_is_an_arc_about_the_uav():
    gamma = math.asin(0.5 / 3.5)
    edge = improved_cushion([0.0, 0.9 * gamma, -gamma], 2.0, 0.5, 1.5)
    assert edge == pytest.approx([3.5, 3.5, 3.5])
    assert improved_cushion(1.1 * gamma, 2.0, 0.5, 1.5) == pytest.approx(0.5 / math.sin(1.1 * gamma))


@pytest.mark.table("cushion", [original_cushion, improved_cushion])
@pytest.mark.table("speed", [0.0, 0.1, 1.0, 4.0])
def test_the_edge_has_no_jumps(cushion, speed):
    edge = cushion(np.linspace(-math.pi, math.pi, 200_001), speed, 0.5, 1.5)
    assert np.isfinite(edge).all()
    assert np.abs(np.diff(edge)).max() < 0.01


def test_the_improved_cushion_holds_the_original():
    psi = np.linspace(-math.pi, math.pi, 10_001)
    assert (improved_cushion(psi, 2.0, 0.5, 1.5) >= original_cushion(psi, 2.0, 0.5, 1.5) - 1e-12).all()


@pytest.mark.table(("count", "increment"), [(144, 2 * math.pi / 144), (6, 1.0), (1081, 0.0058)])
def test_the_table_gives_the_same_cushion(count, increment):
    grid = Grid(count, increment)
    for speed in (0.5, 2.0):
        for radius in (0.5, 1.2):
            table = np.minimum(speed * 1.5 + radius, radius * grid.reach)
            assert table == pytest.approx(improved_cushion(grid.offset_angles, speed, radius, 1.5), abs=1e-12)


def test_the_cushion_along_a_path_is_the_band_around_it():
    path = np.stack([np.linspace(0.0, 2.0, 11), np.full(11, 0.3)], axis=1)
    edge = view.path_edge(path, 0.5)
    beyond = edge - np.clip(edge, (0.0, 0.3), (2.0, 0.3))
    np.testing.assert_allclose(np.hypot(*beyond.reshape(-1, 2).T), 0.5, rtol=0.03)
    assert np.hypot(*(edge[:, 0] - edge[:, 1]).T).sum() == pytest.approx(2 * 2.0 + math.pi, rel=0.05)
    strips = view.path_strips(path, 0.5, 0.01)
    area = 0.01 * (strips[:, 1, 0] - strips[:, 0, 0]).sum()
    assert area == pytest.approx(2.0 * 1.0 + math.pi * 0.25, rel=0.02)
    assert len(view.path_edge(path[:0], 0.5)) == len(view.path_strips(path[:0], 0.5)) == 0
