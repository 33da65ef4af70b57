"""What a node does with a goal that a UAV flies, whoever decides where: answers, follows, ends."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from typing import Any, Callable, Mapping, Protocol

import numpy as np

from flight_basics.errand import messages as came
from flight_basics.errand import outputs as out
from flight_basics.errand.barriers import Barrier, NoBarrier
from flight_basics.errand.begun import BegunGoal
from flight_basics.errand.leader import Here, Leader
from flight_basics.errors import FlightBasicsError
from flight_basics.pose.jumps import PoseJumps
from flight_basics.pose.trust import PoseTrust
from stamp_pairing.clock_steps import SteadyTime

MAP_SILENT_S = 10.0
"""While a UAV flies, its map changes at least so often."""
FIRST_S, BATTERY_S = 1.0, 15.0
"""Wall time in which pose and battery come after any goal: it may be sent together with the first pose. A UAV
whose pose is known waits longer for its battery: PX4 tells it every 2 s of its time."""
REST_S = 0.5
"""Wall time between two rests while nothing is flown."""
REPLACED = "This goal was canceled because another one came."
ABORTED = "It was aborted."


@dataclass(frozen=True)
class ErrandParameters:
    """What differs between errands.

    name: in sentences, such as "survey". idle: the answer while nothing is flown. restart_s: wall time in
    which a node that starts again in a flight hears its pose and the battery. tell_s: between two feedbacks.
    needs_pose: a goal begins when the pose is known, not before. needs_battery: also when the battery is.
    has_map: a map that tells nothing for long sends the UAV home. photographs: a pose must be right to
    centimetres. leaves_out_jumps: a single pose that is far off does not count. tells_setpoints: feedback
    with each new setpoint. rests: the leader works on while nothing is flown.
    """

    name: str
    idle: str
    restart_s: float = 30.0
    tell_s: float = 0.5
    needs_pose: bool = True
    needs_battery: bool = False
    has_map: bool = True
    photographs: bool = False
    leaves_out_jumps: bool = True
    tells_setpoints: bool = False
    rests: bool = False


class Readings(Protocol):
    """As `exploration.energy.Readings`: charges that wait for the next look."""

    def add(self, stamp_s: float, charge: float) -> None:
        """Take in a reading."""

    def begin(self, stamp_s: float, charge: float) -> None:
        """Begin a flight with the newest reading."""

    def take(self) -> list[tuple[float, float]]:
        """Return what waits."""


class Errand:
    """Takes one message after the other, from one thread, and returns what follows.

    Every goal that is accepted is ended once. A flight whose goal another one replaced, and that one is
    refused, goes on to its end without a goal.

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
        self._new: came.Goal | None = None
        """It is not answered yet."""
        self._until_s = -math.inf
        """Wall time until which it waits for what is missing."""
        self._is_new_cancelled = False
        self._flown: came.Goal | None = None
        self._newest_stamp_s = -math.inf
        """Of all goals."""
        self._prepares: came.Goal | None = None
        self._is_due = self._looks = False
        self._end_before = ""
        self._rested_s = -math.inf
        self.here: Here | None = None
        self.is_active = False
        self._battery: came.Battery | None = None
        self._trust = PoseTrust(parameters.photographs)
        self._jumps = PoseJumps()
        self._time = SteadyTime()
        """Of the poses."""
        self._map_came_s = self._told_s = -math.inf
        """By that time."""
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
            came.Battery: self._on_battery,
            came.SlamState: lambda state: self._trust.on_state(state.word),
            came.Command: self._on_command,
            came.Question: self._on_question,
            came.Looked: self._on_looked,
            came.Due: self._on_due,
            came.Tick: lambda _: None,
        }

    def take(self, message: came.Message) -> list[out.Output]:
        """Take a message. Return what is to be done, in this order."""
        self._takes[type(message)](message)
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
        if goal.stamp_s < self._newest_stamp_s:  # a latched one of before, which a restart hears again
            self._out.append(out.Finish(goal, out.End.CANCELED, REPLACED))
            return
        self._newest_stamp_s = goal.stamp_s
        if self._new is not None:
            self._out.append(out.Finish(self._new, out.End.CANCELED, REPLACED))
        if self._flown is not None:
            self._out.append(out.Finish(self._flown, out.End.CANCELED, REPLACED))
            self._flown = None
        if self.is_active:
            self._leader.give_way()
            self._send()
        patience_s = self._p.restart_s if self._begun.is_flown(goal.identity) else FIRST_S
        self._new, self._until_s = goal, self._now_s() + patience_s
        self._is_new_cancelled = False

    def _on_cancel(self, cancel: came.Cancel) -> None:
        if self._new is not None and self._new.name == cancel.name:
            self._is_new_cancelled = True
        elif self._flown is not None and self._flown.name == cancel.name:
            self._abort()

    def _missing(self) -> str:
        """Return what a goal cannot begin without; empty: nothing."""
        if self.here is None and self._p.needs_pose:
            return "The place of the UAV is not known yet."
        if self._battery is None and self._p.needs_battery:
            return "The battery has told nothing yet; set use_battery to false if there is none."
        return ""

    @property
    def _is_answering(self) -> bool:
        """Whether a goal is to be answered now."""
        if self._new is None:
            return False
        longer_s = BATTERY_S if self.here is not None else 0.0
        return not self._missing() or self._now_s() >= self._until_s + longer_s

    def _answer(self) -> None:
        """Let the goal that has come be prepared, or refuse it."""
        if not self._is_answering or self._prepares is not None or self._new is None:
            return
        missing = self._missing()
        if missing:
            self._refuse(missing)
        else:
            self._prepares = self._new
            self._out.append(out.Prepare(self._new))

    def _refuse(self, why: str) -> None:
        assert self._new is not None
        self._out.append(out.Say("warn", f"The {self._p.name} is refused: {why}"))
        self._out.append(out.Finish(self._new, out.End.ABORTED, why))
        self._new = None

    def _on_prepared(self, prepared: came.Prepared) -> None:
        self._prepares = None
        if self._new is not prepared.goal:
            return  # another one came meanwhile
        why = prepared.why
        try:
            if not why:
                self._begin(prepared)
        except FlightBasicsError as error:
            why = str(error)
        if why:
            self._refuse(why)
            return
        self._flown, self._new = prepared.goal, None
        if self._is_new_cancelled:
            self._abort()

    def _begin(self, prepared: came.Prepared) -> None:
        """Begin, or go on with what is known. A node that died comes home to the same place."""
        identity = prepared.goal.identity
        is_flown = self._begun.is_flown(identity)
        words = self._leader.begin(prepared.plan, self.here, self._begun.known if is_flown else None)
        self._kept = self._leader.kept
        if not is_flown:
            self._begun.begin(identity, self._kept)
        if self._battery is not None and self._readings is not None:
            self._readings.begin(self._time.now_s, self._battery.charge)
        if self.here is not None:
            self._barrier.note_map(self.here.stamp_s)
        self._map_came_s, self._told_s = self._time.now_s, -math.inf
        self._is_due, self.is_active = False, True
        self._trust.begin()
        self._out.append(out.Say("info", words))

    def _finish(self) -> None:
        """End the action at home, or where the UAV must land."""
        if not self.is_active or self._looks or self._new is not None:
            return
        outcome = self._leader.outcome()
        if outcome is None:
            return
        self.is_active = self._is_due = False
        self._begun.end()
        if outcome.must_land:
            self._out.append(out.Say("warn", f"The UAV must land here: {outcome.words}"))
        self._out.append(out.Say("warn" if outcome.end == "aborted" else "info", outcome.log))
        if self._flown is not None:
            self._out.append(out.Finish(self._flown, out.End(outcome.end), outcome.words, has_result=True))
        self._flown = None

    # poses, map, battery

    def _on_told(self, message: Any) -> None:
        pose = self._barrier.take(message, self.is_active)
        if pose is None:
            return
        before = self._sent
        if pose.place_m is not None:
            self._follow(pose, pose.place_m)
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
            self._begun.note(self._kept)
        self._tell(here, is_new)

    def _note_step(self, step_s: float, stamp_s: float) -> None:
        words = f"The poses' clock was set by {step_s:+.1f} s; the {self._p.name} goes on."
        self._out.append(out.Say("warn", words))
        self._barrier.note_map(stamp_s)
        if step_s < 0.0:
            self._newest_stamp_s = -math.inf

    def _send(self) -> None:
        setpoint = self._leader.setpoint
        new = setpoint if setpoint is not self._sent else None
        self._sent = self._sent if setpoint is None else setpoint
        self._out.append(out.Send(new, self.here))

    def _tell(self, here: Here, is_new_setpoint: bool) -> None:
        is_early = 0.0 <= here.time_s - self._told_s < self._p.tell_s
        if is_early and not (is_new_setpoint and self._p.tells_setpoints):
            return
        self._told_s = here.time_s
        self._out.append(out.Tell(self._flown, here, None if self._battery is None else self._battery.more))
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
        self._map_came_s = self._time.of_other(map_came.stamp_s, MAP_SILENT_S)

    def _on_battery(self, battery: came.Battery) -> None:
        self._battery = battery
        if self._readings is not None:
            self._readings.add(self._time.of_other(battery.stamp_s), battery.charge)

    # what people ask for

    def _on_command(self, command: came.Command) -> None:
        if not command.reply.set_running_or_notify_cancel():
            return  # nobody waits for the answer any more
        is_flown = self.is_active and self.here is not None
        answer = came.Answer(is_flown, self._act(command.name) if is_flown else self._p.idle)
        waited_for = self._leader.stop_waiting() if command.name == "abort" else ""
        if waited_for and not is_flown:
            answer = came.Answer(True, waited_for)
        if answer.success:
            self._out.append(out.Say("info", answer.words))
        self._out.append(out.Reply(command.reply, answer))

    def _act(self, name: str) -> str:
        if name == "pause":
            assert self.here is not None
            self._leader.pause(self.here)
        elif name == "resume":
            self._leader.resume()
        else:
            self._abort()
            return "The UAV comes home."
        self._send()
        return "The UAV hovers." if name == "pause" else f"The {self._p.name} goes on."

    def _abort(self) -> None:
        self._leader.abort(ABORTED)
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
            readings = () if self._readings is None else tuple(self._readings.take())
            self._is_due, self._looks, self._end_before = False, True, self._leader.end
            self._out.append(out.Look(self.here, readings))
        elif self._p.rests and not self.is_active and self._now_s() >= self._rested_s + REST_S:
            self._looks, self._rested_s = True, self._now_s()
            self._out.append(out.Look(None))

    def _on_looked(self, looked: came.Looked) -> None:
        self._looks = False
        self._out += [out.Say("rarely", sentence) for sentence in looked.warnings]
        if self.is_active:
            if not self._end_before and self._leader.end:
                words = f"The {self._p.name} ends ({self._leader.end}): {self._leader.reason}"
                self._out.append(out.Say("info", words))
            self._send()
        self._out.append(out.Settled())
