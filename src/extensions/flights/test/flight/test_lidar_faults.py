"""Faults of a lidar: as many beams as asked for, the same for the same seed; panes by their geometry."""

import math

import numpy as np
import pytest

from flights.flight.lidar.faults import TURNS_S, LidarFaults, Pane, panes_of
from flights.worlds.drawn.barriers import GLASS, barriers_sdf
from simulation_tools.geometry import Pose
from simulation_tools.sdf.parser import load_world
from simulation_tools.sensors.lidar import Lidar
from simulation_tools.vehicle.uav import load_uav

POSE = Pose((0.0, 0.0, 2.0))


class Walls:
    """Planes x = const, m; those that are panes are a centimetre thick."""

    def __init__(self, *walls_x):
        self.walls_x = walls_x

    def cast(self, origins, directions, max_range_m, ignore_model=None):
        origins = np.broadcast_to(np.asarray(origins, float), directions.shape)
        with np.errstate(divide="ignore", invalid="ignore"):
            ranges = [(x - origins[:, 0]) / directions[:, 0] for x in self.walls_x]
        ranges = np.where(np.array(ranges) > 1e-6, ranges, np.inf).min(axis=0)
        return np.where(ranges < max_range_m, ranges, np.inf).astype(np.float32)


@pytest.fixture(scope="module")
def lidar():
    carried = load_uav("iris", "ust").lidar
    return Lidar(carried.sensor, Pose((0.0, 0.0, 0.0)), np.random.default_rng(1))


def angles_of(lidar):
    return lidar.angle_min + lidar.angle_increment * np.arange(lidar.beams)


def spoiled(lidar, ranges, rays=None, t_s=0.0, seed=1, panes=(), **faults):
    given = {"rain": 0.0, "lost_view": 0.0, "glass_deg": 90.0, **faults}
    spoiler = LidarFaults(**given, panes=list(panes), lidar=lidar, rng=np.random.default_rng(seed))
    return spoiler.spoiled(ranges, t_s, rays, POSE, None)


def test_without_faults_nothing_changes(lidar):
    faults = LidarFaults(0.0, 0.0, 90.0, [Pane(np.zeros(2), np.array((1.0, 0.0)), 1.0)], lidar, None)
    assert not faults.are_any


def test_rain_shortens_the_share_of_beams_asked_for_by_the_seed(lidar):
    ranges = np.full(lidar.beams, np.inf, np.float32)
    ranges[:200] = 3.0
    wet = spoiled(lidar, ranges, rain=0.05)
    short = wet < ranges
    assert short.mean() == pytest.approx(0.05, abs=4 * math.sqrt(0.05 * 0.95 / lidar.beams))
    assert np.array_equal(wet[~short], ranges[~short])
    assert lidar.range_min <= wet[short].min() < wet[short].max() <= lidar.range_max
    assert np.array_equal(wet, spoiled(lidar, ranges, rain=0.05))
    assert not np.array_equal(wet, spoiled(lidar, ranges, rain=0.05, seed=2))


def test_a_lost_part_of_the_view_is_in_one_piece_and_stays_for_a_while(lidar):
    ranges = np.full(lidar.beams, 3.0, np.float32)
    faults = LidarFaults(0.0, 0.2, 90.0, [], lidar, np.random.default_rng(1))
    lost = np.array([np.isinf(faults.spoiled(ranges, 0.025 * k, None, POSE, None)) for k in range(400)])
    assert (lost.sum(axis=1) == round(0.2 * lidar.beams)).all()
    assert (np.abs(np.diff(lost.astype(int), axis=1)).sum(axis=1) <= 2).all()
    changes = np.flatnonzero((lost[1:] != lost[:-1]).any(axis=1)) * 0.025
    assert np.diff(changes).min() >= TURNS_S[0]
    assert np.diff(changes).max() <= TURNS_S[1] + 0.05
    assert lost.any(axis=0).mean() > 0.9


def test_a_pane_answers_beams_near_its_normal_and_lets_others_through(lidar):
    """A pane at x = 2 m, a wall at 5 m: beams within 30 degrees of the normal end at 2 / cos."""
    angles, rays = angles_of(lidar), Walls(2.0, 5.0)
    ranges = rays.cast(np.zeros(3), lidar.directions, lidar.range_max)
    pane = Pane(np.array((2.0, 0.0)), np.array((1.0, 0.0)), 50.0)
    found = spoiled(lidar, ranges, rays, panes=[pane], glass_deg=30.0)
    near, far = np.abs(angles) < np.radians(29.9), np.abs(angles) > np.radians(30.1)
    far &= np.abs(angles) < np.radians(59.0)  # beyond, the wall is out of range
    assert found[near] == pytest.approx(2.0 / np.cos(angles[near]), abs=1e-4)
    assert found[far] == pytest.approx(5.0 / np.cos(angles[far]), abs=1e-3)
    beside = spoiled(lidar, ranges, rays, panes=[Pane(pane.middle_xy, pane.normal_xy, 0.1)], glass_deg=30.0)
    assert np.array_equal(beside, ranges)


def test_beams_pass_two_panes_one_behind_the_other(lidar):
    rays, normal = Walls(2.0, 3.0, 5.0), np.array((1.0, 0.0))
    ranges = rays.cast(np.zeros(3), lidar.directions, lidar.range_max)
    panes = [Pane(np.array((x, 0.0)), normal, 50.0) for x in (3.0, 2.0)]
    found = spoiled(lidar, ranges, rays, panes=panes, glass_deg=10.0)
    beam = np.abs(angles_of(lidar) - 0.5).argmin()
    assert found[beam] == pytest.approx(5.0 / math.cos(angles_of(lidar)[beam]), abs=1e-3)


def test_the_panes_of_a_drawn_world_are_found(tmp_path):
    path = tmp_path / "glass.world"
    path.write_text(barriers_sdf(np.random.default_rng(3), GLASS, 26.0))
    world = load_world(str(path))
    panes = panes_of(world)
    assert len(panes) == len(world.models) - 1 >= 2  # all but the floor
    for pane in panes:
        assert np.linalg.norm(pane.normal_xy) == pytest.approx(1.0)
        assert abs(pane.normal_xy[0]) > math.cos(0.61)
        assert 1.5 <= pane.half_m <= 3.5
