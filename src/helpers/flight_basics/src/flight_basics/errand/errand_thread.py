"""The thread of an errand, and that of its worker."""

from __future__ import annotations

import math
import threading
import time
from concurrent.futures import TimeoutError as TooLateError
from functools import partial
from typing import Any, Callable

from flight_basics.errand import messages as came
from flight_basics.errand import outputs as out
from flight_basics.errand.errand import Errand
from flight_basics.errand.inbox import Inbox, Worker
from flight_basics.errand.leader import Leader
from flight_basics.errors import FlightBasicsError, sentence_of

WAKE_S = 0.5
"""Wall time after which the errand looks whether something is to do."""
ANSWER_S, LONG_ANSWER_S = 10.0, 60.0
"""Wall time that a person waits for an answer: of the errand, and of the worker, which may be deciding."""
MOST_WAITING = 200
"""While more messages wait, poses are left out: another one comes soon."""


class ErrandThread:
    """Runs an errand. Nobody else touches it, so there is no lock.

    Args:
        errand, leader: what is run. carry_out: called in the errand's thread with each output that is not for
            the worker. on_error: told what ends the errand's thread, in that thread. on_fault: told what a
            job of the worker has raised, which nobody expected; the worker goes on. clock_s: ROS's time.

    Attributes:
        worker: does what takes long; the planner's map belongs to its thread.
    """

    def __init__(
        self,
        errand: Errand,
        leader: Leader,
        carry_out: Callable[[out.Output], None],
        on_error: Callable[[Exception], None],
        on_fault: Callable[[Exception], None] = lambda _: None,
        clock_s: Callable[[], float | None] = lambda: None,
    ) -> None:
        self._errand, self._leader = errand, leader
        self._carry_out, self._on_error, self._on_fault = carry_out, on_error, on_fault
        self._clock_s = clock_s
        self._inbox = Inbox()
        self._is_closing = False
        self.worker = Worker("worker", on_fault)
        self._thread = threading.Thread(target=self._run, name="errand", daemon=True)

    def start(self) -> None:
        """Begin to take messages."""
        self._thread.start()

    def put(self, message: came.Message) -> None:
        """Put a message into the inbox; nobody waits."""
        if not isinstance(message, came.Pose) or self._inbox.waiting < MOST_WAITING:
            self._inbox.put(message)

    def ask(self, asked: came.Command | came.Question) -> Any:
        """Return the answer to a person, in any other thread; an `Answer` says so if none comes in time."""
        timeout_s = ANSWER_S if isinstance(asked, came.Command) else LONG_ANSWER_S
        self.put(asked)
        try:
            return asked.reply.result(timeout=timeout_s)
        except TooLateError:
            asked.reply.cancel()
            return came.Answer(False, f"There was no answer within {timeout_s:.0f} s. Ask again.")

    def close(self, timeout_s: float) -> bool:
        """Take no more messages. Return whether the last one is done, within a wall time."""
        self._is_closing = True
        self._inbox.put(came.Tick())
        if self._thread.is_alive() and self._thread is not threading.current_thread():
            self._thread.join(timeout_s)
        return not self._thread.is_alive()

    def _run(self) -> None:
        woke_s = -math.inf
        try:
            while not self._is_closing:
                message = self._inbox.get(WAKE_S)
                if message is None or time.monotonic() >= woke_s + WAKE_S:
                    woke_s = time.monotonic()
                    self._take(came.Tick(self._clock_s()))
                if message is not None:
                    self._take(message)
        except Exception as error:
            self._on_error(error)

    def _take(self, message: came.Message) -> None:
        for output in self._errand.take(message):
            self._give(output)

    def _give(self, output: out.Output) -> None:
        if isinstance(output, out.Prepare):
            self.worker.do(partial(self._prepare, output.goal))
        elif isinstance(output, out.Look):
            self.worker.do(partial(self._look, output))
        elif isinstance(output, out.Ask):
            self.worker.do(partial(self._answer, output))
        elif isinstance(output, out.Reply):
            output.to.set_result(output.answer)
        else:
            self._carry_out(output)

    # in the worker's thread

    def _prepare(self, goal: came.Goal) -> None:
        plan, why = self._told(lambda: self._leader.prepare(goal.content))
        self.put(came.Prepared(goal, plan, why))

    def _look(self, look: out.Look) -> None:
        here = look.here
        if here is None:
            self._told(self._leader.rest)
            self.put(came.Looked())
            return
        warnings, fault = self._told(lambda: self._leader.look(here, look.readings))
        self.put(came.Looked(tuple(warnings or ()), fault))

    def _answer(self, asked: out.Ask) -> None:
        answer, why = self._told(lambda: asked.question.answer(asked.place_m))
        asked.question.reply.set_result(came.Answer(False, why) if why else answer)

    def _told(self, work: Callable[[], Any]) -> tuple[Any, str]:
        """Return what a job returns, and what is wrong. Whatever it raises, the node flies on."""
        try:
            return work(), ""
        except Exception as error:
            if not isinstance(error, FlightBasicsError):
                self._on_fault(error)
            return None, sentence_of(error)
