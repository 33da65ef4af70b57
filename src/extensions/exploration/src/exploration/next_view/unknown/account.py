"""Tells once what stays unknown and why: when nothing more is to be seen, or the UAV has turned home."""

from __future__ import annotations

from typing import Mapping

import numpy as np

from exploration.next_view.explorer import Explorer
from exploration.next_view.outcome import Explored
from exploration.next_view.unknown.leftovers import Why, behind_openings
from exploration.next_view.unknown.openings import narrow_openings
from exploration.planning import PathPlanner

TRIES = 3
"""A way that CEPA refused so often is left, when nothing else is to be seen."""


class UnknownAccount:
    """What stays unknown.

    Args:
        smaller: radii of other UAVs by name, m. One that fits through an opening is named.
    """

    def __init__(self, planner: PathPlanner, explorer: Explorer, smaller: Mapping[str, float]) -> None:
        self._planner, self._explorer, self._smaller = planner, explorer, smaller
        self._explored_at: tuple[float, np.ndarray] | None = None
        """When and where it found nothing more to see or turned home, until that is told."""

    def begin(self) -> None:
        """Nothing is to be told yet."""
        self._explored_at = None

    def ask(self, stamp_s: float, here_m: np.ndarray) -> None:
        """Let `add_to` tell what stays unknown from a place (x, y, z), by what is known at a time."""
        self._explored_at = stamp_s, here_m

    def add_to(self, explored: Explored, ended_early: bool) -> None:
        """Add what stays unknown to the outcome, once. It takes as long as a decision.

        ended_early: there was more to see, but the time or the battery was over.
        """
        if self._explored_at is None:
            return
        (stamp_s, place_m), self._explored_at = self._explored_at, None
        space, opened, anywhere = (
            self._planner.space(stamp_s, place_m, *wider)
            for wider in ((True, True), (False, True), (False, False))
        )
        leftovers = self._explorer.left_over(space, opened, anywhere, place_m, ended_early=ended_early)
        nodes = self._explorer.places(space, place_m)
        behind = narrow_openings(opened, nodes, self._planner.parameters, self._smaller)
        explored.leftovers = behind_openings(leftovers, behind, opened)
        if behind.openings:
            named = "; ".join(map(str, behind.openings))
            explored.reason += f" What lies behind a narrow opening stays unknown: {named}."
        if self._planner.unseen:
            named = "; ".join(str(box) for box in self._planner.unseen)
            explored.reason += f" The UAV flew no farther there: {named}."
        if explored.left_m2(Why.REFUSED) > 0.0:
            explored.reason += f" CEPA refused {TRIES} times to fly to more."
