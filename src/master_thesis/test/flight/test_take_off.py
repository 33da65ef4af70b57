"""How high a UAV hovers after a take-off between two parts of its errand."""

from dataclasses import replace

import pytest

from master_thesis.errors import FlightError
from master_thesis.experiments_3_4.mapping_flight import parameters_of
from master_thesis.flight.closed_loop import ClosedLoop
from master_thesis.flight.take_off import hover_height_m


def test_it_rises_to_its_usual_height_if_there_is_room():
    assert hover_height_m(5.0, 2.0, 0.12) == 2.0


def test_below_something_it_rises_less():
    assert hover_height_m(1.2, 2.0, 0.12) == pytest.approx(1.32)


def test_without_room_it_stays_on_the_ground_with_a_sentence():
    with pytest.raises(FlightError, match=r"could hover only 0\.32 m over the ground, but needs 0\.5 m"):
        hover_height_m(0.2, 2.0, 0.12)


def test_a_flight_that_cannot_take_off_again_ends():
    given = parameters_of("room", "puck", 2)
    with ClosedLoop(replace(given, mission=(), goal_xyz_m=None)) as loop:
        loop.step()
        asked = []
        assert not loop.take_off_again(lambda wanted_m: asked.append(wanted_m) or 0.1)
        assert asked == [given.publisher.hover_height_m]
        assert loop.is_over
        assert "stays on the ground" in loop.outcome.failure


def test_a_flight_with_little_room_hovers_lower():
    given = parameters_of("room", "puck", 2)
    with ClosedLoop(replace(given, mission=(), goal_xyz_m=None)) as loop:
        loop.step()
        assert loop.take_off_again(lambda wanted_m: 0.9)
        while not loop.publisher.ready:
            loop.step()
        assert loop.log.truth.rows[-1][3] == pytest.approx(0.9 + given.publisher.ground_clearance_m, abs=0.1)
