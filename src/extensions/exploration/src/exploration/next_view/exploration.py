"""An exploration from the first view to the landing place: which way the UAV flies now, and when it ends.

Whoever flies the UAV gives its poses and the map, and gets setpoints: the closed loop without ROS, and the
node `explore`.
"""

from __future__ import annotations

import math
import time
from contextlib import suppress
from dataclasses import replace
from typing import Mapping

import numpy as np

from exploration.energy import EnergyWatch, Verdict, WayBack, WayHome
from exploration.next_view.explorer import Decision, Explorer
from exploration.next_view.guide import Guide
from exploration.next_view.last_views import LastViews
from exploration.next_view.outcome import End, Explored
from exploration.next_view.parameters import ExplorationParameters
from exploration.next_view.steep import SteepSteps
from exploration.next_view.unknown.account import TRIES, UnknownAccount
from exploration.next_view.way import Stay, Way
from exploration.planning import PathPlanner
from flight_basics.errors import MapError, NoPathError
from flight_basics.pose.trust import Trust

BACK_S = 15.0
"""A UAV that fits nowhere flies back the way it came for so long, before that ends the exploration."""
BEEN_M = 0.05
"""Between the places where the UAV was, around which its own radius is free."""
RISEN_M = 0.15
"""A UAV that has risen so far has taken off."""
HELD_OFF = 5.0
"""A UAV that CEPA keeps from its home lands so many times `arrived` away from it at most."""
LONGER, LONGER_S = 1.3, 8.0
"""A way home that takes so many times as long as told, and so much more, is told anew. The energy allows for
as much."""
FIRST_WAY_S = 10.0
"""CEPA may hold the UAV above the first place. After this time it explores from where it is."""


