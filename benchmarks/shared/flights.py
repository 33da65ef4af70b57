"""Records CEPA's inputs in flights of the ROS-free closed loop."""

from __future__ import annotations

from typing import NamedTuple

from cepa import Cloud, Decision, Improved, LaserScan2D, Motion
from cepa.algorithm import Algorithm
from cepa.decision import Vector2
from flights.flight.closed_loop import ClosedLoop
from flights.flight.course import Phase
from flights.flight.parameters import CEPA, ClosedLoopParameters


class Question(NamedTuple):
    """One input of CEPA: a scan, the reference and the own velocity (m/s, in the scan's frame)."""

    scan: LaserScan2D
    v_ref_xy: tuple
    v_uav_xy: tuple


class Recorder(Algorithm):
    """Passes every question on to an algorithm, and keeps the questions."""

    def __init__(self, algorithm: Algorithm) -> None:
        super().__init__(algorithm.parameters)
        self.questions: list[Question] = []
        self._algorithm = algorithm

    def _steer(
        self, scan: LaserScan2D, v_ref: Vector2, v_uav: Vector2, motion: Motion | None, cloud: Cloud | None
    ) -> Decision:
        self.questions.append(Question(scan, v_ref, v_uav))
        return self._algorithm.steer(scan, v_ref, v_uav, motion, cloud)


def record(parameters: ClosedLoopParameters) -> list[Question]:
    """Fly, and return CEPA's inputs from sending the goal to reaching it.

    Raises:
        RuntimeError: the flight failed, so its scans are useless.
    """
    recorder = Recorder(Improved(CEPA))
    with ClosedLoop(parameters, recorder) as loop:
        loop.run_to(Phase.FLYING)
        recorder.questions.clear()
        outcome = loop.run_to(Phase.HOVERING)
    if not outcome.reached_goal or outcome.collision:
        raise RuntimeError(f"{parameters.simulation.world}: {outcome.failure or 'the goal was not reached.'}")
    return recorder.questions
