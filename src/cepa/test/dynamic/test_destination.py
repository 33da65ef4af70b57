"""A reference that leads to a place ends there; one that holds a course does not."""

import math

import numpy as np
import pytest
from planar_flight import Scene, Uav, fly, to_goal

from cepa import Dynamic
from cepa.dynamic.destination import Destination

GOAL_M = np.array([3.0, 1.0])


def told(places_m, reference):
    """Return what the references (x, y) at some places tell, and the last of them."""
    destination = Destination()
    for place in places_m:
        destination.update(place, reference(place))
    return destination.gain_1_s, np.array(reference(places_m[-1]))


def line(start, end):
    """Return places every 5 cm."""
    count = round(math.dist(start, end) / 0.05)
    return np.linspace(start, end, count)


@pytest.mark.table("start", [(2.0, 0.0), (3.0, 2.0), (4.0, -1.0)])
def test_a_reference_in_proportion_to_the_distance_ends_at_the_goal(start):
    gain, reference = told(line(start, (2.6, 0.7)), lambda place: 1.25 * (GOAL_M - place))
    assert gain == pytest.approx(1.25)
    np.testing.assert_allclose((2.6, 0.7) + reference / gain, GOAL_M)


def test_a_reference_of_constant_speed_shows_its_end_to_who_passes_it():
    def pointing(place):
        return 2.0 * (GOAL_M - place) / math.dist(GOAL_M, place)

    gain, reference = told(line((2.0, 0.8), (2.0, 1.2)), pointing)  # across
    assert 0.8 < math.hypot(*reference) / gain / math.dist((2.0, 1.2), GOAL_M) < 1.3
    gain, _ = told(line((0.0, 0.0), 0.5 * GOAL_M), pointing)  # straight on
    assert gain == pytest.approx(0.0, abs=1e-9)


def test_a_reference_that_brakes_evenly_ends_before_it_seems_to():
    def braking(place):
        way = GOAL_M - place
        return math.sqrt(2.0 * math.hypot(*way)) * way / math.hypot(*way)  # 1 m/s2

    here = 0.5 * GOAL_M
    gain, reference = told(line((0.0, 0.0), here), braking)
    assert 1.0 < math.hypot(*reference) / gain / math.dist(here, GOAL_M) < 2.6


@pytest.mark.table("course", ["constant", "faster", "winding"])
def test_a_course_has_no_end(course):
    rng = np.random.default_rng(1)
    references = {
        "constant": lambda place: (2.0, 0.0),
        "faster": lambda place: (1.0 + place[0], 0.0),
        "winding": lambda place: 1.0 + 0.5 * rng.standard_normal(2),
    }
    gain, _ = told(line((0.0, 0.0), (5.0, 0.5)), references[course])
    assert gain == 0.0


def test_it_forgets_the_end_of_an_earlier_reference():
    destination = Destination()
    for place in line((0.0, 0.0), (2.5, 0.9)):
        destination.update(place, 1.25 * (GOAL_M - place))
    for place in line((2.5, 0.9), (2.5, 2.9)):
        destination.update(place, (0.0, 2.0))
    assert destination.gain_1_s == 0.0


@pytest.mark.table("goal", [(4.0, 0.0), (4.4, 0.3), (7.0, 0.0)])
def test_it_flies_to_a_goal_near_a_trunk_without_circling(goal):
    scene = Scene(circles=np.array([(5.4, 0.0, 0.4)]))
    flight = fly(Dynamic(), scene, to_goal(goal), Uav(), np.random.default_rng(1), time_limit_s=20.0)
    assert flight.reached
    assert not flight.contact
    path = np.array(flight.path)
    assert np.hypot(*np.diff(path, axis=0).T).sum() < 1.3 * math.hypot(*goal)
