"""Which photographs are still to be taken, which are done, and which are left out and why.

One that failed is tried again (retry), and one that fails too often is left out.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Collection, Sequence

from inspection.survey.views.candidates import View


@dataclass(frozen=True)
class Task:
    """A photograph to take. view: of the camera.

    number: from 1, those of the plan and then more of their kind; below 0: a closer look.
    """

    number: int
    view: View


class PhotographQueue:
    """The photographs of a plan in its order, and those that are added.

    Args:
        views: of the plan. done: numbers of those that are stored already. tries: see the parameters.

    Attributes:
        done: numbers that are taken; below 0: closer looks. left_out: by number, why it cannot be taken.
        shots: of the shutter. Each photograph that is stored already was one.
    """

    def __init__(self, views: Sequence[View], done: Collection[int] = (), tries: int = 3) -> None:
        self.tasks = tuple(Task(number, view) for number, view in enumerate(views, start=1))
        self._open = deque(task for task in self.tasks if task.number not in done)
        self._tries, self._failures = tries, dict[int, int]()
        self._biases_ev: dict[int, list[float]] = {}
        self.done = {number for number in done if number <= len(self.tasks)}
        self.left_out: dict[int, str] = {}
        self.shots = len(self.done)
        self._closer = min((0, *done))  # a folder may hold closer looks already

    @property
    def next(self) -> Task | None:
        """The photograph to take now; None: nothing is open."""
        return self._open[0] if self._open else None

    @property
    def open(self) -> tuple[Task, ...]:
        """What is still to be taken, in its order."""
        return tuple(self._open)

    @property
    def views_left_out(self) -> list[View]:
        """Photographs that cannot be taken."""
        return [task.view for task in self.tasks if task.number in self.left_out]

    def summary(self) -> str:
        """Return in a sentence what is taken, if nothing is open."""
        left, closer = [number for number in self.left_out if number > 0], sum(n < 0 for n in self.done)
        nearer = f" {closer} more are taken from nearer." if closer else ""
        if left:
            why = self.left_out[min(left)].rstrip(".")  # the others often have the same reason
            told = f"{len(left)} of {len(self.tasks)} photographs cannot be taken; all others are."
            return f"{told}{nearer} Photograph {min(left)}: {why}."
        return f"Every photograph of the plan is taken.{nearer}"

    def note_shot(self) -> None:
        """The shutter has opened, be the photograph good or not."""
        self.shots += 1

    def note_done(self, task: Task) -> None:
        """It was shot well, so the next one is due."""
        self._remove(task)
        self.done.add(task.number)
        self.left_out.pop(task.number, None)

    def note_failure(self, task: Task, why: str, at_once: bool = False) -> None:
        """It failed. It comes again at the end, or once at once; after some failures it is left out.

        A task that counts as done is open again: its picture was lost.
        """
        self.done.discard(task.number)
        self._remove(task)
        failures = self._failures[task.number] = self._failures.get(task.number, 0) + 1
        if failures >= self._tries:
            self.left_out[task.number] = why
        elif at_once and failures == 1:
            self._open.appendleft(task)
        else:
            self._open.append(task)

    def expose_again(self, task: Task, bias_ev: float) -> None:
        """It was exposed badly: it comes next, with this exposure compensation. That is no failure."""
        self.done.discard(task.number)
        self._remove(task)
        self._biases_ev.setdefault(task.number, []).append(bias_ev)
        self._open.appendleft(task)

    def bias_of(self, task: Task) -> float:
        """Return the exposure compensation, EV, with which it is to be taken."""
        return self._biases_ev.get(task.number, [0.0])[-1]

    def exposures_of(self, task: Task) -> int:
        """Return how many exposures of it were bad."""
        return len(self._biases_ev.get(task.number, ()))

    def note_stored(self, stored: Collection[int]) -> None:
        """Open again what counts as taken, but is not stored any more. stored: numbers of what is."""
        gone = [task for task in self.tasks if task.number in self.done and task.number not in stored]
        self.done -= {task.number for task in gone}
        self._open += gone

    def failures_of(self, task: Task) -> int:
        """Return how often it has failed."""
        return self._failures.get(task.number, 0)

    def look_closer(self, view: View) -> Task:
        """Put a photograph before all others, and return it."""
        task = self._closer_task(view)
        self._open.appendleft(task)
        return task

    def add(self, views: Sequence[View]) -> None:
        """Put photographs of the plan's kind after all others."""
        first = len(self.tasks) + 1
        more = tuple(Task(number, view) for number, view in enumerate(views, start=first))
        self.tasks += more
        self._open += more

    def look_again(self, views: Sequence[View]) -> None:
        """Put closer photographs after all others."""
        self._open += map(self._closer_task, views)

    def _closer_task(self, view: View) -> Task:
        self._closer -= 1
        return Task(self._closer, view)

    def _remove(self, task: Task) -> None:
        self._open = deque(each for each in self._open if each.number != task.number)
