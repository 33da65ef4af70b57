"""Next-best-view exploration: what is worth most for its time comes first, then all room for the UAV.

References: Yamauchi 1997 (frontiers); Gonzalez-Banos and Latombe 2002 (information for the way's cost).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from exploration.next_view.frontiers import KnownBorder
from exploration.next_view.parameters import ExplorerParameters
from exploration.next_view.roadmap import Roadmap
from exploration.next_view.steep import steep_steps
from exploration.next_view.unknown.leftovers import Leftover, Why, leftovers_of, named
from exploration.next_view.views.choice import view_choice
from exploration.next_view.views.revealing import RevealingViews
from exploration.next_view.views.room import RoomViews
from exploration.next_view.views.scene import Scene, sight_of
from exploration.next_view.views.shafts import ShaftViews
from exploration.next_view.views.view import NO_LOOK, Look, View
from exploration.planning.space import Space

PASSING = 0.25
"""What a view from the way counts, as a share of one from its goal."""
NODES_VOXELS_MIN = 2
LAYER_M = 0.2
"""What stays unknown under a ceiling and over a floor is a layer of about this thickness."""


@dataclass(frozen=True)
class Decision:
    """What to do next.

    goal_m: (x, y, z) of the next view in the map's frame; None: nothing is left to see. way_m: to it.
    is_shut_in: the UAV fits nowhere from where it is, so nothing can be said of what is left. column_m:
    (k, 3) the last part of the way, straight up or down through what no beam of the lidar has shown; None:
    there is no such part. gain_m3: what the view would show. is_of_layers: of layers under ceilings and over
    floors, for no border is worth a view any more, and no room is left.
    """

    goal_m: tuple[float, float, float] | None
    way_m: float = 0.0
    is_shut_in: bool = False
    column_m: np.ndarray | None = None
    gain_m3: float = 0.0
    is_of_layers: bool = False


class Explorer:
    """Decides, again and again, which place the UAV flies to.

    Args:
        parameters: see there. is_steep: whether views may lie straight above and below, where only range
            finders see.
    """

    def __init__(self, parameters: ExplorerParameters | None = None, is_steep: bool = False):
        self._p = parameters or ExplorerParameters()
        self._worthy = view_choice(self._p, is_steep)
        has_last = is_steep and not isinstance(self._worthy, RevealingViews)
        self._last = RevealingViews(_of_layers(self._p), is_steep) if has_last else None
        """What shows more when no level view of the border does: views straight above and below."""
        self._last_view: View | None = None
        self._border = KnownBorder()
        self._shafts = ShaftViews() if has_last and self._p.shafts else None
        self._room, self._seeks_room = RoomViews(self._p), False
        self._goal: View | None = None
        """The view that the UAV flies to."""
        self._has_given_up = False
        """That view."""
        self._refused_m: list[np.ndarray] = []
        """Places (x, y, z) of views that CEPA kept the UAV from, and where it has not been since."""
        self._home_m: np.ndarray | None = None
        """Where it decided first."""
        self._looked_m: np.ndarray | None = None
        """Where the last view was that counted."""
        self._known = 0
        """Voxels of the map when what is worth its time was looked for last."""

    @property
    def parameters(self) -> ExplorerParameters:
        """As given."""
        return self._p

    def give_up_goal(self, is_refused: bool = False) -> None:
        """The UAV comes no nearer to its goal: for the next decision it looks from where it is.

        is_refused: CEPA does not let it go there.
        """
        self._has_given_up = True
        if is_refused and self._goal is not None:
            self._refused_m.append(self._goal.place_m)

    def decide(self, space: Space, place_m: np.ndarray) -> Decision:
        """Return what to do from a place (x, y, z).

        What shows enough for its time comes first. Then, if asked for, holes and shafts that no level view
        shows. Then all of the border counts behind which the UAV itself might fit. Then layers under ceilings
        and over floors, to which no level view leads. What is left after that is too small to matter, or no
        view shows it.

        space: what the planner lets the UAV fly through now.
        """
        self._home_m = place_m if self._home_m is None else self._home_m
        roadmap = self._roadmap(space, place_m)
        if not len(roadmap.nodes):
            self._goal = None
            return Decision(None, is_shut_in=True)
        scene, (looked, is_there) = Scene.of(space, self._p, self._border), self._look_from(place_m)
        self._worthy.note(scene, looked)
        present = None if is_there else self._goal
        if self._shafts is not None and is_there and self._goal is not None:
            self._shafts.note(self._goal)
        nodes = roadmap.spread(np.arange(len(roadmap.nodes)))
        sought_room, chosen = self._seeks_room, None
        if self._has_news(space) or is_there:
            goes_on = None if sought_room else present
            chosen = self._worthy.best(scene, roadmap, nodes, place_m, goes_on)
        self._seeks_room = chosen is None
        if chosen is None and self._shafts is not None:
            chosen = self._shafts.best(scene, roadmap)
        if chosen is None:
            since = (looked, self._home_m, present) if sought_room else (NO_LOOK, self._home_m, None)
            chosen = self._room.best(scene, roadmap, nodes, *since)
            if chosen is None and self._last is not None:
                self._last.note(scene, looked)
                goes_on = present if present is self._last_view else None
                chosen = self._last_view = self._last.best(scene, roadmap, nodes, place_m, goes_on)
        self._goal = chosen
        if chosen is None:
            return Decision(None)
        x, y, z = chosen.place_m.tolist()
        return Decision(
            (x, y, z),
            chosen.way_m,
            column_m=chosen.column_m,
            gain_m3=chosen.gain_m3,
            is_of_layers=chosen is self._last_view,
        )

    def left_over(
        self,
        space: Space,
        opened: Space,
        anywhere: Space,
        place_m: np.ndarray,
        ended_early: bool = False,
    ) -> tuple[Leftover, ...]:
        """Return what stays unknown and why, when a decision at a place (x, y, z) has found nothing to see.

        opened: the space without what is closed. anywhere: also far from what tells the lidar its place.
        ended_early: there was more to see, but the time or the battery was over.
        """
        nodes = self._roadmap(space, place_m).nodes
        if not len(nodes):
            return ()
        scene = Scene.of(space, self._p)
        cells = scene.cells(self._p.cell)
        is_left = self._worthy.is_left(scene, cells)
        worth = Why.NOT_YET if ended_early else Why.SMALL
        left = leftovers_of(space, scene.kinds, nodes, cells, is_left, scene.sight, worth)
        refused = [opened.grid.index_of(view_m) for view_m in self._refused_m]
        views = np.array([voxel for voxel in refused if voxel is not None])
        if len(views):  # what was looked at from where CEPA held the UAV, and not from the view itself
            left = named(Why.REFUSED, left, opened, views, sight_of(opened, self._p), (Why.IN_VAIN,))
        for why, wider in ((Why.REFUSED, opened), (Why.FAR, anywhere)):
            if why is Why.FAR and space.far is None:
                continue  # nothing is too far
            nodes = self._roadmap(wider, place_m).nodes
            if len(nodes):
                left = named(why, left, wider, nodes, sight_of(wider, self._p))
        return left

    def places(self, space: Space, place_m: np.ndarray) -> np.ndarray:
        """Return the voxels (n, 3), z, y, x, where a UAV that is at a place (x, y, z) can be."""
        return self._roadmap(space, place_m).nodes

    def steep_steps(self, space: Space, place_m: np.ndarray) -> np.ndarray:
        """Return (n, k, 3) steps straight up or down from a place (x, y, z) of the UAV; see `steep_steps`.

        Ask when no view shows more. The lidar does not see whether a step is free; range finders do.
        """
        roadmap = self._roadmap(space, place_m)
        return steep_steps(space, roadmap, self._p.room_min) if len(roadmap.nodes) else np.zeros((0, 1, 3))

    def _roadmap(self, space: Space, place_m: np.ndarray) -> Roadmap:
        spacing = self._p.way_spacing or self._p.spacing
        return Roadmap(space, place_m, self._voxels(space, spacing, NODES_VOXELS_MIN))

    def _has_news(self, space: Space) -> bool:
        """Whether so much is new since a search for room began that a view may be worth its time again."""
        known = space.grid.known
        if self._seeks_room and abs(known - self._known) < self._worthy.news_voxels(space):
            return False
        self._known = known
        return True

    def _look_from(self, place_m: np.ndarray) -> tuple[Look, bool]:
        """Return what the UAV looks at from a place (x, y, z), and whether that is its goal.

        Nothing if it has hardly moved.
        """
        has_given_up, self._has_given_up = self._has_given_up, False
        goal, spacing_m = self._goal, self._p.spacing
        self._refused_m = [view_m for view_m in self._refused_m if math.dist(place_m, view_m) > spacing_m]
        if goal is not None and (has_given_up or math.dist(place_m, goal.place_m) <= spacing_m):
            self._looked_m = place_m
            return Look((place_m, goal.place_m), 1.0), True
        if self._looked_m is not None and math.dist(place_m, self._looked_m) < spacing_m:
            return NO_LOOK, False
        self._looked_m = place_m
        return Look((place_m,), PASSING), False

    @staticmethod
    def _voxels(space: Space, length_m: float, least: int = 1) -> int:
        return max(least, round(length_m / space.grid.resolution_m))


def _of_layers(p: ExplorerParameters) -> ExplorerParameters:
    """Return parameters by which a volume is worth as much as the border before a layer of it."""
    return replace(p, volume_min=LAYER_M * p.worth_min, volume_rate=LAYER_M * p.rate_min)
