"""Records CEPA's inputs in flights of the ROS-free closed loop."""

from __future__ import annotations

from typing import NamedTuple, Sequence

from cepa import Cloud, Decision, Improved, LaserScan2D, Motion
from cepa.algorithm import Algorithm
from master_thesis.flight.closed_loop import CEPA, ClosedLoop, ClosedLoopParameters
from master_thesis.flight.course import Phase


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

    def steer(
        self,
        scan: LaserScan2D,
        v_ref_xy: Sequence[float],
        v_uav_xy: Sequence[float] = (0.0, 0.0),
        motion: Motion | None = None,
        cloud: Cloud | None = None,
    ) -> Decision:
        """Let the algorithm answer."""
        self.questions.append(Question(scan, tuple(v_ref_xy), tuple(v_uav_xy)))
        return self._algorithm.steer(scan, v_ref_xy, v_uav_xy, motion, cloud)


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
