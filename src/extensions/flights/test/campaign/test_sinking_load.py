"""Whether a load could have been avoided: closed form of reaction, acceleration and distance."""

import math

import numpy as np
import pytest

from flights.campaign.sinking_load import (
    ACCELERATION_M_S2,
    BODY_M,
    DELAY_S,
    DIVE_M_S,
    DIVE_M_S2,
    ROTORS_ABOVE_M,
    Load,
    Sight,
    could_be_avoided,
    escapes,
)
from simulation_tools.geometry import Pose
from simulation_tools.sdf.elements import Script, Trajectory, Waypoint
from simulation_tools.world.scripted_motion import ScriptedMotion

HEIGHT_M = 2.0
UPRIGHT = (0.0, 0.0, 0.0, 1.0)
PLANAR = Sight((0.0, 0.0), 10.0, (0.0, 0.0, 0.1), looks_up=True)


BEGIN_S = 5.0


def load_of(edge_m, speed_m_s, above_m):
    """A cube over the origin whose bottom is so far above the rotors at BEGIN_S; it sinks evenly."""
    bottom_m = HEIGHT_M + ROTORS_ABOVE_M + above_m + speed_m_s * BEGIN_S
    ways = [Waypoint(t, Pose((0.0, 0.0, bottom_m - speed_m_s * t), UPRIGHT)) for t in range(20)]
    return Load((edge_m,) * 3, ScriptedMotion(Script((Trajectory(tuple(ways)),), loop=False)))


@pytest.mark.parametrize("edge_m", [0.5, 2.0])
@pytest.mark.parametrize("speed_m_s", [1.5, 2.0])
def test_who_hovers_under_the_middle_needs_the_time_of_an_even_acceleration_to_the_side(edge_m, speed_m_s):
    # Half the edge and the body at 9.81 m/s2, after the delay; the rotors sink at 1 m/s meanwhile
    needed_s = DELAY_S + math.sqrt(2.0 * (0.5 * edge_m + BODY_M) / ACCELERATION_M_S2)
    lost_s = DELAY_S + 0.5 * DIVE_M_S / DIVE_M_S2  # by which the dive is behind one that begins at full speed
    above_m = speed_m_s * needed_s - DIVE_M_S * (needed_s - lost_s)
    place, hovers = np.array((0.0, 0.0, HEIGHT_M)), np.zeros(3)
    assert escapes(BEGIN_S, place, hovers, load_of(edge_m, speed_m_s, above_m + 0.03))
    assert not escapes(BEGIN_S, place, hovers, load_of(edge_m, speed_m_s, above_m - 0.03))


def flight(x_m, until_s):
    """Poses (n, 8) of a flight at 1 m/s that begins at x_m at BEGIN_S."""
    t = np.arange(0.0, until_s, 0.025)
    rows = np.zeros((len(t), 8))
    rows[:, 0], rows[:, 1], rows[:, 3], rows[:, 7] = BEGIN_S + t, x_m + t, HEIGHT_M, 1.0
    return rows


def test_a_small_load_that_no_beam_meets_before_the_rotors_is_unavoidable():
    # Given a cube of 0.35 m that comes down 0.4 m beside the one beam, when the UAV is there
    load = load_of(0.35, 1.0, 2.0)
    rows = flight(-2.0, 2.05)
    rows[:, 2] = 0.4
    # Then the planar lidar, 0.1 m above the rotors, sees it 0.08 s before the rotors meet it
    assert not could_be_avoided(rows, load, PLANAR)


def test_a_load_that_a_lidar_sees_from_afar_is_avoidable():
    load = load_of(0.35, 1.0, 2.0)
    assert could_be_avoided(
        flight(-2.0, 2.05), load, Sight((-0.9, 0.9), 20.0, (0.0, 0.0, 0.1), looks_up=False)
    )


def test_a_load_over_the_beam_for_two_seconds_is_avoidable():
    assert could_be_avoided(flight(-2.0, 3.5), load_of(2.0, 1.0, 3.5), PLANAR)
