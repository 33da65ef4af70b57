"""Watches one run: keeps its log, controls its course, and measures its wall time.

The experiment's node passes messages on to it. The closed loop without ROS calls it directly.
"""

from __future__ import annotations

import time
from typing import Callable, Sequence

from flights.flight.course import Action, Course, Phase, PhaseLimits
from flights.flight.flight_log import FlightLog
from flights.flight.judging.contacts import UavParts
from flights.flight.judging.own_descent import OwnDescent
from flights.flight.judging.wall_metrics import WallMetrics
from stamp_pairing.clock_steps import clock_step_s

CLOCK_TOLERANCE_S = 0.5
_LATENCY_KEYS = {
    "median": "setpoint_latency_ms_median",
    "p99": "setpoint_latency_ms_p99",
    "count": "setpoint_latency_count",
}


class Monitor:
    """The log, the course and the wall time of one run. Not thread-safe."""

    def __init__(
        self, limits: PhaseLimits, uav: UavParts, wall_clock: Callable[[], float] = time.perf_counter
    ) -> None:
        """Watch a UAV; wall_clock: seconds of wall time from any origin."""
        self.log = FlightLog()
        self.course = Course(limits, uav, self.log.truth)
        self._descent = OwnDescent()
        self._wall_clock = wall_clock
        self._wall_s: dict[Phase, float] = {}
        self._performance: dict[str, float] = {}

    @property
    def now_s(self) -> float:
        """Simulation time of the newest true pose."""
        rows = self.log.truth.rows
        return rows[-1][0] if rows else 0.0

    @property
    def has_begun(self) -> bool:
        """Whether the wait for the hover is over."""
        return self.course.phase is not Phase.WAITING

    def on_waiting(self, reason: str) -> None:
        """Note why the UAV does not hover yet, in words; empty: it hovers."""
        self.course.on_waiting(reason)
        self._descent.on_reason(reason)

    def on_truth(
        self, t_s: float, position_m: Sequence[float], orientation_xyzw: Sequence[float], decide: bool = True
    ) -> list[Action]:
        """Take the true pose in `world`. Return the actions, unless `decide` is called later."""
        before_s = self.now_s
        if t_s < before_s - CLOCK_TOLERANCE_S:
            return self.abort("The clock jumped back: the simulation was reset.")
        truth = self.log.truth
        step_s = clock_step_s(before_s, t_s) if truth.rows else 0.0
        if step_s > 0.0:
            self.course.on_clock_set(step_s)
        truth.add(t_s, *position_m, *orientation_xyzw)
        return self.decide() if decide else []

    def decide(self) -> list[Action]:
        """Return the actions at the time of the newest true pose."""
        return self._noted(self.course.on_time(self.now_s))

    def on_goal_reached(self, reached: bool) -> None:
        """Note that the position controller has reached the goal."""
        self.course.on_goal_reached(self.now_s, reached)
        self._noted([])

    def land_here(self, why: str) -> None:
        """Note that the UAV must land where it is, and that the run fails; `why` is a sentence."""
        self.course.land_here(why)

    def land_between(self) -> None:
        """Note that the UAV is told to land between two parts of its flight."""
        self.course.land_between(self.now_s)

    def fly_on(self) -> None:
        """Note that the UAV hovers again after it has landed between two parts."""
        self.course.fly_on(self.now_s)

    def stay_landed(self) -> list[Action]:
        """Note that the UAV, which has landed between two parts of its flight, takes off no more."""
        return self._noted(self.course.stay_landed(self.now_s))

    def on_contact(self, t_s: float, collision_1: str, collision_2: str, upwards: float = 0.0) -> None:
        """Note a contact between two collision shapes; `upwards` as in `Contacts.classify`."""
        self.log.contacts.add_simultaneous(t_s, collision_1, collision_2)
        self.course.on_contact(t_s, collision_1, collision_2, upwards)

    def on_armed(self, armed: bool) -> list[Action]:
        """Note whether the motors may turn. Return the actions."""
        return self._noted(self.course.on_armed(self.now_s, armed))

    def on_mode(self, mode: str) -> None:
        """Note the flight controller's mode, by MAVROS's name."""
        self._descent.on_mode(self.now_s, mode)
        self.course.on_own_descent(self.now_s, self._descent.sentence)

    def on_text(self, severity: int, text: str) -> None:
        """Note a message of the flight controller to people; severity: MAV_SEVERITY."""
        self._descent.on_text(self.now_s, severity, text)
        self.course.on_own_descent(self.now_s, self._descent.sentence)

    def on_charge(self, charge: float) -> None:
        """Note the battery's charge, 0..1."""
        self._descent.on_charge(charge)

    def on_landed(self, on_ground: bool) -> None:
        """Note whether the flight controller believes that the UAV stands on the ground."""
        self.course.on_landed(self.now_s, on_ground)

    def on_performance(self, measured: dict[str, float]) -> None:
        """Take the simulator's own measurements. The newest ones count."""
        self._performance = measured

    def abort(self, why: str) -> list[Action]:
        """End the run at once, unless it is over; `why` is a sentence."""
        return self._noted(self.course.abort(self.now_s, why))

    def wall_metrics(self, started_s: float) -> WallMetrics:
        """Return the metrics of wall time. started_s: the wall clock at the run's start."""
        wall, measured = self._wall_s, self._performance
        latency = None
        if measured.get("setpoint_latency_count"):
            latency = {key: measured[name] for key, name in _LATENCY_KEYS.items()}
            latency["count"] = int(latency["count"])
        misses = measured.get("lockstep_misses")
        return WallMetrics(
            real_time_factor=self._real_time_factor(),
            latency_ms=latency,
            lockstep_misses=None if misses is None else int(misses),
            wall_time_s=self._wall_clock() - started_s,
            wall_time_to_ready_s=wall[Phase.FLYING] - started_s if Phase.FLYING in wall else None,
        )

    def _real_time_factor(self) -> float | None:
        """Return the factor from sending the goal to reaching it, or to the end of a failed run."""
        times, wall = self.course.outcome.times_s, self._wall_s
        end = next((phase for phase in (Phase.HOVERING, Phase.LANDING, Phase.DONE) if phase in times), None)
        if Phase.FLYING not in times or end is None or wall[end] <= wall[Phase.FLYING]:
            return None
        return (times[end] - times[Phase.FLYING]) / (wall[end] - wall[Phase.FLYING])

    def _noted(self, actions: list[Action]) -> list[Action]:
        if len(self._wall_s) != self.course.phases_begun:
            for phase in filter(self.course.has_begun, Phase):
                self._wall_s.setdefault(phase, self._wall_clock())
        return actions
