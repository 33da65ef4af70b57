"""Leads a UAV from photograph to photograph, and home.

Whoever flies the UAV gives its poses and the map, gets setpoints, and opens the shutter when it is due.
"""

from __future__ import annotations

import math
import threading
from contextlib import suppress
from dataclasses import replace
from enum import Enum
from typing import Collection, Sequence

import numpy as np

from exploration.energy import EnergyWatch, Verdict, WayHome
from exploration.next_view.way import Progress, Way
from exploration.planning import PathPlanner
from flight_basics.errors import MapError, NoPathError
from flight_basics.pose.trust import Trust
from inspection.flight.homing import Homing
from inspection.flight.legs.leg import PhotographLeg
from inspection.flight.legs.ways import Legs
from inspection.flight.motion import Motion
from inspection.flight.parameters import InspectionParameters
from inspection.flight.photograph_quality import PhotographQuality
from inspection.flight.photograph_queue import PhotographQueue, Task
from inspection.flight.places import view_of_point
from inspection.survey.views.candidates import View

BEEN_M = 0.05
STUCK_S = 8.0
"""A UAV that comes no nearer for so long does not get on."""


class End(Enum):
    """Why an inspection has ended."""

    DONE = "done"
    TIME = "time"
    BATTERY = "battery"
    CAMERA = "camera"
    STORAGE = "storage"
    ABORTED = "aborted"
    SEARCHING = "searching"


