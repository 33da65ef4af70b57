"""Runs a simulation in time: pacing, pausing, lockstep, and the requests of other threads between its steps.

One thread owns the simulation and calls `RunLoop.run`; everybody else goes through `RunLoop.call`. Nothing
here knows ROS. The protocol of stamps and lockstep is told in doc/how_it_works.md.
"""

from __future__ import annotations

import queue
import threading
import time
from concurrent.futures import Future
from concurrent.futures import TimeoutError as FutureTimeoutError
from dataclasses import dataclass, replace
from typing import Callable, Protocol

from simulation_tools.errors import SimulationToolsError
from simulation_tools.running.barrier import Barrier
from simulation_tools.running.performance import PerformanceFigures, PerformanceMeter
from simulation_tools.simulation import PhysicsDivergedError, Simulation, StepOutput

IDLE_S = 0.005
"""How long a paused or waiting loop sleeps before it looks for requests again."""

START_RETRY_S = 0.2
"""In lockstep the first scan is published again after this until the nodes that answer it have started."""

START_PATIENCE_S = 15.0
"""How long lockstep waits for the first answer before it asks where it may be."""

RELAPSE_US = 2_000_000
"""Physics that diverges again so soon after a reset will do so after every one."""

REPORT_PERIOD_S = 1.0
"""Wall time between two reports of the performance figures."""

FORGIVEN_LAG_S = 0.1
"""A loop further behind the wall clock than this does not catch up: no sprint after a stall."""


@dataclass(frozen=True)
class WallClock:
    """Where the loop reads the wall time, in s, and how it lets it pass; a test may bring another."""

    now: Callable[[], float] = time.perf_counter
    sleep: Callable[[float], None] = time.sleep


class RunLoopError(SimulationToolsError):
    """The run loop cannot do what it was asked to."""


@dataclass(frozen=True)
class PacingParameters:
    """How simulated time follows the wall clock.

    real_time_factor: simulated seconds per wall second, 0 = as fast as possible. lockstep: wait after each
    scan for the setpoint made from it. participants: names of further acknowledgements to wait for.
    lockstep_timeout_s: wall time after which a missing one is counted and left behind.
    """

    real_time_factor: float = 1.0
    lockstep: bool = False
    participants: frozenset[str] = frozenset()
    lockstep_timeout_s: float = 1.0

    def __post_init__(self):
        if not 0.0 <= self.real_time_factor < float("inf"):
            raise RunLoopError(
                f"real_time_factor must be 0 or a positive number, not {self.real_time_factor}."
            )
        if not 0.0 < self.lockstep_timeout_s < float("inf"):
            raise RunLoopError(f"lockstep_timeout_s must be positive, not {self.lockstep_timeout_s}.")


class Link(Protocol):
    """What the loop needs of the MAVLink link."""

    on_setpoint: Callable[[int], None]

    def poll(self, time_us: int, until: Callable[[], bool] = ...) -> None:
        """Handle all input that is there, or until `until` says so after a datagram."""

    def send_due(self, time_us: int) -> None:
        """Send the telemetry that is due."""

    def reset(self) -> None:
        """Let all telemetry be due again."""

    def wait(self, timeout_s: float) -> bool:
        """Sleep until input is there (True) or the time is over."""


class Output(Protocol):
    """Who is told of the simulation's progress, in the simulation's thread."""

    def publish(self, output: StepOutput) -> None:
        """Publish what the sensors of one instant say."""

    def report(self, figures: PerformanceFigures, paused: bool) -> None:
        """Publish performance figures; called about once a second of wall time, while paused too."""


