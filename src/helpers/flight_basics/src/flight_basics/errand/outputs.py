"""What an errand puts into its outbox. Whoever runs the errand carries it out, in this order."""

from __future__ import annotations

from concurrent.futures import Future
from enum import Enum
from typing import Any, NamedTuple

import numpy as np

from flight_basics.errand.leader import Here
from flight_basics.errand.messages import Answer, Goal, Question


class End(Enum):
    """How an action ends, in actionlib's words."""

    SUCCEEDED = "succeeded"
    ABORTED = "aborted"
    CANCELED = "canceled"


class Accept(NamedTuple):
    """Tell a goal's sender that it is taken."""

    goal: Goal


class Finish(NamedTuple):
    """End a goal, once. has_result: with the leader's result; else with an empty one that says `words`."""

    goal: Goal
    end: End
    words: str
    has_result: bool = False


class Send(NamedTuple):
    """Send where to fly. setpoint: None: it is not new. here: where the UAV is; None: unknown."""

    setpoint: Any
    here: Here | None


class Tell(NamedTuple):
    """Publish feedback for a goal (None: nobody waits for one any more), and what RViz shows."""

    goal: Goal | None
    here: Here
    battery: Any


class Acknowledge(NamedTuple):
    """In lockstep, acknowledge a scan."""

    header: Any


class Reply(NamedTuple):
    """Answer a person."""

    to: Future[Any]
    answer: Answer


class Say(NamedTuple):
    """Log a sentence. level: info, warn, or rarely: a warning that may come again and again."""

    level: str
    words: str


class Prepare(NamedTuple):
    """Let the worker read what a goal names; it puts `Prepared`."""

    goal: Goal


class Look(NamedTuple):
    """Let the worker decide; it puts `Looked`. here: where the UAV is; None: nothing is flown, it may rest.

    readings: charges of the battery since the last look: time in s, and 0..1.
    """

    here: Here | None
    readings: tuple[tuple[float, float], ...] = ()


class Ask(NamedTuple):
    """Let the worker answer a question. place_m: of the UAV (x, y, z); None: it is not known."""

    question: Question
    place_m: np.ndarray | None


class Settled(NamedTuple):
    """The worker has decided, and its outcome is sent: what else is to be told of it may be told now."""


Output = Accept | Finish | Send | Tell | Acknowledge | Reply | Say | Prepare | Look | Ask | Settled
