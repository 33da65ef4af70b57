"""Flies a trial to its end: the goal, the first contact, or giving up."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Sequence

import numpy as np

from cepa.algorithm import Algorithm
from flights.campaign.places import STUCK_S
from flights.errors import FlightError
from flights.flight.closed_loop import ClosedLoop, ScanListener
from flights.flight.course import Phase
from flights.flight.parameters import ClosedLoopParameters
from flights.results.clearance import FARTHEST_M, distances_in
from flights.results.metrics import path_length_m

CLEARANCE_STEP_M = 0.05


@dataclass(frozen=True)
class Flight:
    """What came of a flight, from the goal's sending on.

    end: "goal", "collision" or "stuck". time_s: until then. poses: true, (n, 8: t, position, quaternion).
    clearance_m: least distance between the UAV's shape and anything but the ground, up to FARTHEST_M.
    emergencies: scans that the emergency avoidance answered. mass_kg: of the UAV with its lidar.
    computation_ms: CPU time of each answer of the algorithm (n,).
    """

    end: str
    time_s: float
    poses: np.ndarray
    clearance_m: float
    emergencies: int
    mass_kg: float
    computation_ms: np.ndarray

    @property
    def path_length_m(self) -> float:
        """Length of the true path."""
        return path_length_m(self.poses[:, 1:4])

    def columns(self) -> dict[str, Any]:
        """Return the columns of the table that every kind of flight has."""
        return {
            "collision": self.end == "collision",
            "stuck": self.end == "stuck",
            "flight_time_s": self.time_s,
            "path_length_m": self.path_length_m,
            "min_clearance_m": self.clearance_m,
            "emergencies": self.emergencies,
            "mass_kg": self.mass_kg,
        }


def fly_to_goal(
    parameters: ClosedLoopParameters,
    steering: Algorithm | None = None,
    stuck_s: float = STUCK_S,
    listeners: Sequence[ScanListener] = (),
) -> Flight:
    """Fly to `parameters.goal_xyz_m`; steering: in place of the algorithm by its name.

    listeners: get each scan before it steers.

    It ends at the goal, at the first contact, or after stuck_s without coming nearer to the goal.

    Raises:
        FlightError: the UAV never hovered over the start.
    """
    with ClosedLoop(parameters, steering) as loop:
        loop.listeners += listeners
        begin(loop)
        watch = _Watch(loop, stuck_s)
        loop.run(until=watch.over)
        return flight_of(loop)


def begin(loop: ClosedLoop) -> None:
    """Fly until the goal has been sent; raises FlightError when it never was."""
    outcome = loop.run_to(Phase.FLYING)
    if Phase.FLYING not in outcome.times_s:
        raise FlightError(outcome.failure or "The UAV never hovered over the start.")


class _Watch:
    """Ends a flight at the goal, at the first contact, or when it is stuck."""

    def __init__(self, loop: ClosedLoop, stuck_s: float) -> None:
        self._stuck_s = stuck_s
        assert loop.parameters.goal_xyz_m is not None
        self._goal_xy = loop.parameters.goal_xyz_m[:2]
        self._nearest_m, self._since_s = math.inf, loop.time_s

    def over(self, loop: ClosedLoop) -> bool:
        """Tell whether the flight is over, or stuck."""
        _, x, y, *_ = loop.log.truth.rows[-1]
        distance_m = math.hypot(self._goal_xy[0] - x, self._goal_xy[1] - y)
        if distance_m < self._nearest_m - 0.1:
            self._nearest_m, self._since_s = distance_m, loop.time_s
        return is_over(loop) or loop.time_s - self._since_s > self._stuck_s


def is_over(loop: ClosedLoop) -> bool:
    """Tell whether the goal was reached, the time is over, or something was touched."""
    ended = {Phase.HOVERING, Phase.LANDING, Phase.DONE} & loop.outcome.times_s.keys()
    return bool(ended or loop.outcome.touched)


def flight_of(loop: ClosedLoop) -> Flight:
    """Return what came of a closed loop's flight."""
    outcome, log = loop.outcome, loop.log
    start_s = outcome.times_s[Phase.FLYING]
    poses = log.between(start_s, loop.time_s)
    decisions = [row for row in log.decisions if row[0] >= start_s]
    return Flight(
        end="collision" if outcome.touched else "goal" if outcome.reached_goal else "stuck",
        time_s=float(poses[-1, 0] - start_s),
        poses=poses,
        clearance_m=_clearance_m(loop, poses),
        emergencies=sum(bool(row[4]) for row in decisions),
        mass_kg=float(loop.simulation.world.mass_kg(loop.simulation.uav_name)),
        computation_ms=np.array([row[1] for row in decisions], dtype=float),
    )


def _clearance_m(loop: ClosedLoop, poses: np.ndarray) -> float:
    world, uav = loop.simulation.world, loop.simulation.uav_name
    distances = distances_in(world, uav, poses, CLEARANCE_STEP_M, loop.outcome.ground)
    return float(min(distances[:, 1].min(initial=FARTHEST_M), FARTHEST_M))