class RunLoop:
    """Steps a simulation until it is told to stop.

    The thread that makes it owns the simulation and must be the one that calls `run`. A request that fails
    carries its exception back to its caller; the loop goes on. `on_warning` is called with a sentence when
    lockstep does not get what it waits for, and when the physics diverged; `on_divergence` must reset the
    simulation then.
    """

    def __init__(
        self,
        simulation: Simulation,
        link: Link,
        output: Output,
        pacing: PacingParameters | None = None,
        paused: bool = False,
        clock: WallClock | None = None,
    ):
        self.meter = PerformanceMeter()
        self.paused = paused
        self.on_warning: Callable[[str], None] = lambda sentence: None
        self.on_divergence: Callable[[], None] | None = None
        self._has_recovered = False
        self._clock = clock or WallClock()
        self._simulation = simulation
        self._link = link
        self._output = output
        self._pacing = pacing or PacingParameters()
        self._barrier = Barrier(self._pacing.participants)
        self._requests: queue.Queue = queue.Queue()
        self._owner = threading.get_ident()
        self._closed = False
        self._should_stop: Callable[[], bool] = lambda: False
        self._restarted = True
        self._anchor = (0.0, 0)  # wall time in s and simulated time in us from which pacing counts
        self._reported_s = 0.0
        link.on_setpoint = self._on_setpoint

    @property
    def pacing(self) -> PacingParameters:
        """How simulated time follows the wall clock now."""
        return self._pacing

    def call(self, function: Callable[[], object], timeout_s: float = 10.0) -> object:
        """Run `function` between two steps, from any thread; return what it returns, raise what it raises."""
        if threading.get_ident() == self._owner:
            return function()
        future: Future = Future()
        self._requests.put((function, future))
        if self._closed:
            self._refuse_requests()
        try:
            return future.result(timeout_s)
        except FutureTimeoutError as error:
            future.cancel()
            raise RunLoopError(f"The simulator did not answer within {timeout_s:g} s.") from error

    def acknowledge(self, participant: str, stamp_us: int) -> None:
        """Take a lockstep participant's word that it is done with scan(stamp_us); from any thread."""
        self._barrier.acknowledge(participant, stamp_us // 1000)

    def set_pacing(self, pacing: PacingParameters) -> None:
        """Follow other rules from now on; the participants stay. Within `call` only."""
        self._pacing = replace(pacing, participants=self._pacing.participants)
        self._set_anchor()

    def set_paused(self, paused: bool) -> None:
        """Stop simulated time, or let it run on. Within `call` only."""
        self.paused = paused
        self._set_anchor()

    def restart(self) -> None:
        """Begin again at the simulation's time, as after its reset, with new figures. Within `call` only."""
        self.meter.clear()
        self._restarted = True

    def run(self, should_stop: Callable[[], bool]) -> None:
        """Simulate until `should_stop()`, which is asked at least every 50 ms."""
        self._should_stop = should_stop
        self._reported_s = self._clock.now()
        try:
            while not should_stop():
                self._attend()
                if self.paused:
                    self._clock.sleep(IDLE_S)
                else:
                    self._go_on()
        finally:
            self._closed = True
            self._refuse_requests()

    def _go_on(self) -> None:
        try:
            if self._restarted:
                self._begin()
            elif self._simulation.time_us == 0 and not self._simulation.autopilot.is_ready():
                self._clock.sleep(IDLE_S)
                self._set_anchor()
            else:
                self._advance()
        except PhysicsDivergedError as error:
            if self.on_divergence is None:
                raise
            self._recover(error)

    def _recover(self, error: PhysicsDivergedError) -> None:
        """Reset a simulation whose physics diverged; pause it as well when a reset has just not helped."""
        relapse = self._has_recovered and self._simulation.time_us < RELAPSE_US
        self._has_recovered = True
        self.on_divergence()
        if relapse:
            self.set_paused(True)
            self.on_warning(
                f"{error} A reset did not help: paused; delete or move what is wrong, and unpause."
            )
        else:
            self.on_warning(f"{error} The simulation has been reset.")

    # -- one instant ---------------------------------------------------------------------------------------

    def _begin(self) -> None:
        """Publish the first instant."""
        self._restarted = False
        output = self._simulation.sense()
        self._tell(output)
        if self._pacing.lockstep and output.scan is not None:
            self._await_first_answer(output)
        self._set_anchor()

    def _await_first_answer(self, output: StepOutput) -> None:
        """Publish the first scan again and again: the nodes that are to answer it may still be starting."""
        warn_s = self._clock.now() + START_PATIENCE_S
        while not (self._pass_barrier(output.time_us, START_RETRY_S) or self._is_interrupted()):
            self._link.reset()
            self._tell(output)
            if self._clock.now() > warn_s:
                warn_s = float("inf")
                self.on_warning(
                    f"Lockstep: time does not begin before {self._missing()} for the first scan; "
                    "is everything running that answers scans? Without such nodes, fly without lockstep."
                )

    def _advance(self) -> None:
        began_s, began_us = self._clock.now(), self._simulation.time_us
        output = self._simulation.step()
        self._tell(output)
        if not self._pacing.lockstep:
            self._link.poll(output.time_us)
        elif output.scan is not None:
            passed = self._pass_barrier(output.time_us, self._pacing.lockstep_timeout_s)
            if not passed and not self._is_interrupted():
                self.meter.lockstep_misses += 1
                self.on_warning(
                    f"Lockstep: {self._missing()} did not come within {self._pacing.lockstep_timeout_s:g} s "
                    f"for the scan of t = {1e-6 * output.time_us:.3f} s; this run is not reproducible."
                )
        self._pace(output.time_us)
        self.meter.on_progress(1e-6 * (output.time_us - began_us), self._clock.now() - began_s)

    def _tell(self, output: StepOutput) -> None:
        """Publish the sensors of one instant and send the telemetry."""
        if output.scan is not None:
            self.meter.latency.on_scan(output.time_us // 1000, self._clock.now())
        self._output.publish(output)
        self._link.send_due(output.time_us)

    def _pass_barrier(self, time_us: int, timeout_s: float) -> bool:
        """Wait for what is made of scan(t), applying MAVLink input up to it; False: it timed out."""
        deadline_s = self._clock.now() + timeout_s
        self._barrier.raise_for(time_us // 1000)
        while not self._barrier.has_setpoint:
            remaining_s = deadline_s - self._clock.now()
            if remaining_s <= 0.0 or self._is_interrupted():
                return False
            if self._link.wait(min(remaining_s, 0.02)):
                self._link.poll(time_us, lambda: self._barrier.has_setpoint)
            self._attend()
            deadline_s = self._postponed(deadline_s, timeout_s)
        while not self._barrier.wait_for_participants(0.02):
            if self._clock.now() > deadline_s or self._is_interrupted():
                return False
            self._attend()
            deadline_s = self._postponed(deadline_s, timeout_s)
        return True

    def _postponed(self, deadline_s: float, timeout_s: float) -> float:
        """While it is paused nobody is late: who paused it may change the world for as long as it takes."""
        return self._clock.now() + timeout_s if self.paused else deadline_s

    def _pace(self, time_us: int) -> None:
        """Sleep until it is time for the next step; a setpoint that comes meanwhile is received at once."""
        factor = self._pacing.real_time_factor
        if factor == 0.0:
            return
        wall_s, simulated_us = self._anchor
        due_s = wall_s + 1e-6 * (time_us - simulated_us) / factor
        if self._clock.now() - due_s > FORGIVEN_LAG_S:
            self._set_anchor()
        while not (self.paused or self._is_interrupted()):
            remaining_s = due_s - self._clock.now()
            if remaining_s <= 0.0:
                return
            if self._pacing.lockstep:
                self._clock.sleep(min(remaining_s, 0.05))
            elif self._link.wait(min(remaining_s, 0.05)):
                self._link.poll(time_us)
            if remaining_s > 0.05:
                self._attend()

    def _missing(self) -> str:
        return " and ".join(self._barrier.missing())

    def _is_interrupted(self) -> bool:
        return self._restarted or self._should_stop()

    def _set_anchor(self) -> None:
        self._anchor = (self._clock.now(), self._simulation.time_us)

    # -- other threads -------------------------------------------------------------------------------------

    def _on_setpoint(self, time_boot_ms: int) -> None:
        self.meter.latency.on_setpoint(time_boot_ms, self._clock.now())
        self._barrier.on_setpoint(time_boot_ms)

    def _attend(self) -> None:
        """Do what other threads asked for, and report now and then."""
        while not self._requests.empty():
            function, future = self._requests.get()
            if not future.set_running_or_notify_cancel():
                continue  # its caller has given up
            try:
                future.set_result(function())
            except Exception as error:  # whatever it is, it belongs to the caller
                future.set_exception(error)
        now_s = self._clock.now()
        if now_s - self._reported_s >= REPORT_PERIOD_S:
            self._reported_s = now_s
            self._output.report(self.meter.snapshot(), self.paused)

    def _refuse_requests(self) -> None:
        while not self._requests.empty():
            try:
                _, future = self._requests.get_nowait()
            except queue.Empty:
                return
            future.set_exception(RunLoopError("The simulator is shutting down."))
