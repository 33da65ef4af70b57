#!/usr/bin/env python3
"""Runs a node, and writes down if its threads take locks in orders that may block each other for ever.

A launch file names it as `launch-prefix`. One thread that takes lock B while it holds A, and one that takes A
while it holds B, need not meet in a test; that both orders occur is seen at once. The test takes the report.
"""

from __future__ import annotations

import os
import runpy
import sys
import threading
import traceback
from pathlib import Path

KEPT = threading.local()
"""held: locks of this thread, in their order."""
AFTER: dict[int, set[int]] = {}
"""By a lock: those that were taken while it was held."""
NAMES: dict[int, str] = {}
GUARD = threading.Lock()


def report_of(node: str) -> Path:
    """Return the file with the orders that do not go together; there is none if they all do."""
    logs = os.environ.get("ROS_LOG_DIR") or os.path.expanduser("~/.ros/log")
    return Path(logs) / f"lock_order_{Path(node).name}.txt"


def take_report(node: str) -> str:
    """Return what was written down for a node, and remove it; empty: its locks have one order."""
    report = report_of(node)
    text = report.read_text(encoding="utf-8") if report.exists() else ""
    report.unlink(missing_ok=True)
    return text


def held() -> list[int]:
    """Return the locks of this thread."""
    if not hasattr(KEPT, "held"):
        KEPT.held = []
    return KEPT.held


def leads_to(begin: int, end: int) -> list[int]:
    """Return locks from one to another, each of which was taken while the one before was held."""
    ways, seen = [[begin]], {begin}
    while ways:
        way = ways.pop()
        if way[-1] == end:
            return way
        for after in AFTER.get(way[-1], set()) - seen:
            seen.add(after)
            ways.append([*way, after])
    return []


def note(wanted: int) -> None:
    """Note that this thread waits for a lock."""
    if wanted in held():
        return
    with GUARD:
        for lock in held():
            if wanted in AFTER.setdefault(lock, set()):
                continue
            circle = leads_to(wanted, lock)
            AFTER[lock].add(wanted)
            if circle:
                names = " -> ".join(NAMES[each] for each in (lock, *circle))
                stack = "".join(traceback.format_stack(limit=12))
                with REPORT.open("a", encoding="utf-8") as report:
                    report.write(f"{names}\n{stack}\n")


class WatchedLock:
    """A lock whose orders are noted. It lives as long as the process, or another one could get its number."""

    def __init__(self, lock: object) -> None:
        self._lock = lock
        caller = sys._getframe(2)
        NAMES[id(self)] = f"{Path(caller.f_code.co_filename).name}:{caller.f_lineno}"
        ALL.append(self)

    def acquire(self, blocking: bool = True, timeout: float = -1) -> bool:
        if blocking and timeout < 0:
            note(id(self))
        is_taken = self._lock.acquire(blocking, timeout)
        if is_taken:
            held().append(id(self))
        return is_taken

    def release(self) -> None:
        self._lock.release()
        if id(self) in held():  # a plain lock may be given back by another thread
            held().reverse()
            held().remove(id(self))
            held().reverse()

    def __enter__(self) -> bool:
        return self.acquire()

    def __exit__(self, *_: object) -> None:
        self.release()

    def locked(self) -> bool:
        return self._lock.locked()

    def _at_fork_reinit(self) -> None:
        self._lock._at_fork_reinit()


class WatchedRLock(WatchedLock):
    """What a condition asks of a lock that a thread may take several times."""

    def _release_save(self) -> tuple[object, int]:
        times = held().count(id(self))
        KEPT.held = [each for each in held() if each != id(self)]
        return self._lock._release_save(), times

    def _acquire_restore(self, saved: tuple[object, int]) -> None:
        note(id(self))
        self._lock._acquire_restore(saved[0])
        held().extend([id(self)] * saved[1])

    def _is_owned(self) -> bool:
        return self._lock._is_owned()


ALL: list[WatchedLock] = []

if __name__ == "__main__":
    lock, rlock = threading.Lock, threading.RLock
    REPORT = report_of(next(word for word in sys.argv if word.startswith("__name:=")).partition(":=")[2])
    REPORT.parent.mkdir(parents=True, exist_ok=True)
    threading.Lock, threading.RLock = lambda: WatchedLock(lock()), lambda: WatchedRLock(rlock())
    del sys.argv[0]
    sys.path[0] = os.path.dirname(sys.argv[0])
    runpy.run_path(sys.argv[0], run_name="__main__")
