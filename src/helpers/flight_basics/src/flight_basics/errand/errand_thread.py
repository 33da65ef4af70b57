"""The thread of an errand, and that of its worker."""

from __future__ import annotations

import threading
from concurrent.futures import TimeoutError as TooLateError
from functools import partial
from typing import Any, Callable

from flight_basics.errand import messages as came
from flight_basics.errand import outputs as out
from flight_basics.errand.errand import Errand
from flight_basics.errand.inbox import Inbox, Worker
from flight_basics.errand.leader import Leader
from flight_basics.errors import FlightBasicsError

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
            the worker. on_error: told what ends a thread, in that thread.

    Attributes:
        worker: does what takes long; the planner's map belongs to its thread.
    """

    def __init__(
        self,
        errand: Errand,
        leader: Leader,
        carry_out: Callable[[out.Output], None],
        on_error: Callable[[Exception], None],
    ) -> None:
        self._errand, self._leader = errand, leader
        self._carry_out, self._on_error = carry_out, on_error
        self._inbox = Inbox()
        self._is_closing = False
        self.worker = Worker("worker", on_error)
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
        try:
            while not self._is_closing:
                message = self._inbox.get(WAKE_S)
                for output in self._errand.take(came.Tick() if message is None else message):
                    self._give(output)
        except Exception as error:
            self._on_error(error)

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
        try:
            self.put(came.Prepared(goal, self._leader.prepare(goal.content)))
        except FlightBasicsError as error:
            self.put(came.Prepared(goal, why=str(error)))

    def _look(self, look: out.Look) -> None:
        if look.here is None:
            self._leader.rest()
            self.put(came.Looked())
        else:
            self.put(came.Looked(tuple(self._leader.look(look.here, look.readings))))

    @staticmethod
    def _answer(asked: out.Ask) -> None:
        try:
            answer = asked.question.answer(asked.place_m)
        except FlightBasicsError as error:
            answer = came.Answer(False, str(error))
        asked.question.reply.set_result(answer)
