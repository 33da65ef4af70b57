"""A leader that flies home in a few looks, and a test's own hands in place of threads and ROS."""

from __future__ import annotations

from collections import deque

import numpy as np

from flight_basics.errand import messages as came
from flight_basics.errand import outputs as out
from flight_basics.errand.begun import BegunGoal
from flight_basics.errand.errand import Errand
from flight_basics.errand.leader import Outcome
from flight_basics.errors import FlightBasicsError
from flight_basics.pose.trust import Trust

HOME_LOOKS = 3
"""After so many looks on its way home a UAV is there."""


class Kept:
    """A parameter that outlives the node."""

    def __init__(self, values=()):
        self.values = dict(values)

    def keep(self, values):
        self.values = dict(values)


class Away:
    """A leader. Its goals are words: "no" is refused by `prepare`, and "late no" by `begin`."""

    def __init__(self, takes_looks=HOME_LOOKS):
        self._takes_looks = takes_looks
        self.setpoint = None
        self.kept = {}
        self.end = self.reason = ""
        self.is_paused = self.is_busy = False
        self.has_map = True
        self.must_land = False
        self.home_m = None
        self.until_s = float("inf")
        self._looks = 0
        self.rested_at_home = False

    def prepare(self, content):
        if content == "no":
            raise FlightBasicsError("It cannot be read.")
        return content

    def mind(self, here):
        """Its time ends when the stamps say so."""
        if here.time_s > self.until_s:
            self.end = self.end or "time"

    def begin(self, plan, here, kept):
        if plan == "late no":
            raise FlightBasicsError("It makes no sense.")
        self.home_m = here.place_m.tolist() if kept is None else kept["home"]
        self.kept = {"home": self.home_m}
        self.end = self.reason = ""
        self._looks, self.is_paused, self.must_land = 0, False, False
        self.setpoint = here.place_m + np.array((0.0, 0.0, 1.0))
        return "It begins."

    def note(self, here):
        pass

    def follow(self, here):
        return True

    def look(self, here, readings):
        self.mind(here)
        self._looks += bool(self.end) and not here.silent_s
        if any(charge < 0.1 for _, charge in readings):
            self.end = self.end or "battery"
        return []

    def rest(self):
        self.rested_at_home = self.rested_at_home or bool(self.end and self._looks >= self._takes_looks)

    def trust(self, trust, why, here):
        if trust is Trust.COME_HOME:
            self.end, self.reason = self.end or "aborted", why

    def pause(self, here):
        self.is_paused, self.setpoint = True, here.place_m

    def resume(self):
        self.is_paused = False

    def abort(self, reason):
        self.resume()
        self.end, self.reason = self.end or "aborted", self.reason or reason

    def give_way(self):
        self.abort("Another one.")

    def strand(self, why, here):
        self.abort(why)
        self.reason, self.must_land = f"{self.reason} {why}", True

    def stop_waiting(self):
        return ""

    def outcome(self):
        is_home = self.end and self._looks >= self._takes_looks and not self.is_paused
        return Outcome(self.reason, must_land=self.must_land) if is_home or self.must_land else None


class Hands:
    """Gives messages to an errand, and does by hand what its worker, ROS and people would do."""

    def __init__(self, parameters, barrier=None, kept=None, leader=None, readings=None):
        self.wall_s = 0.0
        self.kept = Kept() if kept is None else kept
        self.leader = Away() if leader is None else leader
        self.barrier = None if barrier is None else barrier(lambda: self.wall_s)
        self.errand = Errand(
            self.leader, BegunGoal(self.kept), parameters, self.barrier, readings, lambda: self.wall_s
        )
        self.jobs = deque()
        self.accepted, self.finished, self.outputs = [], [], []
        self.acknowledged = []

    def give(self, message):
        """Take a message; return its outputs."""
        outputs = self.errand.take(message)
        for output in outputs:
            self._note(output)
        self.outputs += outputs
        return outputs

    def _note(self, output):
        if isinstance(output, out.Accept):
            self.accepted.append(output.goal)
        elif isinstance(output, out.Finish):
            assert output.goal in self.accepted
            assert output.goal not in [each.goal for each in self.finished]
            self.finished.append(output)
        elif isinstance(output, out.Reply):
            output.to.set_result(output.answer)
        elif isinstance(output, out.Acknowledge):
            self.acknowledged.append(output.header)
        elif isinstance(output, (out.Prepare, out.Look, out.Ask)):
            self.jobs.append(output)

    def work(self):
        """Do the worker's next job, if there is one. Return what it puts into the inbox, not yet taken."""
        if not self.jobs:
            return came.Tick()
        job = self.jobs.popleft()
        if isinstance(job, out.Prepare):
            try:
                return came.Prepared(job.goal, self.leader.prepare(job.goal.content))
            except FlightBasicsError as error:
                return came.Prepared(job.goal, why=str(error))
        if isinstance(job, out.Ask):
            job.question.reply.set_result(job.question.answer(job.place_m))
            return came.Tick()
        if job.here is None:
            self.leader.rest()
            return came.Looked()
        return came.Looked(tuple(self.leader.look(job.here, job.readings)))

    def work_all(self):
        """Let the worker do all."""
        while self.jobs:
            self.give(self.work())

    def told(self, kind):
        """Return the outputs of a kind so far."""
        return [output for output in self.outputs if isinstance(output, kind)]

    @property
    def open(self):
        """Return the goals that are not ended yet."""
        ended = [each.goal for each in self.finished]
        return [goal for goal in self.accepted if goal not in ended]


def pose(stamp_s, place_m=(0.0, 0.0, 2.0), **more):
    return came.Pose(stamp_s, np.array(place_m), **more)
