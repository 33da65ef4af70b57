"""How the next best view is chosen is named by a parameter, and may be a class of one's own."""

import pytest
from voxel_room import Flight, beams, room

from exploration.next_view import Explorer, ExplorerParameters
from exploration.next_view.views.border import BorderViews
from exploration.next_view.views.choice import VIEW_CHOICES
from exploration.planning import UNKNOWN
from flight_basics.errors import ParameterError


class NearestViews(BorderViews):
    """Takes the nearest place that shows any border (Yamauchi, 1997)."""

    def best(self, scene, roadmap, nodes, here_m, present):
        for node in sorted(nodes, key=lambda node: roadmap.ways_m[node]):
            view = super().best(scene, roadmap, nodes[nodes == node], here_m, None)
            if view is not None:
                return view
        return None


def test_a_way_of_one_s_own_is_one_class_and_one_entry(monkeypatch):
    monkeypatch.setitem(VIEW_CHOICES, "nearest", lambda parameters, is_steep: NearestViews(parameters))
    wall = [((3.0, 0.0, 0.0), (3.2, 2.0, 2.4)), ((3.0, 3.2, 0.0), (3.2, 4.6, 2.4))]
    ways_m = {}
    for name in ("nearest", "border"):
        flight = Flight(room((6.2, 4.6, 2.4), wall), (1.3, 1.3, 1.2), beams(around=120))
        flight.explore(Explorer(ExplorerParameters(spacing=0.4, reach=8.0, view_choice=name)))
        assert (flight.kinds[~flight.filled] != UNKNOWN).mean() > 0.99, name
        ways_m[name] = flight.way_m
    assert ways_m["nearest"] != ways_m["border"]


@pytest.mark.table("name", ["frontier", "", 3, None])
def test_a_way_that_there_is_not_is_refused_with_those_that_there_are(name, monkeypatch):
    monkeypatch.setitem(VIEW_CHOICES, "nearest", lambda parameters, is_steep: NearestViews(parameters))
    for other in VIEW_CHOICES.keys() - {"border", "nearest", "volume"}:
        monkeypatch.delitem(VIEW_CHOICES, other)
    sentence = rf"view_choice is '{name}'; it must be one of border, nearest, volume\."
    with pytest.raises(ParameterError, match=sentence):
        Explorer(ExplorerParameters(view_choice=name))
