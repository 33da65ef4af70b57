"""The path that is published just after a closure, beside the best path that could be known then.

    python -m benchmarks.slam_rows.after_closures aces 1 DATA      log, seed, folder of the bags

prints metrics as JSON.
"""

from __future__ import annotations

import contextlib
import json
import sys
import tempfile
from pathlib import Path
from typing import Callable

import numpy as np
from gridslam_ros.replay import Replay, Topics
from sensor_msgs.msg import LaserScan

from benchmarks.slam_rows.logs import LOGS, by_poses
from gridslam.saved_sessions import load_session, save_session
from gridslam.session import SlamSession
from gridslam.trajectory import Trajectory

ErrorOf = Callable[[Trajectory], float]


class WatchedReplay(Replay):
    """A replay of a bag that judges the path whenever the closures have changed.

    Args:
        bag: to map.
        given: parameters by name.
        error_m: returns a path's error, m.
    """

    def __init__(self, bag: Path, given: dict, error_m: ErrorOf) -> None:
        super().__init__(str(bag), Topics(), given)
        self._error_m = error_m
        self.published_m: list[float] = []
        self.best_m: list[float] = []
        """Errors of the published path, and of that which `finish` gives if the log ends there."""

    def _process(self, scan: LaserScan) -> None:
        before = self._session.closures
        super()._process(scan)
        if self._session.closures != before:
            self.published_m.append(self._error_m(self._session.trajectory()))
            self.best_m.append(self._error_m(_finished(self._session).trajectory()))

    @property
    def published_by_best(self) -> float:
        """The root mean square of the first errors, by that of the second."""
        return float(np.linalg.norm(self.published_m) / np.linalg.norm(self.best_m))


def _finished(session: SlamSession) -> SlamSession:
    """Return a copy of a session, after the end of its log."""
    with tempfile.TemporaryDirectory() as folder:
        save_session(session, Path(folder, "state"))
        copy = load_session(Path(folder, "state"))
    copy.finish()
    return copy


def measure(name: str, seed: int, data: Path) -> dict:
    """Map a log of which the true poses are known. Return how the published paths err after its closures."""
    log = LOGS[name]

    def error_m(path: Trajectory) -> float:
        return by_poses(path, data / log.truth)["ate_m"]

    replay = WatchedReplay(data / log.bag, log.given(seed, loop_closure=True), error_m)
    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(sys.stderr):
        replay.run(Path(folder))
    return {"published_by_best_after_closures": replay.published_by_best}


if __name__ == "__main__":
    name, seed, data = sys.argv[1:]
    print(json.dumps(measure(name, int(seed), Path(data))))
