"""A cloud's topic that dies in flight, and clouds with more points than the memory holds."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pytest
from spatial_flight import NO_SCAN, PERIOD_S, Boxes, fly_along_x, motion_at

from cepa import CepaParameters, Cloud, Dynamic, LaserScan2D, Reason
from cepa.dynamic import space_knowledge
from cepa.dynamic.remembered import voxel_memory

BEAMS = 720
AZIMUTH = -math.pi + np.arange(BEAMS) * 2.0 * math.pi / BEAMS
AROUND = np.stack([np.cos(AZIMUTH), np.sin(AZIMUTH), np.full(BEAMS, 1e-9)], axis=1)
DIES_S = 4.0
HALL = np.array(
    [
        [(-5.0, -4.2, 0.0), (60.0, -4.0, 5.0)],
        [(-5.0, 4.0, 0.0), (60.0, 4.2, 5.0)],
        [(-5.2, -4.2, 0.0), (-5.0, 4.2, 5.0)],
    ]
)


@dataclass(frozen=True)
class HallWithPole(Boxes):
    """A hall of 8 m, in which a pole appears 2 m ahead; its clouds come until ``dies_s``, the scan always."""

    dies_s: float = math.inf
    lost: tuple[int, ...] = ()
    """Numbers of single clouds that get lost."""
    appears_s: float = math.inf
    now_s: float = 0.0

    def at(self, t_s, position):
        corners, appears_s = self.corners, self.appears_s
        if t_s >= appears_s - 1e-6:
            x, y = position[0] + 2.0, position[1]
            pole = np.array([[(x, y - 0.1, 0.0), (x + 0.2, y + 0.1, 5.0)]])
            corners, appears_s = np.concatenate((corners, pole)), math.inf
        return HallWithPole(corners, self.dies_s, self.lost, appears_s, t_s)

    def senses(self, position):
        ranges = self.ranges(position, AROUND)
        scan = LaserScan2D(
            np.where(ranges > 30.0, math.inf, ranges), -math.pi, 2 * math.pi / BEAMS, 0.1, 30.0
        )
        is_there = self.now_s < self.dies_s - 1e-6 and round(self.now_s / PERIOD_S) not in self.lost
        return scan, self.cloud(position) if is_there else None


def warnings_of(flight):
    return [sentence for decision in flight.decisions for sentence in decision.warnings]


@pytest.mark.parametrize(
    ("speed", "later_s"), [pytest.param(1.0, 0.1, marks=pytest.mark.long), (2.0, 0.1), (2.0, 1.5)]
)
def test_a_pole_that_appears_after_the_clouds_have_died_is_not_touched(speed, later_s):
    world = HallWithPole(HALL, dies_s=DIES_S, appears_s=DIES_S + later_s)
    flight = fly_along_x(Dynamic(), world, speed, 6.0 + speed, patience_s=14.0)
    assert min(flight.clearances_m) > 0.05
    assert flight.positions[-1][0] > 6.0 + speed  # by the planar scan
    assert [sentence.split(":")[0] for sentence in warnings_of(flight)] == [
        "No cloud has come with the scans for 0.40 s"
    ]


def test_it_flies_on_by_the_planar_scan_when_clouds_are_forgotten():
    world = HallWithPole(HALL, dies_s=DIES_S, appears_s=DIES_S + 5.0)
    flight = fly_along_x(Dynamic(CepaParameters(memory_s=2.0)), world, 1.5, 10.5, patience_s=16.0)
    assert flight.positions[-1][0] > 10.5
    assert min(flight.clearances_m) > 0.05
    assert np.ptp([position[2] for position in flight.positions[35:]]) < 0.2


def test_clouds_that_get_lost_now_and_then_are_no_reason_to_warn():
    world = HallWithPole(HALL, lost=tuple(range(20, 90, 3)), appears_s=6.0)
    flight = fly_along_x(Dynamic(), world, 2.0, 9.0, patience_s=10.0)
    assert flight.positions[-1][0] > 9.0
    assert min(flight.clearances_m) > 0.05
    assert not warnings_of(flight)


def test_it_tells_when_clouds_come_again():
    world = HallWithPole(HALL, lost=tuple(range(20, 30)))
    flight = fly_along_x(Dynamic(), world, 0.5, 9.0, patience_s=5.0)
    assert [sentence.split(".")[0] for sentence in warnings_of(flight)] == [
        "No cloud has come with the scans for 0",
        "Clouds come with the scans again",
    ]


CHANNELS, SPREAD_RAD, NOISE_M = 64, math.radians(22.5), 0.02
HALF_HALL_M, POLE_X_M = np.array([7.0, 7.0, 1.5]), 0.42
POLE = Boxes(np.array([[(POLE_X_M, -0.05, -1.5), (POLE_X_M + 0.1, 0.05, 1.5)]]))
LIMITS = (-SPREAD_RAD, SPREAD_RAD), 0.5, 100.0
_around, _up = np.meshgrid(np.radians(np.arange(0.0, 360.0, 0.4)), np.linspace(*LIMITS[0], CHANNELS))
_axes = np.cos(_up) * np.cos(_around), np.cos(_up) * np.sin(_around), np.sin(_up)
RAYS = np.stack(_axes, axis=-1).reshape(-1, 3)


def inside_a_hall(position):
    """Return how far RAYS go in a bare hall of 14 x 14 x 3 m around the origin, m."""
    with np.errstate(divide="ignore"):
        ends = [(side * HALF_HALL_M - position) / RAYS for side in (-1.0, 1.0)]
    return np.maximum(*ends).min(axis=1)


def test_what_stands_ahead_is_seen_however_many_points_the_clouds_show(monkeypatch):
    for module in (voxel_memory, space_knowledge):
        monkeypatch.setattr(module, "MOST_POINTS", 40000)  # so that fewer clouds fill it
    rng, steering, warnings = np.random.default_rng(0), Dynamic(), []
    for number in range(20):
        position, pole_is_there = np.array([-2.0 + 0.1 * number, 0.0, 0.0]), number >= 18
        ranges = inside_a_hall(position)
        if pole_is_there:
            ranges = np.minimum(ranges, POLE.ranges(position, RAYS))
        points = RAYS * (ranges + rng.normal(0.0, NOISE_M, len(RAYS)))[:, None]
        motion, v_ref = motion_at(0.1 * number, position), (1.0, 0.0) if pole_is_there else (0.0, 0.0)
        decision = steering.steer(NO_SCAN, v_ref, (0.0, 0.0), motion, Cloud(points, *LIMITS))
        warnings += decision.warnings
        if pole_is_there:
            clearance_m = steering.report().clearance_m
            assert clearance_m == pytest.approx(POLE_X_M - position[0] - 0.35, abs=5.0 * NOISE_M)
            assert decision.reason is not Reason.CUSHION_CLEAR
    assert len(warnings) == 1
    assert warnings[0].startswith("Clouds show more than 40000 cells within 7.5 m")
