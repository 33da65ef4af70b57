"""Something stands before the UAV of which nobody knew, as a load that has just come into the plane."""

import math
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest
from planar_flight import BODY_RADIUS_M, Scene, Uav, fly, to_goal

from cepa import CepaParameters, Dynamic
from cepa.dynamic.kernels.response import fly as fly_exactly
from cepa.dynamic.observer import response_of
from cepa.dynamic.ways_out.hard_braking import hardest_braking, is_too_late
from cepa.dynamic.ways_out.ways_out import must_brake_hard

MODEL = CepaParameters().response


@dataclass(frozen=True)
class Lowered(Scene):
    """Walls that are in the scan's plane from the instant on at which the UAV is at ``from_m``, and stay."""

    from_m: float = 0.0

    def _to_walls(self, position, directions):
        met = super()._to_walls(position, directions)
        return met if position[0] >= self.from_m else np.full(len(directions), np.inf)


@pytest.mark.table(("speed", "ahead_m"), [(1.0, 0.75), (1.5, 0.95), (2.0, 1.3)])
def test_what_appears_within_the_usual_braking_distance_is_not_touched(speed, ahead_m):
    # Told to stand, it loses its speed with 1 / (1.8 per s): it flies on for 0.56 s of its flight, and more
    # by its lag. It would have 0.2 m left, or less. With 6 m/s2 it needs 0.08 m of 1 m/s, or 0.33 m of 2 m/s.
    assert ahead_m - speed / 1.8 < BODY_RADIUS_M < ahead_m - speed * 0.2 - speed**2 / 12.0
    wall = np.array([[4.0 + ahead_m, -1.5, 4.0 + ahead_m, 1.5]])
    scene, uav = Lowered(walls=wall, from_m=4.0), Uav(velocity=(speed, 0.0))
    flight = fly(Dynamic(), scene, to_goal((12.0, 0.0), speed), uav, np.random.default_rng(5), 6.0)
    assert max(x for x, _ in flight.path) > 4.0
    assert flight.clearance_m > BODY_RADIUS_M


@pytest.mark.table("speed", [0.3, 1.0, 3.0, 5.0])
def test_the_uav_has_its_greatest_acceleration_and_does_not_fly_back(speed):
    state, step_s = np.zeros((3, 4)), 0.001
    state[:2, 1] = 0.6 * speed, -0.8 * speed
    response, fastest_m_s2, backward_m_s = response_of(MODEL, step_s), 0.0, 0.0
    for _ in range(80):  # scans
        command = hardest_braking(state[:2, 1], MODEL)
        commands = np.array([[0.0, 9.0, *command]])
        fly_exactly(state, commands, 0, 1, 0.0, 0.025, response)
        fastest_m_s2 = max(fastest_m_s2, math.hypot(*state[:2, 2]))
        backward_m_s = max(backward_m_s, -float(state[:2, 1] @ (0.6, -0.8)))
    assert fastest_m_s2 > 0.55 * min(MODEL.acceleration_max_m_s2, 4.0 * MODEL.p * speed)
    assert backward_m_s < 0.1 * speed
    assert math.hypot(*state[:2, 1]) < 0.02


def test_at_1_m_s_the_command_asks_for_just_the_greatest_acceleration():
    command = hardest_braking(np.array([1.0, 0.0]), MODEL)
    assert MODEL.p * (command[0] - 1.0) == pytest.approx(-MODEL.acceleration_max_m_s2)


@pytest.mark.table(
    ("clearance_m", "is_late"),
    [((0.8, 0.5, 0.45), False), ((0.8, 0.5, 0.3), True), ((0.3, 0.3, 0.29), False), ((0.3, 0.2, 0.1), True)],
)
def test_it_is_too_late_if_standing_ends_within_the_hull_and_nearer_than_now(clearance_m, is_late):
    assert is_too_late(np.array(clearance_m), 0.4) is is_late


@pytest.mark.table(
    ("speed", "clouds_show_heights", "is_hard"),
    [(1.0, False, True), (1.0, True, False), (0.2, False, False), (0.2, True, False)],
)
def test_a_slow_uav_and_one_that_knows_ways_over_and_under_it_do_not(speed, clouds_show_heights, is_hard):
    """In rough galleries it would no longer climb. A UAV that hovers would be thrown to and fro."""
    state = np.zeros((3, 4))
    state[:2, 1] = 0.6 * speed, -0.8 * speed
    for knows_one_height, is_expected in ((True, speed > 0.3), (not clouds_show_heights, is_hard)):
        knowledge = SimpleNamespace(knows_one_height=knows_one_height)
        step = SimpleNamespace(snapshot=SimpleNamespace(state=state), knowledge=knowledge)
        assert must_brake_hard(step) is is_expected