class Exploration:
    """Leads a UAV from view to view, and home.

    Call `follow` with every pose and fly to `setpoint_m`. When `follow` says so, let the planner know what
    has changed on the map, and call `look`. `follow` takes microseconds, `look` up to a second. Another
    thread may call it; only `follow` and `setpoint_m` may be called meanwhile.

    Args:
        planner: knows the map. explorer: chooses the views. parameters: see there.
        energy: watches the battery; None: the battery does not count.
        smaller: radii of other UAVs by name, m. One that fits through an opening is named.

    Attributes:
        explored: what it did so far. is_home: it has ended, and the UAV is where it may land.
        must_land: the energy does not take the UAV home, or CEPA holds it, so it must land where it is.
    """

    def __init__(
        self,
        planner: PathPlanner,
        explorer: Explorer,
        parameters: ExplorationParameters | None = None,
        energy: EnergyWatch | None = None,
        smaller: Mapping[str, float] | None = None,
    ) -> None:
        self._planner, self._explorer = planner, explorer
        self._p = self._given = parameters or ExplorationParameters()
        self._back = WayBack(planner, energy, self._p)
        self._steep = SteepSteps(planner, explorer.steep_steps, explorer.parameters.spacing)
        self._began_s, self._look_s = math.nan, -math.inf
        self._last_views = LastViews()
        self._guide, self._stay = Guide(planner, self._p, explorer.parameters.slopes), Stay()
        self._been_m: list[np.ndarray] = []
        """Since the last look."""
        self._is_held_off = False
        """By CEPA, at this look."""
        self._is_by_track = False
        """It comes home the way it came, for the planner knows none: each place of that way counts."""
        self.is_home = self.must_land = self._is_in_doubt = False
        self._shut_in_s: float | None = None
        """Since when; None: it is not."""
        self._unknown = UnknownAccount(planner, explorer, smaller or {})
        self._turned_home = False
        """For want of time or energy."""
        self._told: tuple[float, float] | None = None
        """When the way home was told last, and how long it took then, s; None: it was not."""
        self.explored = Explored()

    def begin(
        self,
        stamp_s: float,
        here_m: np.ndarray,
        home_m: np.ndarray | None = None,
        time_max_s: float | None = None,
    ) -> None:
        """Begin at a hover (x, y, z) in the map's frame, or go on. Home is the place below the first one.

        home_m: home of an exploration that was lost in flight, which this one goes on with. time_max_s: after
        it the UAV comes home; None: the parameter's.

        Raises:
            ParameterError: the time makes no sense.
        """
        self._p = self._given if time_max_s is None else replace(self._given, time_max=time_max_s)
        self._began_s, self.is_home, self.must_land, self._is_by_track = stamp_s, False, False, False
        is_first = not self.has_begun
        self._back.begin(self._home_below(here_m) if home_m is None else home_m)
        if is_first:
            hover_z_m = here_m[2] if home_m is None else home_m[2] + self._p.first_sink
            self._planner.lower_ceiling(hover_z_m + self._p.climb_max)
        self.explored.end, self.explored.reason = None, ""
        self._unknown.begin()
        self.explored.leftovers, self._turned_home = (), False
        self._last_views = LastViews()
        self._guide.begin(self.home_m if home_m is None else here_m)
        self._stay = Stay()

    def _home_below(self, here_m: np.ndarray) -> np.ndarray:
        """Return the home of a first hover (x, y, z). In a low room it is not below the climb's middle."""
        lowest_m = min(place_m[2] for place_m in (*self._been_m, here_m))
        sink_m, risen_m = self._p.first_sink, here_m[2] - lowest_m
        if risen_m > RISEN_M:  # else it did not see itself take off
            sink_m = min(sink_m, risen_m / 2.0)
        home_m: np.ndarray = here_m - (0.0, 0.0, sink_m)
        return home_m

    def pause(self, here_m: np.ndarray) -> None:
        """Hover at a place (x, y, z) until `resume`, `abort`, or the energy begins to say: come home."""
        self._guide.pause(here_m)

    def resume(self) -> None:
        """Go on after a pause."""
        self._guide.resume()
        self._look_s, self._stay = -math.inf, Stay()

    def trust(self, trust: Trust, why: str, here_m: np.ndarray) -> None:
        """Take what the pose (x, y, z) is good for, with each pose. why: it is not sure.

        A UAV that is lost hovers; if that lasts, it comes home. On its way home it flies on.
        """
        was_in_doubt, self._is_in_doubt = self._is_in_doubt, trust >= Trust.HOVER
        if trust is Trust.COME_HOME:
            self._end(End.ABORTED, f"{why} That lasted too long.")
        elif self.explored.end is None and self._is_in_doubt and not was_in_doubt:
            self._guide.hover(here_m)
        elif was_in_doubt and not self._is_in_doubt:
            self._look_s = -math.inf

    def abort(self, reason: str) -> None:
        """Come home, unless it does already; a pause ends."""
        self.resume()
        self._end(End.ABORTED, reason)

    def strand(self, why: str) -> None:
        """Land here: the UAV cannot come home."""
        if not self.must_land:
            self._end(End.ABORTED, why)
            self._must_land_instead_of_home(End.CUT_OFF, "" if why in self.explored.reason else why)

    @property
    def is_paused(self) -> bool:
        """Whether it hovers by `pause`."""
        return self._guide.is_paused

    @property
    def is_in_doubt(self) -> bool:
        """Whether it hovers because the pose is not sure."""
        return self._is_in_doubt and self.explored.end is None

    @property
    def way_home(self) -> WayHome | None:
        """Length and time of the way home, as it was planned last; None: none is known."""
        return self._back.way

    @property
    def home_way_m(self) -> np.ndarray | None:
        """The way home (n, 3), as it was planned last; None: none is known."""
        return self._back.way_m

    @property
    def home_m(self) -> np.ndarray:
        """The place (x, y, z) that it comes home to."""
        assert self._back.home_m is not None, "begin first"
        return self._back.home_m

    @property
    def has_begun(self) -> bool:
        """Whether `begin` was called."""
        return self._back.home_m is not None

    @property
    def setpoint_m(self) -> np.ndarray | None:
        """Where to fly now, (x, y, z) in the map's frame; None: nowhere yet."""
        return self._guide.way.setpoint_m

    @property
    def rest_m(self) -> list[np.ndarray]:
        """The places of the way that are still to come."""
        return self._guide.way.rest_m

    def follow(self, stamp_s: float, here_m: np.ndarray) -> bool:
        """Take a pose (x, y, z), also before the begin. Return whether it is time to `look`."""
        been_m = self._been_m  # `look` may begin another list meanwhile
        if not been_m or math.dist(here_m, been_m[-1]) > BEEN_M:
            been_m.append(here_m)
        if not self.has_begun:
            return False
        self._back.note(here_m)
        self._guide.follow(stamp_s, here_m)
        is_at_view = not self._guide.way.is_left and not self._must_sweep(stamp_s)
        pause_s = self._p.rest if is_at_view else self._p.look_period
        return not self.is_home and stamp_s >= self._look_s + pause_s

    def look(self, stamp_s: float, here_m: np.ndarray) -> None:
        """Check the way at a pose (x, y, z), and decide anew if it is time to."""
        self._look_s = stamp_s
        been_m, self._been_m = self._been_m, []
        for place_m in (*been_m, here_m):
            with suppress(MapError):  # no map reaches so far
                self._planner.assume_free(place_m, self._planner.parameters.radius)
            self._steep.note(place_m)
        way = self._guide.way
        self._back.note_pace(stamp_s, here_m, way.rest_m if way.is_left else ())
        self.mind(stamp_s, here_m)
        if self.is_in_doubt:
            if self._guide.way.is_left:  # the look before had set out meanwhile
                self._guide.hover(here_m)
            return
        self._is_held_off = self._guide.is_held_off(stamp_s)
        if not self._planner.has_map:
            self._wait_for_map(stamp_s, here_m)
            return
        # Of the decision before: the UAV is on its way home, and nobody waits for it.
        self._unknown.add_to(self.explored, self._turned_home)
        if self._goes_on(stamp_s, here_m):
            return
        if not self._must_sweep(stamp_s):
            self._decide(stamp_s, here_m)
        elif self._guide.way.is_left:
            self._guide.hover(here_m)

    def _wait_for_map(self, stamp_s: float, here_m: np.ndarray) -> None:
        """Hover until a cloud has come. Come home the way it came if that lasts too long."""
        if self.explored.end is not None and not self.is_paused:
            self._go_home(stamp_s, here_m)

    def mind(self, stamp_s: float, here_m: np.ndarray) -> None:
        """End if the energy or the time says so. here_m: where the UAV was last, (x, y, z)."""
        self._mind_the_energy(stamp_s, here_m)
        if stamp_s - self._began_s > self._p.time_max:
            self._end(End.TIME, f"The time of {self._p.time_max:g} s is over.")

    def _must_sweep(self, stamp_s: float) -> bool:
        """Return whether the lidar needs more time to see all around, before the next view is decided."""
        if self._p.sweep == 0.0 or self.explored.end is not None:
            return False
        return not self._guide.has_swept(stamp_s)

    def _mind_the_energy(self, stamp_s: float, here_m: np.ndarray) -> None:
        decision = self._back.decide(stamp_s, here_m)
        if decision is None:
            return
        self._tell_longer_way(stamp_s)
        if decision.verdict is Verdict.LAND and not self.must_land:
            self._must_land_instead_of_home(End.BATTERY, decision.reason)
        if decision.verdict is not Verdict.GO_ON:
            self._end(End.BATTERY, decision.reason)
            if self._back.turns_low(decision):
                self.resume()

    def _tell_longer_way(self, stamp_s: float) -> None:
        """Tell anew how long the way home takes, if it has become longer: as behind a hatch that closes."""
        way = self._back.way
        if self.explored.end is None or way is None:
            self._told = None
            return
        if self._told is None:
            self._told = stamp_s, way.time_s
        told_s, before_s = self._told
        if stamp_s - told_s + way.time_s > LONGER * before_s + LONGER_S:
            self.explored.reason += (
                f" The way home has become longer: {way.time_s:.0f} s are left. {before_s:.0f} s were told "
                f"{stamp_s - told_s:.0f} s before."
            )
            self._told = stamp_s, way.time_s

    def _must_land_instead_of_home(self, end: End, reason: str) -> None:
        """Land where it is. Who has explored and does not come home has another end."""
        self.must_land = True
        if self.explored.end is End.EXPLORED:
            self.explored.end = end
        if self.explored.end is not None:
            self.explored.reason = f"{self.explored.reason} {reason}".rstrip()

    def _end(self, end: End, reason: str) -> None:
        """Come home, unless it does already. If it is paused, then after the pause."""
        if self.explored.end is None:
            self.explored.end, self.explored.reason = end, reason
            self.explored.way_home, self.explored.way_home_charge = self._back.way, self._back.way_charge
            self._guide.stop()
            self._look_s = -math.inf

    def _goes_on(self, stamp_s: float, here_m: np.ndarray) -> bool:
        """Return whether the UAV keeps to its way, without a decision."""
        if self.is_paused:
            return True
        rest_m = self._guide.way.rest_m
        if not rest_m:
            return False
        if not self.explored.views and self.explored.end is None:  # on the first way down, which no beam saw
            is_young = stamp_s < self._began_s + FIRST_WAY_S
            return is_young and math.dist(here_m, rest_m[-1]) > self._p.arrived
        if self._is_held_off:
            self._planner.note_held_off(here_m, rest_m[0], stamp_s)
            self._explorer.give_up_goal(is_refused=self.explored.end is None)
            self._guide.forgive()
            return False
        if not self._guide.mind_the_pace(stamp_s, here_m, rest_m):
            return False
        if self._is_by_track:
            self._stay.note(stamp_s, here_m)
            return not self._stay.lasts(stamp_s, self._p.stranded)
        way = self._guide.way
        is_decided = self.explored.end is not None or self._p.sweep > 0.0 or not way.is_on_last_leg
        return is_decided and self._planner.is_clear(np.array([here_m, *way.rest_m]), stamp_s)

    def _decide(self, stamp_s: float, here_m: np.ndarray) -> None:
        self.explored.known_m3.append((stamp_s, self._planner.known_m3()))
        self._steep.settle()
        if self.explored.end is None:
            started = time.thread_time()
            self._next_view(stamp_s, here_m)
            self.explored.cpu_s.append(time.thread_time() - started)
            self.explored.ended_s = stamp_s
        if self.explored.end is not None:
            self._go_home(stamp_s, here_m)

    def _next_view(self, stamp_s: float, here_m: np.ndarray) -> None:
        decision = self._explorer.decide(self._planner.space(stamp_s, here_m), here_m)
        self.explored.views += 1
        if decision.is_shut_in and self._backs_out(stamp_s):
            return
        if not decision.is_shut_in:
            self._shut_in_s = None
        too_little = self._last_views.too_little_gain(stamp_s, self.explored.known_m3[-1][1], decision)
        if too_little:
            self._unknown.ask(stamp_s, here_m)
            self._end(End.EXPLORED, too_little)
            return
        if decision.goal_m is None:
            if self._p.steep and self._steep.set_out(
                stamp_s, here_m, lambda end_m: self._plan(here_m, end_m, stamp_s)
            ):
                return
            if self._planner.reopen(stamp_s, TRIES - 1):
                self._guide.hover(here_m)  # what CEPA has refused may hide behind it what is unknown
            else:
                self._end_without_goal(stamp_s, here_m, decision)
            return
        goal_m = np.array(decision.goal_m)
        if decision.column_m is not None:
            goal_m = self._steep.climb(decision.column_m, self._planner.space(stamp_s, here_m))
            if math.dist(goal_m, here_m) < self._p.arrived:
                self._explorer.give_up_goal()  # no range finder sees more of the way
        if not self._plan(here_m, goal_m, stamp_s):
            self._steep.settle()
            self._planner.close(goal_m, stamp_s)
            self._guide.hover(here_m)

    def _end_without_goal(self, stamp_s: float, here_m: np.ndarray, decision: Decision) -> None:
        if decision.is_shut_in:
            why = self._why_no_way(stamp_s, here_m) or "no place around it keeps the clearance."
            self._end(End.SHUT_IN, f"The UAV fits nowhere: {why}")
            return
        self._unknown.ask(stamp_s, here_m)
        self._end(End.EXPLORED, "No place that the UAV can reach shows anything unknown.")

    def _backs_out(self, stamp_s: float) -> bool:
        """Fly back the way it came, for a while. CEPA may have evaded to where the planner lets nobody be."""
        if self._shut_in_s is None:
            self._shut_in_s = stamp_s
            self._guide.set_out(Way(self._back.track_back_m))
        return stamp_s < self._shut_in_s + BACK_S

    def _go_home(self, stamp_s: float, here_m: np.ndarray) -> None:
        if self.is_paused:  # since this look began
            return
        if self.explored.end in (End.TIME, End.BATTERY) and not self._turned_home and self._planner.has_map:
            self._turned_home = True
            self._unknown.ask(stamp_s, here_m)
        self._stay.note(stamp_s, here_m)
        is_near = math.dist(here_m, self.home_m) < HELD_OFF * self._p.arrived
        if self._back.may_land(stamp_s, here_m) or (self._is_held_off and is_near):
            self._unknown.add_to(self.explored, self._turned_home)
            self.is_home = True
        elif self._stay.lasts(stamp_s, self._p.stranded) and not self.must_land:
            why = f"On its way home it stood still for {self._p.stranded:g} s."
            self._must_land_instead_of_home(End.CUT_OFF, f"{why} {self._why_no_way(stamp_s, here_m)}")
        else:
            self._is_by_track = not self._plan(here_m, self.home_m, stamp_s) and not (
                self._planner.reopen(stamp_s) and self._plan(here_m, self.home_m, stamp_s)
            )
            if self._is_by_track:
                self._guide.set_out(Way([*self._back.track_back_m, self.home_m]))

    def _plan(self, here_m: np.ndarray, goal_m: np.ndarray, stamp_s: float) -> bool:
        """Set out for a goal; return whether there is a way."""
        return self._guide.plan(here_m, goal_m, stamp_s)

    def _why_no_way(self, stamp_s: float, here_m: np.ndarray) -> str:
        """Return the planner's sentence; empty: there is a way home on the map."""
        try:
            self._planner.plan(here_m, self.home_m, stamp_s)
        except NoPathError as error:
            return str(error)
        return ""
