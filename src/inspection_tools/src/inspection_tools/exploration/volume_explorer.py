"""Exploration of places of many small and high rooms: by the unknown volume that views would show.

References: Bircher et al. 2016 (gain by volume); Yamauchi 1997 (frontiers), for what is left of room.
"""

from __future__ import annotations

import math

import numpy as np

from inspection_tools.exploration.explorer import PASSING, Decision, Explorer
from inspection_tools.exploration.frontiers import frontier_voxels, in_cells
from inspection_tools.exploration.leftovers import Leftover, leftovers_of
from inspection_tools.exploration.parameters import ExplorerParameters
from inspection_tools.exploration.roadmap import Roadmap
from inspection_tools.exploration.views.prospect import Prospect, Vain
from inspection_tools.exploration.views.revealing import RevealingViews
from inspection_tools.exploration.views.room import RoomViews
from inspection_tools.exploration.views.view import NO_LOOK, Look, View
from inspection_tools.planning.space import Space


def explorer_of(parameters: ExplorerParameters, is_steep: bool) -> Explorer:
    """Return the explorer that the parameters ask for. is_steep: see `ExplorationParameters`."""
    return VolumeExplorer(parameters, is_steep) if parameters.by_volume else Explorer(parameters)


class VolumeExplorer(Explorer):
    """Weighs what views would show of the unknown, also straight above and below the UAV.

    Args:
        parameters: see there. is_steep: whether the UAV may climb and sink into what only range finders see.
    """

    def __init__(self, parameters: ExplorerParameters, is_steep: bool) -> None:
        super().__init__(parameters)
        self._is_steep, self._vain = is_steep, Vain()
        self._revealing, self._room = RevealingViews(self._p), RoomViews(self._p)
        self._goal: View | None = None
        """The view that it flies to."""
        self._home_m: np.ndarray | None = None
        """Where it decided first."""

    def decide(self, space: Space, place_m: np.ndarray) -> Decision:
        """Return what to do from a place (x, y, z).

        What reveals enough for its time comes first. Then all of the border counts behind which the UAV
        itself might fit. What is left after that is too small to matter, or no view shows it.

        space: what the planner lets the UAV fly through now.
        """
        self._home_m = place_m if self._home_m is None else self._home_m
        roadmap = self._roadmap(space, place_m)
        if not len(roadmap.nodes):
            self._goal = None
            return Decision(None, is_shut_in=True)
        looked, is_there = self._look_from(place_m)
        prospect = self._prospect(space)
        for at in filter(None, map(space.grid.index_of, looked.places_m)):
            prospect.note(np.array(at), looked.counts)
        present = None if is_there else self._goal
        nodes, sought_room, chosen = self._views(space, roadmap), self._seeks_room, None
        if self._has_volume_news(space) or is_there:
            goes_on = None if sought_room else present
            chosen = self._revealing.best(space, prospect, roadmap, nodes, place_m, self._is_steep, goes_on)
        self._seeks_room = chosen is None
        border = frontier_voxels(np.pad(space.grid.kinds, 1))
        if chosen is None:
            since = (looked, self._home_m, present) if sought_room else (NO_LOOK, self._home_m, None)
            chosen = self._room.best(space, border, roadmap, nodes, *since)
        self._goal = chosen
        if chosen is None:
            return Decision(None, leftovers=self._left_over(space, border, roadmap, prospect))
        x, y, z = chosen.place_m.tolist()
        return Decision((x, y, z), chosen.way_m, column_m=chosen.column_m)

    def _prospect(self, space: Space) -> Prospect:
        p = self._p
        return Prospect(space, (p.elevation_min, p.elevation_max), (p.near, p.reach), self._vain)

    def _left_over(
        self, space: Space, border: np.ndarray, roadmap: Roadmap, prospect: Prospect
    ) -> tuple[Leftover, ...]:
        kinds, side = np.pad(space.grid.kinds, 1), self._voxels(space, self._p.cell)
        cells = in_cells(border, side, space.grid.corner[::-1] - 1)
        is_left = prospect.is_vain(cells.places - 1)
        return leftovers_of(space, kinds, roadmap.nodes, cells, is_left, self._sight(space))

    def _has_volume_news(self, space: Space) -> bool:
        """Whether so much is new since a search for room began that a view may be worth its time again."""
        known = int(np.count_nonzero(space.grid.kinds))
        new_m3 = abs(known - self._known) * space.grid.resolution_m**3
        if self._seeks_room and new_m3 < self._p.volume_min:
            return False
        self._known = known
        return True

    def _look_from(self, place_m: np.ndarray) -> tuple[Look, bool]:
        """Return what the UAV looks at from a place (x, y, z), and whether that is its goal.

        Nothing if it has hardly moved.
        """
        has_given_up, self._has_given_up = self._has_given_up, False
        goal, spacing_m = self._goal, self._p.spacing
        if goal is not None and (has_given_up or math.dist(place_m, goal.place_m) <= spacing_m):
            self._looked_m = place_m
            return Look((place_m, goal.place_m), 1.0), True
        if self._looked_m is not None and math.dist(place_m, self._looked_m) < spacing_m:
            return NO_LOOK, False
        self._looked_m = place_m
        return Look((place_m,), PASSING), False
