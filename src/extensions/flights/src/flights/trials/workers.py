"""Runs the trials: in this process, or in processes of Dask."""

from __future__ import annotations

import argparse
import contextlib
import os
import sys
import threading
from typing import Callable, ContextManager, Iterator, NoReturn, Protocol, Sequence, TypeVar

Task = TypeVar("Task")
Result = TypeVar("Result")

INTERRUPTED = 130
"""Exit code after Ctrl-C, like a shell's."""

FREEING_S = 2.0
"""Wall time to free the semaphores of workers that were killed."""


class Workers(Protocol):
    """Runs tasks."""

    def results(
        self, run: Callable[[Task], Result], tasks: Sequence[Task]
    ) -> Iterator[tuple[Task, Result | Exception]]:
        """Run tasks and yield each with its result when it is finished.

        If a task's process died repeatedly, the result is an exception.
        """

    def kill(self) -> None:
        """End running tasks at once."""


class ThisProcess:
    """Runs one task after the other in this process."""

    def results(
        self, run: Callable[[Task], Result], tasks: Sequence[Task]
    ) -> Iterator[tuple[Task, Result | Exception]]:
        """Run tasks and yield them with their results."""
        for task in tasks:
            yield task, run(task)

    def kill(self) -> None:
        """Do nothing, because the caller itself runs the tasks."""


def count(text: str) -> int:
    """Return a number of processes or trials, 1 or more; argparse tells the user if it is none."""
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"give a whole number from 1 on, not '{text}'")
    return int(text)


def open_workers(number: int | None = None, scheduler: str | None = None) -> ContextManager[Workers]:
    """Return this process for one worker, else processes of Dask. Use it as a context manager.

    number: of local processes; default: as many as cores. scheduler: of a cluster, see `DaskWorkers`.

    Raises:
        TrialsError: the scheduler cannot be reached.
    """
    if scheduler is None and (number or os.cpu_count()) == 1:
        return contextlib.nullcontext(ThisProcess())
    from flights.trials.dask_workers import DaskWorkers  # takes half a second to import

    return DaskWorkers(number, scheduler)


def interrupted(said: str) -> int:
    """Say what Ctrl-C did, and return the exit code.

    Ctrl-C can leave objects half made, for example while numba loads code. They raise when Python deletes
    them after this, and nobody wants to read that.
    """
    sys.unraisablehook = lambda _: None
    print(said, file=sys.stderr, flush=True)
    return INTERRUPTED


def end(code: int) -> NoReturn:
    """End this process with an exit code. After Ctrl-C end at once, because Dask shuts down slowly."""
    if code != INTERRUPTED:
        sys.exit(code)
    _free_semaphores()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


def _free_semaphores() -> None:
    """Free those of multiprocessing, as Python's own exit does first; else its tracker tells of leaks.

    A worker that just starts would not find its own, so none may live.
    """
    import multiprocessing.util

    for child in multiprocessing.active_children():
        child.kill()
    free = multiprocessing.util._run_finalizers  # type: ignore[attr-defined]
    freeing = threading.Thread(target=free, args=(0,), daemon=True)
    freeing.start()
    freeing.join(FREEING_S)
