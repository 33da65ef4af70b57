"""What a node does with a goal that a UAV flies, whoever decides where: answers, follows, ends."""

from __future__ import annotations

import math
import time
from typing import Any, Callable, Mapping

import numpy as np

from flight_basics.errand import messages as came
from flight_basics.errand import outputs as out
from flight_basics.errand.barriers import Barrier, NoBarrier
from flight_basics.errand.begun import BegunGoal
from flight_basics.errand.goal_desk import GoalDesk
from flight_basics.errand.leader import Here, Leader
from flight_basics.errand.orders import CALLED, Orders
from flight_basics.errand.parameters import ErrandParameters, Readings
from flight_basics.errors import sentence_of
from flight_basics.pose.jumps import PoseJumps
from flight_basics.pose.trust import PoseTrust, Trust
from stamp_pairing.clock_steps import SteadyTime

MAP_SILENT_S = 10.0
"""While a UAV flies, its map changes at least so often."""
FIRST_S, BATTERY_S = 1.0, 15.0
"""Wall time in which pose and battery come after any goal: it may be sent together with the first pose. A UAV
whose pose is known waits longer for its battery: PX4 tells it every 2 s of its time."""
REST_S = 0.5
"""Wall time between two rests while nothing is flown."""
LOOK_S = 1.0
"""Between two looks at time and battery while no pose comes."""
STRANDED_S = 20.0
"""A UAV that is to come home waits so long for a pose, and then must land where it is."""
FAULTS = 3
"""So many decisions in a row fail on the way home, before the UAV must land where it is."""


