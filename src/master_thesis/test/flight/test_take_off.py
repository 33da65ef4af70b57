"""How high a UAV hovers after a take-off between two parts of its errand."""

import pytest

from master_thesis.errors import FlightError
from master_thesis.flight.take_off import hover_height_m


def test_it_rises_to_its_usual_height_if_there_is_room():
    assert hover_height_m(5.0, 2.0, 0.12) == 2.0


def test_below_something_it_rises_less():
    assert hover_height_m(1.2, 2.0, 0.12) == pytest.approx(1.32)


def test_without_room_it_stays_on_the_ground_with_a_sentence():
    with pytest.raises(FlightError, match=r"could hover only 0\.32 m over the ground, but needs 0\.5 m"):
        hover_height_m(0.2, 2.0, 0.12)
