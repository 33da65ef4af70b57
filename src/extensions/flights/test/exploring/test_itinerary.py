"""What follows when a leader of a flight has ended."""

import pytest

from flights.exploring.itinerary import Itinerary, Next


def told(itinerary, *ends):
    """What follows each end at home; whoever lands between takes a battery if there is one."""
    steps = []
    for end in ends:
        steps.append(itinerary.after(end, is_home=True))
        if steps[-1] not in (Next.OVER, Next.LOST):
            itinerary.take_battery()
    return steps


def test_an_exploration_is_followed_by_the_photographs_and_each_battery_counts_once():
    itinerary = Itinerary(parts=2, swaps=3)
    assert told(itinerary, "battery", "explored") == [Next.AGAIN, Next.NEXT_PART]
    assert itinerary.part == 1
    assert itinerary.swapped == [1, 1]
    assert told(itinerary, "battery", "done") == [Next.AGAIN, Next.OVER]
    assert itinerary.swapped == [1, 2]


@pytest.mark.table("end", ["explored", "time", "shut in"])
def test_whatever_ends_the_exploration_at_home_but_an_abort_the_photographs_follow(end):
    itinerary = Itinerary(parts=2, swaps=1)
    assert told(itinerary, end) == [Next.NEXT_PART]


def test_while_photographs_are_searched_the_uav_lands_and_the_same_part_goes_on():
    itinerary = Itinerary(parts=1, swaps=1)
    assert told(itinerary, "searching", "done") == [Next.WHEN_READY, Next.OVER]
    assert (itinerary.part, itinerary.swapped) == (0, [1])


def test_an_abort_ends_all_parts():
    itinerary = Itinerary(parts=2, swaps=1)
    assert told(itinerary, "aborted") == [Next.OVER]
    assert itinerary.part == 0


def test_without_a_battery_an_empty_one_ends_the_itinerary_and_the_next_part_begins_with_what_is_left():
    assert told(Itinerary(parts=2, swaps=0), "battery") == [Next.OVER]
    itinerary = Itinerary(parts=2, swaps=0)
    assert told(itinerary, "explored", "battery") == [Next.NEXT_PART, Next.OVER]
    assert itinerary.swapped == [0, 0]
    assert not itinerary.take_battery()


@pytest.mark.table("end", ["explored", "battery", "aborted", "done"])
def test_a_uav_that_is_not_home_lands_where_it_is(end):
    assert Itinerary(parts=2, swaps=5).after(end, is_home=False) is Next.LOST


def test_one_part_alone_is_over_when_it_is_done():
    assert told(Itinerary(parts=1, swaps=2), "battery", "battery", "battery") == [
        Next.AGAIN, Next.AGAIN, Next.OVER,
    ]  # fmt: skip
    assert told(Itinerary(parts=1, swaps=2), "done") == [Next.OVER]
