"""What is left of a path."""

import numpy as np
import pytest

from exploration.planning.progress import place_ahead, rest_of

PATH = np.array([(0.0, 0.0, 1.0), (4.0, 0.0, 1.0), (4.0, 3.0, 1.0)])


@pytest.mark.table(
    ("here", "rest", "away_m"),
    [
        ((1.0, 0.5, 1.0), [(4.0, 0.0, 1.0), (4.0, 3.0, 1.0)], 0.5),
        ((4.0, 0.0, 1.0), [(4.0, 3.0, 1.0)], 0.0),  # at the corner, the next leg counts
        ((4.0, 9.0, 1.0), [(4.0, 3.0, 1.0)], 6.0),
        ((-3.0, 0.0, 5.0), [(4.0, 0.0, 1.0), (4.0, 3.0, 1.0)], 5.0),
    ],
)
def test_the_rest_begins_here(here, rest, away_m):
    found, off_m = rest_of(PATH, np.array(here))
    assert found.tolist() == [list(here), *map(list, rest)]
    assert off_m == pytest.approx(away_m)


def test_a_path_without_length_is_reached():
    rest, off_m = rest_of(PATH[[0, 0]], PATH[0])
    assert (rest == PATH[0]).all()
    assert off_m == 0.0


@pytest.mark.table(
    ("way_m", "place"), [(1.0, (1.0, 0.0, 1.0)), (5.5, (4.0, 1.5, 1.0)), (50.0, (4.0, 3.0, 1.0))]
)
def test_a_place_ahead_is_on_the_path(way_m, place):
    assert place_ahead(PATH, way_m) == pytest.approx(place)
