"""How a UAV is led along its ways, and past places where CEPA holds it up."""

from __future__ import annotations

import math
import threading

import numpy as np

from exploration.next_view.parameters import ExplorationParameters
from exploration.next_view.steps import in_steps
from exploration.next_view.upright import upright
from exploration.next_view.way import Progress, Way
from exploration.planning import PathPlanner
from flight_basics.errors import NoPathError

SLOW_SHARE, STEP_M = 0.4, 0.6
"""After this share of the patience, a UAV that comes no nearer flies by short steps: CEPA lets it pass a
narrow place slowly that it keeps a fast one out of."""
SLOW_S, SLOW_M = 10.0, 1.5
"""It does so for so long, and so far from where it was held up."""


class Guide:
    """Sets the ways that a UAV flies, and notices when it comes no nearer to their end.

    `follow` and `setpoint_m` may be called while another thread sets out.

    Args:
        planner: knows the map. parameters: see there. slopes: of the lidar's lowest and highest beam.

    Attributes:
        is_paused: it hovers by `pause`.
    """

    def __init__(
        self, planner: PathPlanner, parameters: ExplorationParameters, slopes: tuple[float, float]
    ) -> None:
        self._planner, self._p, self._slopes = planner, parameters, slopes
        self._way, self._progress = Way(), Progress()
        self._hovers_s: float | None = None
        """Since when it has been at the end of its way; None: it is on the way."""
        self._slow_until_s, self._slow_m = -math.inf, np.zeros(3)
        """Until when it flies slowly, and around which place (x, y, z)."""
        self._lock = threading.Lock()  # of the way and of the pause
        self.is_paused = False

    def begin(self, place_m: np.ndarray) -> None:
        """Fly to a first place (x, y, z); a pause ends."""
        self.is_paused, self._way = False, Way([place_m])

    def pause(self, here_m: np.ndarray) -> None:
        """Hover at a place (x, y, z) until `resume`."""
        with self._lock:
            self.is_paused, self._way = True, Way([here_m])

    def resume(self) -> None:
        """Go on after a pause."""
        with self._lock:
            self.is_paused = False

    def stop(self) -> None:
        """Drop the way, unless it is paused."""
        with self._lock:
            if not self.is_paused:
                self._way = Way()

    def set_out(self, way: Way) -> None:
        """Take another way, unless it is paused."""
        with self._lock:
            if not self.is_paused:
                self._way, self._hovers_s = way, None

    def hover(self, here_m: np.ndarray) -> None:
        """Stay at a place (x, y, z)."""
        self.set_out(Way([here_m]))

    @property
    def way(self) -> Way:
        """That it flies now."""
        return self._way

    def follow(self, stamp_s: float, here_m: np.ndarray) -> None:
        """Take a pose (x, y, z)."""
        self._way.follow(stamp_s, here_m, self._p.arrived)
        self._progress.note(stamp_s, here_m, self._way.rest_m)
        if self._way.is_left:
            self._hovers_s = None
        elif self._hovers_s is None:
            self._hovers_s = stamp_s

    def has_swept(self, stamp_s: float) -> bool:
        """Whether it has hovered as long as the lidar needs to see all around."""
        return self._hovers_s is not None and stamp_s >= self._hovers_s + self._p.sweep

    def is_held_off(self, stamp_s: float) -> bool:
        """Whether it has come no nearer for as long as the patience lasts."""
        return self._progress.is_held_off(stamp_s, self._p.patience)

    def forgive(self) -> None:
        """Give what follows its own time, at full speed: it is another way."""
        self._progress, self._slow_until_s = Progress(), -math.inf

    def plan(self, here_m: np.ndarray, goal_m: np.ndarray, stamp_s: float) -> bool:
        """Set out for a goal (x, y, z); return whether there is a way."""
        try:
            places_m = list(self._planner.plan(here_m, goal_m, stamp_s).points_m)
        except NoPathError:
            return False
        space = self._planner.space(stamp_s, here_m)
        if self._p.steep:  # else no range finder sees what is straight above or below
            places_m = upright(places_m, self._slopes, space.cost_m)
        if self._is_slow(stamp_s, here_m):
            self.set_out(Way(in_steps(places_m, STEP_M)[1:]))
            return True
        way = Way(places_m[1:], space.cost_whatever_climb_m, self._p.ahead, self._p.climbs_first, here_m)
        self.set_out(way)
        return True

    def mind_the_pace(self, stamp_s: float, here_m: np.ndarray, rest_m: list[np.ndarray]) -> bool:
        """Go on slowly where CEPA holds the UAV (x, y, z) up, and fast again behind that.

        rest_m: the places of its way that are still to come. Return whether there is still a way.
        """
        was_slow = math.isfinite(self._slow_until_s)
        if self._is_slow(stamp_s, here_m):
            return True
        self._slow_until_s = -math.inf
        if self._progress.is_held_off(stamp_s, SLOW_SHARE * self._p.patience):
            self._slow_until_s, self._slow_m = stamp_s + SLOW_S, here_m
            self.set_out(Way(in_steps([here_m, *rest_m], STEP_M)[1:]))
        elif was_slow:
            return self.plan(here_m, rest_m[-1], stamp_s)
        return True

    def _is_slow(self, stamp_s: float, here_m: np.ndarray) -> bool:
        return stamp_s < self._slow_until_s and math.dist(here_m, self._slow_m) < SLOW_M
