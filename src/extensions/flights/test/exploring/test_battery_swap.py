"""A UAV lands at home for a full battery and takes off again, as high as there is room."""

from dataclasses import replace

import numpy as np
import pytest

from flights.exploring.battery_swap import BatterySwap
from flights.flight.closed_loop import ClosedLoop
from flights.mapping.mapping_flight import parameters_of
from simulation_tools.vehicle.energy.battery import BatteryStart

pytestmark = pytest.mark.flight

HERE_M = np.zeros(3)


class Volume:
    """A map that shows so much room above the UAV."""

    def __init__(self, room_m):
        self.room_m, self.asked = room_m, []

    def room_above_m(self, place_m, wanted_m):
        self.asked.append((place_m.tolist(), wanted_m))
        return min(self.room_m, wanted_m)


def swapped(room_m=5.0, has_battery=True):
    """A UAV hovers, lands for a battery and, if it may, takes off: its outcome, height, charge, the map."""
    given = parameters_of("room", "puck", 2)
    given = replace(given, simulation=replace(given.simulation, battery=BatteryStart(0.5)))
    volume = Volume(room_m)
    with ClosedLoop(replace(given, mission=(), goal_xyz_m=None)) as loop:
        while not loop.publisher.ready:
            loop.step()
        swap = BatterySwap(loop, lambda: has_battery, volume)
        swap.begin()
        is_back = False
        while not (is_back or loop.is_over):
            loop.step()
            is_back = swap.follow(HERE_M)
        assert swap.is_under_way != is_back
        return loop.outcome, loop.log.truth.rows[-1][3], loop.charge, volume


def test_it_gets_a_full_battery_and_hovers_as_high_as_ever():
    outcome, height_m, charge, volume = swapped()
    assert outcome.failure is None
    assert height_m == pytest.approx(2.0, abs=0.1)
    assert charge > 0.95
    assert volume.asked == [([0.0, 0.0, 0.0], 2.0)]


@pytest.mark.long
def test_below_something_it_hovers_lower():
    assert swapped(room_m=0.9)[1] == pytest.approx(1.02, abs=0.1)


@pytest.mark.parametrize(
    ("room_m", "has_battery", "why"),
    [(0.1, True, "stays on the ground"), pytest.param(5.0, False, "no full battery", marks=pytest.mark.long)],
)
def test_without_room_or_battery_the_run_ends_with_a_sentence(room_m, has_battery, why):
    outcome, height_m, _, _ = swapped(room_m, has_battery)
    assert why in outcome.failure
    assert height_m < 0.3
