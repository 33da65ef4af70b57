"""How high a UAV hovers after its take-offs."""

import pytest

from flights.errors import FlightError
from flights.flight.take_off import first_hover_m, hover_height_m


def test_it_rises_to_its_usual_height_if_there_is_room():
    assert hover_height_m(5.0, 2.0, 0.12) == 2.0


def test_below_something_it_rises_less():
    assert hover_height_m(1.2, 2.0, 0.12) == pytest.approx(1.32)


def test_without_room_it_stays_on_the_ground_with_a_sentence():
    with pytest.raises(FlightError, match=r"could hover only 0\.22 m over the ground, but needs 0\.3 m"):
        hover_height_m(0.1, 2.0, 0.12)


@pytest.mark.table(
    ("ceiling_m", "keep_m", "height_m"),
    [
        (3.0, 0.5, 2.0),  # 2.5 m are allowed
        (2.4, 0.5, 1.7),  # 0.2 m below what is allowed
        (2.0, 0.5, 1.3),
        (1.2, 0.22, 0.78),
        (0.9, 0.22, 0.49),  # the middle of 0.3 and 0.68
        (1.0, 0.5, 0.5),  # just as high as the UAV needs
        (0.9, 0.5, None),
    ],
)
def test_the_first_take_off_leads_as_high_as_the_room_allows(ceiling_m, keep_m, height_m):
    assert first_hover_m(ceiling_m - keep_m, keep_m) == height_m
