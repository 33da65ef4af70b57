"""An exploration ends when its last views show next to nothing. The volumes are counted by hand."""

import math

import numpy as np
from voxel_room import Flight, next_places, room

from exploration.next_view import End, Exploration, ExplorationParameters, Explorer
from exploration.next_view.explorer import Decision
from exploration.next_view.last_views import LastViews
from exploration.planning import FREE, OCCUPIED

BORDER, STEEP = Decision((1.0, 0.0, 1.0), 3.0, gain_m3=0.1), Decision(None)


def layers(gain_m3=0.1):
    return Decision((1.0, 0.0, 1.0), 3.0, gain_m3=gain_m3, is_of_layers=True)


def ends_s(decisions):
    """Return the time of the first of (time in s, known m3, decision) that is not worth it, or None."""
    views = LastViews()
    return next((at for at, known, each in decisions if views.too_little_gain(at, known, each)), None)


def test_after_30_s_with_less_than_a_thousandth_of_what_is_known_it_ends():
    """Of 400 m3 that are known, 0.4 m3 matter: 0.012 m3 a second are less, 0.015 m3 are more."""
    slow = [(float(s), 400.0 + 0.012 * s, layers()) for s in range(0, 120, 2)]
    assert ends_s(slow) == 30.0
    fast = [(float(s), 400.0 + 0.015 * s, layers()) for s in range(0, 120, 2)]
    assert ends_s(fast) is None


def test_a_view_that_shows_more_and_border_and_room_are_flown_to_however_far_they_are():
    assert ends_s([(float(s), 400.0, layers(0.41)) for s in range(0, 120, 2)]) is None
    assert ends_s([(float(s), 400.0, BORDER) for s in range(0, 120, 2)]) is None
    assert ends_s([(float(s), 400.0, BORDER if s == 40 else layers()) for s in range(20, 120, 2)]) == 72.0


def test_a_step_up_or_down_neither_ends_it_nor_counts_as_more():
    assert ends_s([(float(s), 400.0, STEEP) for s in range(0, 120, 2)]) is None
    assert ends_s([(float(s), 400.0, layers() if s > 20 else STEEP) for s in range(0, 120, 2)]) == 30.0


class AlwaysALayer(Explorer):
    """Finds one more view of a layer for ever, at one of two places in turn."""

    def decide(self, space, place_m):
        far_m = max((1.3, 1.3, 1.2), (3.7, 2.3, 1.2), key=lambda each: math.dist(each, place_m))
        return Decision(far_m, 2.6, gain_m3=0.01, is_of_layers=True)


def test_an_exploration_whose_last_views_show_nothing_comes_home_and_says_so():
    flight = Flight(room((5.0, 4.0, 2.4)), (1.3, 1.3, 1.2))
    flight.kinds = np.where(flight.filled, OCCUPIED, FREE).astype(np.uint8)  # all is known
    flight.look()
    exploration = Exploration(flight.planner, AlwaysALayer(), ExplorationParameters(time_max=200.0))
    exploration.begin(0.0, flight.place_m)
    for place_m in next_places(exploration, flight, step_m=0.4):
        flight.place_m = place_m
    assert exploration.explored.end is End.EXPLORED
    assert "both are less than 0.1% of the" in exploration.explored.reason
    assert exploration.explored.ended_s < 60.0