class Errand:
    """Takes one message after the other, from one thread, and returns what follows.

    Every goal that is accepted is ended once. A flight whose goal another one replaced, and that one is
    refused, goes on to its end without a goal. A goal that comes while something is flown has the home of
    that flight.

    Args:
        leader: decides where to fly. begun: what outlives the node. parameters: see there. barrier: in
            lockstep. readings: of the battery. now_s: tells the wall time.

    Attributes:
        here: where the UAV is; None: nobody knows. is_active: something is flown.
    """

    def __init__(
        self,
        leader: Leader,
        begun: BegunGoal,
        parameters: ErrandParameters,
        barrier: Barrier | None = None,
        readings: Readings | None = None,
        now_s: Callable[[], float] = time.monotonic,
    ) -> None:
        self._leader, self._begun, self._p = leader, begun, parameters
        self._barrier: Barrier = NoBarrier() if barrier is None else barrier
        self._readings, self._now_s = readings, now_s
        self._out: list[out.Output] = []
        self._goals, self._orders = GoalDesk(), Orders(begun, parameters.name)
        self._latched_until_s = now_s() + parameters.restart_s
        self._prepares: came.Goal | None = None
        self._is_due = self._looks = self._has_rested = False
        self._end_before = ""
        self._rested_s = -math.inf
        self.here: Here | None = None
        self.is_active = self._is_stranded = False
        self._battery: came.Battery | None = None
        self._trust = PoseTrust(parameters.photographs)
        self._jumps = PoseJumps()
        self._time = SteadyTime()
        """Of the poses, while they come."""
        self._map_came_s = self._told_s = self._looked_s = -math.inf
        """By that time."""
        self._map_id, self._faults = "", 0
        self._sent: Any = None
        self._kept: Mapping[str, Any] = {}
        self._takes: dict[type, Callable[[Any], None]] = {
            came.Goal: self._on_goal,
            came.Cancel: self._on_cancel,
            came.Prepared: self._on_prepared,
            came.Pose: self._on_told,
            came.Scan: self._on_told,
            came.Steered: self._on_told,
            came.Heard: self._on_told,
            came.MapCame: self._on_map,
            came.MapId: self._on_map_id,
            came.Battery: self._on_battery,
            came.SlamState: lambda state: self._trust.on_state(state.word),
            came.Command: self._on_command,
            came.Question: self._on_question,
            came.Looked: self._on_looked,
            came.Due: self._on_due,
            came.Tick: self._on_tick,
        }

    def take(self, message: came.Message) -> list[out.Output]:
        """Take a message. Return what is to be done, in this order."""
        self._takes[type(message)](message)
        self._mind_the_silence()
        self._answer()
        self._finish()
        self._work()
        is_busy = self._is_answering or (
            self.is_active and (self._is_due or self._looks or self._leader.is_busy)
        )
        header = self._barrier.passed(self.is_active, is_busy)
        if header is not None:
            self._out.append(out.Acknowledge(header))
        done, self._out = self._out, []
        return done

    # goals

    def _on_goal(self, goal: came.Goal) -> None:
        if self._begun.had_ended(goal.identity):
            return
        self._out.append(out.Accept(goal))
        patience_s = self._p.restart_s if self._begun.flown == goal.identity else FIRST_S
        self._out += self._goals.take(goal, self._now_s() + patience_s)
        if self._goals.new is not goal:
            return
        self._orders.take(goal)
        if self.is_active:
            self._leader.give_way()
            self._send()

    def _on_cancel(self, cancel: came.Cancel) -> None:
        flown = self._goals.flown
        self._orders.give(cancel, (self._goals.new, flown))
        if flown is not None and self._orders.of(flown).ended:
            self._abort(self._orders.of(flown).ended)

    def _missing(self) -> str:
        """Return what a goal cannot begin without; empty: nothing."""
        if (self.here is None or self._time.silent_s) and self._p.needs_pose:
            return "The place of the UAV is not known yet."
        if self._battery is None and self._p.needs_battery:
            return "The battery has told nothing yet; set use_battery to false if there is none."
        return ""

    @property
    def _is_answering(self) -> bool:
        """Whether a goal is to be answered now."""
        longer_s = BATTERY_S if self.here is not None else 0.0
        return self._goals.is_due(self._missing(), longer_s, self._now_s())

    def _answer(self) -> None:
        """Let the goal that has come be prepared, or refuse it."""
        new = self._goals.new
        if new is None or self._prepares is not None or not self._is_answering:
            return
        missing = self._missing()
        if missing:
            self._refuse(missing)
        else:
            self._prepares = new
            self._out.append(out.Prepare(new))

    def _refuse(self, why: str) -> None:
        self._out.append(out.Say("warn", f"The {self._p.name} is refused: {why}"))
        self._out.append(self._goals.refuse(why))

    def _on_prepared(self, prepared: came.Prepared) -> None:
        self._prepares = None
        if self._goals.new is not prepared.goal:
            return  # another one came meanwhile
        why = prepared.why
        try:
            if not why:
                self._begin(prepared)
        except Exception as error:
            why = sentence_of(error)
        if why:
            self._refuse(why)
            return
        self._goals.begin()
        order = self._orders.of(prepared.goal)
        if order.ended:
            self._abort(order.ended)
        if order.is_paused and self.here is not None:
            self._leader.pause(self.here)
            self._send()

    def _begin(self, prepared: came.Prepared) -> None:
        """Begin, or go on with what is known. A flight keeps its home, also if its node died."""
        identity, known = prepared.goal.identity, self._begun.known
        is_flown = self._begun.flown == identity
        keeps_home = "home" in known and (self.is_active or self._begun.is_of_this_flight(identity))
        home = {"home": known["home"]} if keeps_home else None
        words = self._leader.begin(prepared.plan, self.here, known if is_flown else home)
        self._kept = self._leader.kept
        if not is_flown:
            self._begun.begin(identity, {**self._kept, "map": known.get("map", "") if home else self._map_id})
        if self._battery is not None and self._readings is not None:
            self._readings.begin(self._time.now_s, self._battery.charge)
        if self.here is not None:
            self._barrier.note_map(self.here.stamp_s)
        self._map_came_s, self._told_s = self._time.now_s, -math.inf
        self._is_due, self.is_active, self._is_stranded, self._faults = False, True, False, 0
        self._trust.begin()
        self._out.append(out.Say("info", words))
        self._mind_the_map(str(self._begun.known.get("map", "")))

    def _finish(self) -> None:
        """End the action at home, or where the UAV must land."""
        if not self.is_active or self._looks or self._goals.new is not None:
            return
        outcome = self._leader.outcome()
        if outcome is None:
            self._has_rested = False
            return
        if self._p.rests and not self._has_rested:  # what goes on afterwards is told before the result
            self._has_rested = True
            self._rest()
            return
        self._has_rested = False
        self.is_active = self._is_due = False
        self._begun.end()
        if outcome.must_land:
            self._out.append(out.Say("warn", f"The UAV must land here: {outcome.words}"))
        self._out.append(out.Say("warn" if outcome.end == "aborted" else "info", outcome.log))
        self._out += self._goals.end(outcome)

    # poses, map, battery

    def _on_told(self, message: Any) -> None:
        if isinstance(message, came.Pose) and message.place_m is None:
            self._time.passes("poses", message.stamp_s)
        pose = self._barrier.take(message, self.is_active)
        if pose is None:
            return
        before = self._sent
        if pose.place_m is not None:
            self._follow(pose, pose.place_m)
        elif pose.fault and self.is_active:
            self._out.append(out.Say("rarely", pose.fault))
        self._finish()
        self._barrier.note_followed(self._sent is not before)

    def _follow(self, pose: came.Pose, place_m: np.ndarray) -> None:
        time_s = self._time.at(pose.stamp_s)
        trust = self._trust.at(time_s, pose.off_m, pose.off_rad)
        deviation_m = self._trust.deviation_m
        here = Here(time_s, pose.stamp_s, place_m, pose.more, deviation_m)
        is_wild = self._p.leaves_out_jumps and self._jumps.is_wild(time_s, place_m)
        if is_wild and self.here is not None:
            off = f"{self._jumps.off_m:.0f} m off the one before"
            self._out.append(out.Say("rarely", f"A pose is {off}; it is left out."))
            here = self.here._replace(time_s=time_s, stamp_s=pose.stamp_s)
        else:
            self._leader.note(here)
        self.here = here
        if self._time.step_s:
            self._note_step(self._time.step_s, pose.stamp_s)
        if not self.is_active:
            return
        self._leader.trust(trust, self._trust.reason, here)
        self._is_due = self._leader.follow(here) or self._is_due
        before = self._sent
        self._send()
        is_new = self._sent is not before
        if self._leader.kept is not self._kept:
            self._kept = self._leader.kept
            self._begun.keep(self._kept)
        self._tell(here, is_new)

    def _note_step(self, step_s: float, stamp_s: float) -> None:
        words = f"The poses' clock was set by {step_s:+.1f} s; the {self._p.name} goes on."
        self._out.append(out.Say("warn", words))
        self._barrier.note_map(stamp_s)
        if step_s < 0.0:
            self._goals.note_clock_set_back()
        if "began" in self._begun.known:  # a node that dies begins with the stamps
            self._begun.keep({"began": self._begun.known["began"] + step_s})

    def _mind_the_silence(self) -> None:
        """Without a pose, time and battery count all the same. A UAV that is to come home then cannot."""
        silent_s = self._time.silent_s
        if not self.is_active or self._looks or (self.here is not None and not silent_s):
            return
        is_over = bool(self._leader.end) and not self._leader.is_paused
        if is_over and (self.here is None or silent_s >= STRANDED_S):
            self._strand("No pose tells where the UAV is, so it cannot come home.", self.here)
        elif self.here is not None and not 0.0 <= self._time.now_s - self._looked_s < LOOK_S:
            words = f"No pose has come for {silent_s:.0f} s. The UAV hovers; time and battery still count."
            self._out.append(out.Say("rarely", words))
            self._looked_s, self._is_due = self._time.now_s, True
            self._leader.trust(Trust.HOVER, words, self.here)
            self._send()

    def _strand(self, why: str, here: Here | None) -> None:
        """End here, and send no more setpoints: the UAV cannot come home. here: its last place."""
        self._leader.strand(why, here)
        self._send()
        self._is_stranded = True

    def _send(self) -> None:
        setpoint = None if self._is_stranded else self._leader.setpoint
        new = setpoint if setpoint is not self._sent else None
        self._sent = self._sent if setpoint is None else setpoint
        self._out.append(out.Send(new, self.here))

    def _tell(self, here: Here, is_new_setpoint: bool) -> None:
        is_early = 0.0 <= here.time_s - self._told_s < self._p.tell_s
        if is_early and not (is_new_setpoint and self._p.tells_setpoints):
            return
        self._told_s = here.time_s
        self._out.append(
            out.Tell(self._goals.flown, here, None if self._battery is None else self._battery.more)
        )
        if not self._p.has_map:
            return
        silent_s = here.time_s - self._map_came_s
        if not self._leader.has_map:
            words = "The map is empty. The UAV hovers until slam_octomap sends one."
            self._out.append(out.Say("rarely", words))
        elif silent_s > MAP_SILENT_S and not self._leader.is_paused:
            words = f"The map has told nothing for {silent_s:.0f} s. The UAV comes home."
            self._out.append(out.Say("rarely", words))
            self._leader.abort("The map has told nothing new while the UAV flew.")

    def _on_map(self, map_came: came.MapCame) -> None:
        self._barrier.note_map(map_came.stamp_s)
        self._time.passes("map", map_came.stamp_s)
        self._map_came_s = self._time.of_other(map_came.stamp_s, MAP_SILENT_S)

    def _on_map_id(self, map_id: came.MapId) -> None:
        before, self._map_id = self._map_id, map_id.word
        if self.is_active:
            self._mind_the_map(str(self._begun.known.get("map", before)))

    def _mind_the_map(self, before: str) -> None:
        """Places of the map in which the flight began are in another frame than those of a new map."""
        if self._map_id and before == "":
            self._begun.keep({"map": self._map_id})
        elif self._map_id not in ("", before):
            words = "SLAM has begun another map, so the places of home and goals are not known any more."
            self._out.append(out.Say("warn", f"{words} The {self._p.name} ends."))
            self._strand(words, None)

    def _on_tick(self, tick: came.Tick) -> None:
        if tick.stamp_s is not None:
            self._time.passes("clock", tick.stamp_s)

    def _on_battery(self, battery: came.Battery) -> None:
        self._battery = battery
        self._time.passes("battery", battery.stamp_s)
        if self._readings is not None:
            self._readings.add(self._time.of_other(battery.stamp_s), battery.charge)

    # what people ask for

    def _on_command(self, command: came.Command) -> None:
        if not command.reply.set_running_or_notify_cancel():
            return  # nobody waits for the answer any more
        is_flown, flown = self.is_active, self._begun.flown
        if not is_flown and self._now_s() > self._latched_until_s:
            flown = ""  # its goal does not come again
        is_obeyed = bool(is_flown or flown or self._goals.new)
        answer = came.Answer(is_obeyed, self._act(command, flown) if is_obeyed else self._p.idle)
        waited_for = self._leader.stop_waiting() if command.name == "abort" else ""
        if waited_for and not is_obeyed:
            answer = came.Answer(True, waited_for)
        if answer.success:
            self._out.append(out.Say("info", answer.words))
        self._out.append(out.Reply(command.reply, answer))

    def _act(self, command: came.Command, flown: str) -> str:
        """Carry out an order. It is kept before it is answered."""
        self._orders.give(command, (self._goals.new,), flown)
        if command.name == "abort":
            words = "The UAV comes home."
            if self.is_active:
                self._abort(CALLED.format(self._p.name))
        elif command.name == "pause":
            words = "The UAV hovers."
            if self.is_active and self.here is not None:
                self._leader.pause(self.here)
        else:
            words = f"The {self._p.name} goes on."
            if self.is_active:
                self._leader.resume()
        if self.is_active:
            self._send()
        return words

    def _abort(self, who: str) -> None:
        self._leader.abort(who)
        self._send()

    def _on_question(self, question: came.Question) -> None:
        if not question.reply.set_running_or_notify_cancel():
            return
        if question.needs_flight and (not self.is_active or self._leader.end):
            self._out.append(out.Reply(question.reply, came.Answer(False, self._p.idle)))
        else:
            self._out.append(out.Ask(question, None if self.here is None else self.here.place_m))

    # the worker

    def _on_due(self, _: came.Due) -> None:
        self._is_due = self.is_active

    def _work(self) -> None:
        """Let the worker decide, if it is time to, and nothing else is in its way."""
        if self._looks or self._prepares is not None:
            return
        if self.is_active and self._is_due and self.here is not None:
            readings = () if self._readings is None else tuple(self._readings.drain())
            self._is_due, self._looks, self._end_before = False, True, self._leader.end
            silent_s = self._time.silent_s
            here = self.here._replace(time_s=self._time.now_s, silent_s=silent_s) if silent_s else self.here
            self._out.append(out.Look(here, readings))
        elif self._p.rests and not self.is_active and self._now_s() >= self._rested_s + REST_S:
            self._rest()

    def _rest(self) -> None:
        self._looks, self._rested_s, self._end_before = True, self._now_s(), self._leader.end
        self._out.append(out.Look(None))

    def _on_looked(self, looked: came.Looked) -> None:
        self._looks = False
        self._out += [out.Say("rarely", sentence) for sentence in looked.warnings]
        self._faults = self._faults + 1 if looked.fault else 0
        if looked.fault and self.is_active:
            self._out.append(out.Say("rarely", f"{looked.fault} The UAV is to come home."))
            self._leader.abort(looked.fault)
            if self._faults > FAULTS:
                self._strand(looked.fault, self.here)
        if self.is_active:
            if not self._end_before and self._leader.end:
                words = f"The {self._p.name} ends ({self._leader.end}): {self._leader.reason}"
                self._out.append(out.Say("info", words))
            self._send()
        self._out.append(out.Settled())
