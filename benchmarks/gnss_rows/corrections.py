"""SLAM's corrections in flight: a loop closure, or a new map after a restart, must not step the velocity.

A second position controller begins as a copy of the flying one when SLAM moves the UAV in its map. It gets
the same poses without this correction. The difference of both commands is the correction's doing.
"""

from __future__ import annotations

import copy
import math
from typing import Sequence

import numpy as np

from flights.flight.closed_loop import ClosedLoop
from flights.flight.course import Phase
from flights.flight.without_gnss import SLAM, Outage
from gridslam import se2
from gridslam.odometry.warm_up import warm_up_odometry
from gridslam.warm_up import warm_up
from master_thesis.experiments_3_4.without_gnss.flight import SlamPose, parameters_without_gnss
from simulation_tools.geometry import Pose, Vector3

EVENT_M = 0.02
"""SLAM has corrected the UAV's place by at least this much from one scan to the next."""
WATCHED_S = 0.5
"""Both commands are compared for this time."""
RESTARTS, DEAD_S = 4, 0.5


class CorrectionWatch:
    """Compares the commands with and without each correction. Ask it in place of the `SlamPose`.

    events: (size in m, greatest difference of the velocity in m/s).
    """

    def __init__(self, loop: ClosedLoop, slam: SlamPose) -> None:
        self._loop, self._slam = loop, slam
        self._before = slam.map_to_odom
        self._until_s = -math.inf
        self._velocity_m_s: Vector3 | None = None
        self.events: list[list[float]] = []
        loop.correct = self.of

    def of(self, t_s: float, pose: Pose) -> tuple[Vector3, float]:
        """Return position and heading in `map`, as `SlamPose.of` does."""
        self._slam.settle(t_s)
        before, self._before = self._before, self._slam.map_to_odom
        here = np.array([pose.position_m[:2]])
        size_m = math.dist(*(se2.transform(by[:3], here)[0] for by in (before, self._before)))
        if size_m >= EVENT_M and t_s > self._until_s:
            self._until_s, self._frozen = t_s + WATCHED_S, before
            self._controller = copy.deepcopy(self._loop.position_controller)
            self._correction = copy.deepcopy(self._slam.slow)
            self.events.append([size_m, 0.0])
        self._velocity_m_s = self._without(t_s, pose) if t_s <= self._until_s else None
        return self._slam.of(t_s, pose)

    def _without(self, t_s: float, pose: Pose) -> Vector3:
        setpoint_m = self._loop.position_controller.setpoint_m
        if setpoint_m is not None:
            self._controller.set_setpoint(setpoint_m)
        x, y, yaw, z = self._frozen
        turn = (0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2))
        place = self._correction.apply(t_s, (pose.position_m, pose.yaw_rad), (x, y, z), turn)
        return self._controller.update(t_s, *place).velocity_m_s

    def compare(self) -> None:
        """Compare with the newest command; call it after each step of the loop."""
        if self._velocity_m_s is not None:
            command = self._loop.log.v_ref.rows[-1][1:4]
            self.events[-1][1] = max(self.events[-1][1], math.dist(command, self._velocity_m_s))


def fly(kind: str, seed: int) -> dict:
    """Fly the round of Experiment 4; return the events and the greatest change between two commands, m/s.

    kind: closure: SLAM closes the loop. restart: SLAM dies for `DEAD_S`, `RESTARTS` times, and begins a new
    map each time.
    """
    warm_up()
    warm_up_odometry()
    rng = np.random.default_rng(seed)
    with ClosedLoop(parameters_without_gnss("hold", "ust", seed)) as loop:
        slam = SlamPose(loop, "hold", seed)
        watch = CorrectionWatch(loop, slam)
        loop.run_to(Phase.FLYING)
        begins_s = loop.time_s + np.cumsum(rng.uniform(8.0, 18.0, RESTARTS)) if kind == "restart" else []
        deaths = [Outage(SLAM, t_s, DEAD_S) for t_s in begins_s]
        while Phase.HOVERING not in loop.outcome.times_s and not loop.is_over:
            if deaths and loop.time_s >= deaths[0].begins_s:
                loop.outage = deaths.pop(0)
            loop.step()
            watch.compare()
        flying = np.array(loop.log.v_ref.rows)
        flying = flying[flying[:, 0] >= loop.outcome.times_s[Phase.FLYING], 1:4]
        outcome = loop.run()
    return {
        "flown": outcome.reached_goal and outcome.landed,
        "contact": outcome.collision,
        "events": watch.events,
        "between_m_s": float(np.linalg.norm(np.diff(flying, axis=0), axis=1).max()),
    }


def summary(trials: Sequence[dict]) -> dict:
    """Return counts, the sizes of the corrections in m, and the worst steps of the command in m/s."""
    events = [event for trial in trials for event in trial["events"]]
    sizes_m, steps_m_s = zip(*events) if events else ((0.0,), (0.0,))
    return {
        "flights": len(trials),
        **{key: sum(trial[key] for trial in trials) for key in ("flown", "contact")},
        "events": len(events),
        "moved_m": {"median": float(np.median(sizes_m)), "worst": max(sizes_m)},
        "step_m_s": {"median": float(np.median(steps_m_s)), "worst": max(steps_m_s)},
        "between_m_s": {"worst": max(trial["between_m_s"] for trial in trials)},
    }