class Inspection:
    """Leads from photograph to photograph in the order of a list.

    Call `follow` with every pose, fly to `setpoint_m`, turn to `front_rad`, tilt to `tilt_rad`. When `follow`
    says so, call `look`, from any one thread. When `shutter` gives a task, take its photograph, and call
    `judge_quality` with what the camera told.

    Args:
        planner: knows the map, and the drawing if there is one. queue: the photographs.
        parameters: see there. energy: watches the battery; None: the battery does not count.

    Attributes:
        queue: the photographs that are done and open. end, reason: why it has ended; None: it flies. is_home:
        it has ended, and the UAV is where it may land. must_land: the energy does not take the UAV home.
        awaits: more photographs may come; when all others are taken, the UAV waits for them at home. If that
        takes long, it ends as SEARCHING, to land until the search has answered, and begins again then. lacks:
        why the photographs are not all of the plan; with it, it ends as ABORTED when they are taken.
    """

    def __init__(
        self,
        planner: PathPlanner,
        queue: PhotographQueue,
        parameters: InspectionParameters | None = None,
        energy: EnergyWatch | None = None,
    ) -> None:
        self._planner, self.queue = planner, queue
        self._p = self._given = parameters or InspectionParameters()
        self._homing = Homing(planner, energy, self._p)
        self._legs = Legs(planner, self._p)
        self._lock = threading.RLock()
        self._way = Way()
        self._leg: PhotographLeg | None = None
        self._progress = Progress()
        """On the way to a photograph, or home."""
        self._been_m: list[np.ndarray] = []
        self._began_s, self._look_s = math.nan, -math.inf
        self._now_s = 0.0
        """Stamp of the newest pose."""
        self._no_way_s: float | None = None
        """Since when no open photograph has a way; None: one has."""
        self._held_off: tuple[np.ndarray, np.ndarray] | None = None
        """Where CEPA kept the UAV off its way, and the next place of that; the planner does not know yet."""
        self._is_paused = self._is_in_doubt = False
        self.end: End | None = None
        self._is_sure = True
        self.reason = self.lacks = ""
        self.is_home = self.must_land = self.awaits = False
        self.front_rad: float | None = None
        self.tilt_rad = 0.0

    def begin(
        self,
        stamp_s: float,
        here_m: np.ndarray,
        home_m: np.ndarray | None = None,
        time_max_s: float | None = None,
    ) -> None:
        """Begin at a hover (x, y, z), or go on after a landing.

        home_m: if it is not the first place. time_max_s: after it the UAV comes home; None: the parameter's.

        Raises:
            ParameterError: the time makes no sense.
        """
        with self._lock:
            self._p = self._given if time_max_s is None else replace(self._given, time_max=time_max_s)
            self._began_s, self._look_s, self._no_way_s = stamp_s, -math.inf, None
            self.end, self.reason = None, ""
            self.is_home = self.must_land = self._is_paused = self._is_in_doubt = False
            self._way, self._leg, self._held_off = Way([here_m]), None, None
            self._homing.begin(here_m if home_m is None else home_m)

    def pause(self, here_m: np.ndarray) -> None:
        """Hover at a place until `resume`, `abort`, or the energy begins to say: come home."""
        with self._lock:
            self._is_paused, self._way, self._leg = True, Way([here_m]), None

    def resume(self) -> None:
        """Go on after a pause."""
        with self._lock:
            self._is_paused, self._look_s = False, -math.inf

    def trust(self, trust: Trust, why: str, here_m: np.ndarray) -> None:
        """Take what the pose (x, y, z) is good for, with each pose. why: it is not sure.

        While it is not sure, the UAV takes no photograph. If that lasts, it hovers, and in the end comes
        home. On its way home it flies on.
        """
        with self._lock:
            self._is_sure = trust is Trust.SURE
            was_in_doubt, self._is_in_doubt = self._is_in_doubt, trust >= Trust.HOVER
            if trust is Trust.COME_HOME:
                self.come_home(f"{why} That lasted too long.", End.ABORTED)
            elif self.end is None and self._is_in_doubt and not was_in_doubt:
                self._way, self._leg = Way([here_m]), None
            elif was_in_doubt and not self._is_in_doubt:
                self._look_s = -math.inf

    def abort(self, reason: str) -> None:
        """Come home, unless it does already; a pause ends."""
        with self._lock:
            self.resume()
            self.come_home(reason, End.ABORTED)

    def strand(self, why: str) -> None:
        """Land here: the UAV cannot come home."""
        with self._lock:
            self.come_home(why, End.ABORTED)
            self._must_land(why)

    def _must_land(self, why: str) -> None:
        """Land here, and tell why beside the reason for which the flight has ended."""
        if not self.must_land and why not in self.reason:
            self.reason = f"{self.reason} {why}"
        self.must_land = True

    def come_home(self, reason: str, end: End) -> None:
        """Come home, unless it does already. If it is paused, then after the pause."""
        with self._lock:
            if self.end is None:
                self.end, self.reason, self._look_s = end, reason, -math.inf
                if not self._is_paused:
                    self._way, self._leg = Way(), None

    @property
    def is_paused(self) -> bool:
        """Whether it hovers by `pause`."""
        return self._is_paused

    @property
    def is_in_doubt(self) -> bool:
        """Whether it hovers because the pose is not sure."""
        return self._is_in_doubt and self.end is None

    @property
    def is_waiting(self) -> bool:
        """Whether all photographs are taken, and more may come."""
        return self.awaits and self.end is None and self.queue.next is None

    @property
    def home_m(self) -> np.ndarray | None:
        """Where it comes home to."""
        return self._homing.home_m

    @property
    def way_home(self) -> WayHome | None:
        """Length and time of the way home, as it was planned last."""
        return self._homing.way

    @property
    def setpoint_m(self) -> np.ndarray | None:
        """Where to fly now, (x, y, z) in the map's frame; None: stay."""
        with self._lock:
            aim_m = self._leg.aim_m if self._leg is not None and len(self._way.rest_m) <= 1 else None
            return self._way.setpoint_m if aim_m is None else aim_m

    @property
    def rest_m(self) -> list[np.ndarray]:
        """The places of the way that are still to come."""
        return self._way.rest_m

    @property
    def task(self) -> Task | None:
        """The photograph that it flies to."""
        leg = self._leg
        return None if leg is None else leg.task

    def follow(self, motion: Motion) -> bool:
        """Take a pose. Return whether it is time to `look`."""
        if self._homing.home_m is None:
            return False
        here_m, self._now_s = motion.place_m, motion.time_s
        with self._lock:
            if not self._been_m or math.dist(here_m, self._been_m[-1]) > BEEN_M:
                self._been_m.append(here_m)
            if self.end is None:
                self._homing.note(here_m)
            self._way.follow(motion.time_s, here_m, self._p.arrived)
            if self._leg is not None and (why := self._leg.follow(motion)):
                if not self._leg.has_arrived and self._way.rest_m:
                    self._held_off = here_m, self._way.rest_m[0]
                self._fail(self._leg.task, why)
            waits = self._is_paused or self._is_in_doubt or self.is_waiting or self._no_way_s is not None
            is_idle = self._leg is None and self.end is None and not waits
            is_due = motion.time_s >= self._look_s + self._p.look_period
        return not self.is_home and (is_idle or is_due)

    def shutter(self, motion: Motion) -> Task | None:
        """Return the photograph whose shutter opens now, once. None opens where the pose is not sure."""
        with self._lock:
            leg = self._leg if self._is_sure else None
            return leg.task if leg is not None and leg.opens_shutter(motion) else None

    def judge_quality(self, task: Task, quality: PhotographQuality) -> str:
        """Take what the camera told. Return why the photograph is not kept; empty: it is good."""
        fault = quality.fault(self._p, is_closer=task.number < 0)
        with self._lock:
            if self._leg is not None and self._leg.task is task:
                self._leg = None
            if fault:
                self.queue.note_failure(task, fault, at_once=True)
            else:
                self.queue.note_done(task)
        return fault

    def lost(self, task: Task, why: str) -> None:
        """A photograph was not taken, or its picture did not come: it is taken again, later."""
        with self._lock:
            self._fail(task, why)
            if self.end is End.DONE:
                self.end, self.is_home, self._look_s = None, False, -math.inf

    def metering(self, task: Task) -> tuple[float, float]:
        """Return by what the camera exposes a photograph: the detail that it is to show, m; its bias, EV."""
        return self._p.detail_m(is_closer=task.number < 0), self.queue.bias_of(task)

    def expose_again(self, task: Task, lost: float, bias_ev: float) -> bool:
        """Take again a photograph that is stored, if too much of what it is to show is white or black.

        lost: share of it, 0..1. bias_ev: exposure compensation that shows more. Return whether it is taken.
        """
        with self._lock:
            exposures = self.queue.exposures_of(task) + 1
            if lost <= self._p.lost_max or exposures >= self._p.exposures:
                return False
            self.queue.expose_again(task, bias_ev)
            if self.end is End.DONE:
                self.end, self.is_home, self._look_s = None, False, -math.inf
            return True

    def note_stored(self, stored: Collection[int]) -> None:
        """Take what the folder holds of the photographs: what somebody has deleted is taken again."""
        with self._lock:
            self.queue.note_stored(stored)

    def look_closer(self, point_m: np.ndarray, here_m: np.ndarray, distance_m: float) -> Task | None:
        """Photograph a point from nearer now, and then go on. None: no place near it can be flown to."""
        view = view_of_point(self._planner, point_m, here_m, distance_m, self._p.camera_m, self._now_s)
        if view is None:
            return None
        with self._lock:
            self._leg, self._look_s = None, -math.inf
            return self.queue.look_closer(view)

    def look_again(self, views: Sequence[View]) -> None:
        """Photograph these, too, after all others. No more is awaited."""
        with self._lock:
            self.queue.look_again(views)
            self.awaits, self._look_s = False, -math.inf

    def take_more(self, views: Sequence[View]) -> None:
        """Photograph these, too, after all others."""
        with self._lock:
            self.queue.add(views)
            self._look_s = -math.inf

    def _fail(self, task: Task, why: str) -> None:
        if self._leg is not None and self._leg.task.number == task.number:
            self._leg = None
        self.queue.note_failure(task, why)

    def look(self, stamp_s: float, here_m: np.ndarray) -> None:
        """Check the way at a place (x, y, z), and decide anew if it is time to."""
        way = self._way
        self._homing.note_pace(stamp_s, here_m, way.rest_m if way.is_left else ())
        self._look_s = stamp_s
        with self._lock:
            been_m, self._been_m = self._been_m, []
            held_off, self._held_off = self._held_off, None
        if held_off is not None:
            self._homing.close_ahead(stamp_s, *held_off)
        is_stuck = self._is_stuck(stamp_s, here_m, way.rest_m)
        if is_stuck and self.end is None:
            self._planner.meets_unseen(here_m, way.rest_m[0], stamp_s)
        for place_m in (*been_m, here_m):
            with suppress(MapError):  # no map reaches so far
                self._planner.assume_free(place_m, self._planner.parameters.radius)
        self.mind(stamp_s, here_m)
        if self._is_paused:
            return
        if self.end is None and self._planner.has_map and not self._is_in_doubt:
            self._go_on(stamp_s, here_m)
        if self.end is not None:
            self._go_home(stamp_s, here_m, is_stuck)

    def mind(self, stamp_s: float, here_m: np.ndarray) -> None:
        """End if the energy or the time says so. here_m: where the UAV was last, (x, y, z)."""
        decision = self._homing.decide(stamp_s, here_m)
        if decision is not None and decision.verdict is not Verdict.GO_ON:
            if self.queue.next is not None:
                self.come_home(decision.reason, End.BATTERY)
            elif self.awaits:  # it needs a battery only if more is to be photographed
                self.come_home(decision.reason, End.SEARCHING)
            else:
                self._come_home_done()
            if decision.verdict is Verdict.LAND:
                self._must_land(decision.reason)
            if self._homing.turns_low(decision):
                self.resume()
        if self.end is None and stamp_s - self._began_s > self._p.time_max:
            self.come_home(f"The time of {self._p.time_max:g} s is over.", End.TIME)

    def _is_stuck(self, stamp_s: float, here_m: np.ndarray, rest_m: Sequence[np.ndarray]) -> bool:
        """Return whether the UAV, which is on its way to a photograph or home, comes no nearer."""
        with self._lock:
            is_on_way = self._leg is not None and not self._leg.has_arrived
            waits = self._is_paused or self.is_in_doubt
        self._progress.note(stamp_s, here_m, rest_m if (is_on_way or self.end) and not waits else ())
        is_stuck = self._progress.is_held_off(stamp_s, STUCK_S)
        if is_stuck:
            self._progress = Progress()
        return is_stuck

    def _go_on(self, stamp_s: float, here_m: np.ndarray) -> None:
        """Keep to the way if it is clear; else find another one, or the next photograph."""
        with self._lock:
            leg = self._leg
            if leg is not None and (leg.is_shot or leg.has_arrived):
                return
            rest_m = self._way.rest_m
        if leg is not None and rest_m and self._legs.is_clear(here_m, rest_m, stamp_s):
            return
        if self.queue.next is not None:
            self._set_out_for_any(stamp_s, here_m)
            return
        if not self.awaits:
            self._come_home_done()
        elif self._homing.near_home_s(stamp_s, here_m) > self._p.search_hover:
            words = "The photographs are still being searched. The UAV lands meanwhile."
            self.come_home(words, End.SEARCHING)
        else:
            self._go_home(stamp_s, here_m)

    def _come_home_done(self) -> None:
        """Come home: nothing is left to photograph."""
        self.come_home(self.lacks or self.queue.summary(), End.ABORTED if self.lacks else End.DONE)

    def _is_clear(self, here_m: np.ndarray, rest_m: list[np.ndarray], stamp_s: float) -> bool:
        return self._planner.has_map and self._legs.is_clear(here_m, rest_m, stamp_s)

    def _set_out_for_any(self, stamp_s: float, here_m: np.ndarray) -> None:
        """Set out for the first photograph that there is a way to. The others before it have failed.

        If there is none to any, the map may lack a part for a moment: the UAV hovers before they have failed.
        """
        blocked = []
        for task in self.queue.open:
            why = self._set_out(task, stamp_s, here_m)
            if not why:
                self._no_way_s = None
                break
            blocked.append((task, why))
        else:
            if self._no_way_s is None:
                self._no_way_s = stamp_s
            if stamp_s < self._no_way_s + self._p.wait:
                return
        with self._lock:
            for task, why in blocked:
                self.queue.note_failure(task, why)

    def _set_out(self, task: Task, stamp_s: float, here_m: np.ndarray) -> str:
        """Set out for a photograph. Return why there is no way; empty: it flies."""
        try:
            failures, may_pass = self.queue.failures_of(task), not self.queue.exposures_of(task)
            leg, way = self._legs.to(task, stamp_s, here_m, self.tilt_rad, failures, may_pass)
        except NoPathError as error:
            return str(error)
        with self._lock:
            if self._is_paused or self._is_in_doubt or self.end is not None:
                return ""
            if self._leg is not None and self._leg.task is task:
                leg.go_on_from(self._leg)
            self._leg, self._way = leg, way
            self.front_rad, self.tilt_rad = task.view.yaw_rad, task.view.tilt_rad
        return ""

    def _go_home(self, stamp_s: float, here_m: np.ndarray, is_stuck: bool = False) -> None:
        assert self.home_m is not None
        with self._lock:
            if self._is_paused:  # since this look began
                return
            self.front_rad, self.tilt_rad, rest_m = None, 0.0, self._way.rest_m
            if self._homing.may_land(stamp_s, here_m):
                self.is_home = self.end is not None
                return
        if is_stuck and rest_m:
            self._homing.close_ahead(stamp_s, here_m, rest_m[0])
        elif rest_m and not self._homing.is_by_track and self._is_clear(here_m, rest_m, stamp_s):
            return
        way_m = self._homing.next_way(stamp_s, here_m, is_stuck)
        if way_m is not None:
            # The planner knows no way along the track: each of its places counts.
            way = Way(way_m) if self._homing.is_by_track else self._legs.along(way_m, stamp_s, here_m)
            with self._lock:
                if not self._is_paused:
                    self._way = way
