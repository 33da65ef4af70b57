"""A landing between two parts of an itinerary."""

from flights.exploring.stopover import Stopover


def test_it_lands_gets_its_battery_and_goes_on_when_it_hovers_again():
    stopover = Stopover()
    # Given a flight; then nothing of it is a stopover
    assert not stopover.on_armed(True)
    assert not stopover.on_ready(True)
    # When it lands between, then the battery is due once, at the disarming
    stopover.begin()
    assert not stopover.on_armed(True)
    assert stopover.on_armed(False)
    assert not stopover.on_armed(False)
    # When it takes off again, then it goes on only when it is armed and hovers
    stopover.take_off()
    assert not stopover.on_ready(True)
    assert not stopover.on_armed(True)
    assert not stopover.on_ready(False)
    assert stopover.on_ready(True)
    assert not stopover.is_under_way
    assert not stopover.on_ready(True)


def test_a_disarming_in_flight_or_without_a_connection_is_no_landing_between():
    stopover = Stopover()
    stopover.on_armed(True)
    assert not stopover.on_armed(False)
    stopover.begin()
    assert not stopover.on_armed(None)
    assert not stopover.on_armed(False)
