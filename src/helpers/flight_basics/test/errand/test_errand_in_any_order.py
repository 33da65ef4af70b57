"""In whatever order all events come, an errand answers everybody, comes home, and forgets no goal."""

from __future__ import annotations

import time
from dataclasses import replace

import hypothesis.strategies as st
from errand_model import Away, Hands, pose
from hypothesis import settings
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from flight_basics.errand import messages as came
from flight_basics.errand import outputs as out
from flight_basics.errand.barriers import MapBarrier
from flight_basics.errand.parameters import ErrandParameters
from flight_basics.pose.trust import LOST

PARAMETERS = ErrandParameters("test", "Nothing is flown.", needs_battery=True, rests=True)


class AnyOrder(RuleBasedStateMachine):
    @initialize(is_lockstep=st.booleans())
    def begin(self, is_lockstep):
        self.barrier = MapBarrier if is_lockstep else None
        self.stamp_s, self.sent, self.latched = 100.0, 0, None
        self.ordered = {}
        """What people want of each goal that was sent: "" to fly, "pause" or "end"."""
        self.held_back = []
        """Goals that have come, and whose sender the master is asked for."""
        self.replies, self.scans, self.messages = [], [], []
        self.hands = Hands(PARAMETERS, self.barrier)

    # the goals

    @rule(
        content=st.sampled_from(["yes", "yes", "no", "late no"]),
        late_s=st.sampled_from([0.0, 0.0, 50.0]),
        is_asked_for=st.booleans(),
    )
    def send_goal(self, content, late_s, is_asked_for):
        self.sent += 1
        name = f"goal {self.sent}"
        self.ordered[name] = ""
        self.latched = came.Goal(name, content, identity=name, stamp_s=self.stamp_s - late_s)
        self.held_back.append(self.latched)
        if not is_asked_for:
            self.tell_who_sent()

    @rule()
    def tell_who_sent(self):
        while self.held_back:
            self.hands.give(self.held_back.pop(0))

    @rule(back=st.integers(0, 3))
    def cancel(self, back):
        name = f"goal {self.sent - back}"
        self.hands.give(came.Cancel(name))
        if name in self.ordered:
            self.ordered[name] = "end"

    @rule()
    def die_and_start_again(self):
        """Nobody is told by a node that died; its sender latches the newest goal, and it comes again."""
        kept, is_flown = self.hands.kept, self.hands.errand.is_active
        accepted = self.hands.accepted
        home_m, was = self.hands.leader.home_m, self.hands.kept.values.get("goal")
        wall_s = self.hands.wall_s
        self.hands = Hands(PARAMETERS, self.barrier, kept, Away())
        self.hands.wall_s = wall_s
        self.scans.clear()
        self.messages.clear()
        self.held_back.clear()
        self.replies = [reply for reply in self.replies if reply.done()]
        if self.latched is None:
            return
        had_ended = was == self.latched.identity and kept.values["has_ended"]
        came_again = replace(self.latched, came_ns=time.monotonic_ns())
        if self.latched not in accepted:
            self.ordered[came_again.name] = ""  # no node had heard of it
        self.latched = came_again
        self.hands.give(self.latched)
        assert (self.latched in self.hands.accepted) is not had_ended
        if is_flown and was == self.latched.identity:
            self._be_told()
            self._settle()
            assert self.hands.leader.home_m == home_m

    # what the node hears

    @rule(
        after_s=st.sampled_from([0.02, 0.02, 0.5, 5.0, 3600.0, -3600.0]),
        x_m=st.sampled_from([0.0, 0.3, 900.0]),
    )
    def move(self, after_s, x_m):
        self.stamp_s += after_s
        self.hands.give(pose(self.stamp_s, (x_m, 0.0, 2.0)))

    @rule()
    def lose_the_pose(self):
        self.hands.give(came.Pose(self.stamp_s, None))

    @rule(charge=st.sampled_from([0.9, 0.9, 0.05, float("nan")]))
    def tell_charge(self, charge):
        self.hands.give(came.Battery(self.stamp_s, charge))

    @rule()
    def tell_map(self):
        self.hands.give(came.MapCame(self.stamp_s))

    @rule(word=st.sampled_from(["tracking", LOST]))
    def tell_slam(self, word):
        self.hands.give(came.SlamState(word))

    @rule()
    def wait(self):
        self.hands.wall_s += 0.5
        self.hands.give(came.Tick())

    @rule()
    def photograph(self):
        self.hands.give(came.Due())

    @precondition(lambda self: self.barrier is not None and not self.scans)
    @rule()
    def scan(self):
        """The simulator sends the next one when this one is acknowledged."""
        self.scans.append(self.stamp_s)
        self.hands.give(came.Scan(self.stamp_s, self.stamp_s))

    # people

    @rule(name=st.sampled_from(["pause", "resume", "abort"]))
    def command(self, name):
        command = came.Command(name)
        self.hands.give(command)
        assert command.reply.done()  # at once, whatever the worker does
        if command.reply.result().success:
            given = {"abort": "end", "pause": "pause", "resume": ""}[name]
            for each, order in self.ordered.items():
                self.ordered[each] = order if order == "end" else given

    @rule(needs_flight=st.booleans())
    def ask(self, needs_flight):
        question = came.Question(lambda here_m: here_m, needs_flight)
        self.replies.append(question.reply)
        self.hands.give(question)

    @rule()
    def ask_and_go_away(self):
        question = came.Question(lambda here_m: here_m)
        question.reply.cancel()
        assert not [each for each in self.hands.give(question) if isinstance(each, out.Ask)]

    # the worker

    @rule()
    def work(self):
        if self.hands.jobs:
            self.messages.append(self.hands.work())

    @rule()
    def hear_of_the_work(self):
        if self.messages:
            self.hands.give(self.messages.pop(0))

    # what holds

    @invariant()
    def holds(self):
        hands = getattr(self, "hands", None)
        if hands is None:
            return
        self._is_obeyed()
        assert len(hands.open) <= 2  # one is flown, one is new
        self.scans = [each for each in self.scans if each not in hands.acknowledged]
        if hands.errand.is_active:
            assert not hands.kept.values["has_ended"]
        assert self._looks() <= 1
        # A leader begins only while nobody looks
        steps = [type(each) for each in (*self.messages, *hands.jobs)]
        prepares = next(
            (i for i, step in enumerate(steps) if step in (came.Prepared, out.Prepare)), len(steps)
        )
        assert not {came.Looked, out.Look} & set(steps[prepares:])

    def _is_obeyed(self):
        """An order concerns every goal that was sent before it, in whatever state that was."""
        errand, leader = self.hands.errand, self.hands.leader
        flown = errand.is_active and errand._goals.flown
        order = self.ordered[flown.name] if flown else ""
        assert order != "end" or leader.end
        assert order != "pause" or leader.is_paused or leader.end

    def _looks(self):
        """Number of looks that are to be done, or not heard of yet."""
        looking = [job for job in self.hands.jobs if isinstance(job, out.Look)]
        return len(looking) + len([each for each in self.messages if isinstance(each, came.Looked)])

    def _be_told(self):
        self.stamp_s += 0.02
        self.hands.give(pose(self.stamp_s))
        self.hands.give(came.Battery(self.stamp_s, 0.9))
        self.hands.give(came.MapCame(self.stamp_s))

    def _settle(self):
        while self.hands.jobs or self.messages:
            if self.hands.jobs:
                self.messages.append(self.hands.work())
            self.hands.give(self.messages.pop(0))

    def teardown(self):
        """Whatever came, a UAV that is told to come home does so, and nobody waits any more."""
        if not hasattr(self, "hands"):
            return
        self.tell_who_sent()
        self.hands.give(came.SlamState("tracking"))
        for _ in range(5):
            self._be_told()
            self._settle()
        self.hands.give(came.Command("abort"))
        for _ in range(5):
            self._be_told()
            self._settle()
        assert not self.hands.errand.is_active
        assert self.hands.open == []
        assert all(reply.done() for reply in self.replies)
        assert all(each in self.hands.acknowledged for each in self.scans)
        assert self.hands.kept.values.get("has_ended", True)


TestAnyOrder = AnyOrder.TestCase
TestAnyOrder.settings = settings(max_examples=60, stateful_step_count=40, deadline=None)
