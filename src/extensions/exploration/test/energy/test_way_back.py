"""The way that a UAV came, as its way back."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from exploration.energy import WayBack, without_loops
from exploration.next_view import ExplorationParameters
from exploration.planning import PathPlanner

COORDINATES = st.integers(-4, 4)


def test_a_loop_is_left_out():
    # Given a way out along x, a square, and on along x
    out = [(0, 0), (1, 0), (2, 0)]
    square = [(2, 1), (2, 2), (1, 2), (1, 1), (1.9, 0.05)]
    on = [(3, 0), (4, 0)]
    places = [np.array((x, y, 1.0)) for x, y in (*out, *square, *on)]
    # Then the way goes straight on where the square comes back
    expected = [(0, 0), (1, 0), (2, 0), (1.9, 0.05), (3, 0), (4, 0)]
    assert [tuple(place[:2]) for place in without_loops(places, 0.2)] == expected
    assert without_loops([], 0.2) == []


@given(st.lists(st.tuples(COORDINATES, COORDINATES, COORDINATES), min_size=1, max_size=30))
def test_each_step_was_flown_or_is_within_reach_and_no_place_comes_twice(cells):
    places = [0.5 * np.array(cell) for cell in cells]
    kept = without_loops(places, 0.5)
    steps = {(a, b) for a, b in zip(cells, cells[1:])}
    kept_cells = [tuple((2 * place).astype(int).tolist()) for place in kept]
    assert kept_cells[0] == cells[0]
    assert kept_cells[-1] == cells[-1]
    for a, b in zip(kept_cells, kept_cells[1:]):
        assert (a, b) in steps or np.linalg.norm(np.subtract(a, b)) <= 1.0
    apart = [np.linalg.norm(np.subtract(a, b)) for k, a in enumerate(kept_cells) for b in kept_cells[k + 2 :]]
    assert all(each > 1.0 for each in apart)


def lands_after_s(off_m):
    """When a UAV may land that is so far (s,) from its home at each tenth of a second; None: never."""
    back = WayBack(PathPlanner(), None, ExplorationParameters(arrived=0.3))
    back.begin(np.zeros(3))
    for step, off in enumerate(off_m):
        if back.may_land(0.1 * step, np.array((off, 0.0, 0.0))):
            return 0.1 * step
    return None


def test_a_uav_lands_when_it_stays_over_its_home_or_is_held_off_near_it():
    passing = np.abs(np.arange(-1.0, 1.0, 0.07))
    assert lands_after_s(passing) is None  # at 0.7 m/s, 0.4 s within 0.15 m
    comes_back = np.concatenate((passing[:17], np.full(20, 0.1)))
    assert lands_after_s(comes_back) == pytest.approx(2.3, abs=0.25)
    assert lands_after_s(np.full(100, 0.5)) == pytest.approx(6.0, abs=0.1)
    assert lands_after_s(np.full(100, 0.7)) is None
