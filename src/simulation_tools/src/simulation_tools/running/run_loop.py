"""Runs a simulation in time: step, publish, wait for lockstep or the wall clock, serve other threads.

One thread owns the simulation and calls `RunLoop.run`; every other thread goes through `RunLoop.call`.
Nothing here knows ROS. doc/how_it_works.md has the protocol of stamps and lockstep.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Callable, Protocol

from simulation_tools.running.lockstep import Barrier, Lockstep, SetpointInput
from simulation_tools.running.pacing import Pacer, PacingParameters, WallClock
from simulation_tools.running.performance import PerformanceFigures, PerformanceMeter
from simulation_tools.running.requests import Requests
from simulation_tools.simulation import PhysicsDivergedError, Simulation, StepOutput

IDLE_S = 0.005
"""A paused or waiting loop checks for requests at this period."""

LOOK_PERIOD_S = 0.05
"""A loop that waits for its next step checks for requests and for the end at this period."""

RELAPSE_US = 2_000_000
"""If physics diverges again within this time after a reset, another reset would not help."""

HELD_US = 28_000
"""A link that keeps telemetry sends it after a scan, while other nodes work on that, or after this time."""

REPORT_PERIOD_S = 1.0
"""Wall time between two reports of the performance figures."""


class Link(SetpointInput, Protocol):
    """What the loop needs of the MAVLink link."""

    on_setpoint: Callable[[int], None]
    on_external_pose: Callable[[int], None]

    def send_due(self, time_us: int) -> None:
        """Send the telemetry that is due."""

    def flush(self) -> None:
        """Send telemetry that the link has kept; not every link keeps any."""

    def reset(self) -> None:
        """Let all telemetry be due again."""


class Output(Protocol):
    """Receives the simulation's outputs, in the simulation's thread."""

    def publish(self, output: StepOutput) -> None:
        """Publish the measurements of one instant."""

    def report(self, figures: PerformanceFigures, paused: bool) -> None:
        """Publish performance figures; called about once a second of wall time, while paused too."""


class RunLoop:
    """Steps a simulation until it is told to stop.

    The thread that makes it owns the simulation and must be the one that calls `run`. If a request fails,
    its caller gets the exception and the loop goes on. `on_warning` is called with a sentence when lockstep
    misses an answer and when the physics diverges. `on_divergence` must then reset the simulation.
    """

    def __init__(
        self,
        simulation: Simulation,
        link: Link,
        output: Output,
        pacing: PacingParameters | None = None,
        paused: bool = False,
        clock: WallClock | None = None,
    ) -> None:
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
        self._pacer = Pacer(self._clock)
        barrier = Barrier(self._pacing.participants, self._pacing.pose_sender)
        self._lockstep = Lockstep(
            barrier, link, self._clock, self._attend, self._is_interrupted, lambda text: self.on_warning(text)
        )
        self._requests = Requests()
        self._should_stop: Callable[[], bool] = lambda: False
        self._restarted = True
        self._reported_s = 0.0
        self._flush_due_us = 0
        link.on_setpoint = self._on_setpoint
        link.on_external_pose = barrier.on_pose

    @property
    def pacing(self) -> PacingParameters:
        """How simulated time follows the wall clock now."""
        return self._pacing

    def call(self, function: Callable[[], Any], timeout_s: float = 10.0) -> Any:
        """Run `function` between two steps, from any thread; return what it returns, raise what it raises."""
        return self._requests.call(function, timeout_s)

    def beat(self, participant: str) -> None:
        """Note that a lockstep participant works on a scan; from any thread."""
        self._lockstep.barrier.beat(participant, self._clock.now())

    def acknowledge(self, participant: str, stamp_us: int, sent_pose: bool = False) -> None:
        """Note that a lockstep participant is done with scan(stamp_us); from any thread.

        sent_pose: the sender of external poses has sent one of this stamp.
        """
        self._lockstep.barrier.acknowledge(participant, stamp_us // 1000, sent_pose)

    def set_pacing(self, pacing: PacingParameters) -> None:
        """Change the pacing; the participants stay the same. Within `call` only."""
        now = self._pacing
        self._pacing = replace(pacing, participants=now.participants, pose_sender=now.pose_sender)
        self._pacer.restart(self._simulation.time_us)

    def set_paused(self, paused: bool) -> None:
        """Stop simulated time, or let it run on. Within `call` only."""
        self.paused = paused
        self._link.flush()
        self._pacer.restart(self._simulation.time_us)

    def restart(self) -> None:
        """Begin again at the simulation's time, with new figures, as after a reset. Within `call` only."""
        self.meter.clear()
        self._restarted, self._flush_due_us = True, 0

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
            self._requests.close()

    def _go_on(self) -> None:
        try:
            if self._restarted:
                self._begin()
            elif self._simulation.time_us == 0 and not self._simulation.autopilot.is_ready():
                self._clock.sleep(IDLE_S)
                self._pacer.restart(0)
            else:
                self._advance()
        except PhysicsDivergedError as error:
            if self.on_divergence is None:
                raise
            self._recover(error, self.on_divergence)

    def _recover(self, error: PhysicsDivergedError, reset: Callable[[], None]) -> None:
        """Reset a simulation whose physics diverged. If the last reset did not help, pause it too."""
        relapse = self._has_recovered and self._simulation.time_us < RELAPSE_US
        self._has_recovered = True
        reset()
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
        self._publish(output)
        if self._pacing.lockstep and output.scan is not None:
            self._lockstep.wait_for_first(
                output.time_us, lambda: self._publish_again(output), lambda text: self.on_warning(text)
            )
        self._pacer.restart(self._simulation.time_us)

    def _publish_again(self, output: StepOutput) -> None:
        self._link.reset()
        self._publish(output)

    def _advance(self) -> None:
        began_s, began_us = self._clock.now(), self._simulation.time_us
        output = self._simulation.step()
        self._publish(output)
        if not self._pacing.lockstep:
            self._link.poll(output.time_us)
        elif output.scan is not None:
            timeout_s = self._pacing.lockstep_timeout_s
            if not self._lockstep.wait(output.time_us, timeout_s) and not self._is_interrupted():
                self.meter.lockstep_misses += 1
                self.on_warning(
                    f"Lockstep: {self._lockstep.barrier.missing()} did not come within {timeout_s:g} s "
                    f"for the scan of t = {1e-6 * output.time_us:.3f} s; this run is not reproducible."
                )
        self._pace(output.time_us)
        self.meter.on_progress(1e-6 * (output.time_us - began_us), self._clock.now() - began_s)

    def _publish(self, output: StepOutput) -> None:
        """Publish the sensors of one instant and send the telemetry."""
        if output.scan is not None:
            self.meter.latency.on_scan(output.time_us // 1000, self._clock.now())
        self._output.publish(output)
        self._link.send_due(output.time_us)
        if output.scan is not None or output.time_us >= self._flush_due_us:
            self._link.flush()
            self._flush_due_us = output.time_us + HELD_US

    def _pace(self, time_us: int) -> None:
        """Sleep until the next step is due. A setpoint that arrives during the sleep is handled at once."""
        due_s = self._pacer.due_s(time_us, self._pacing.real_time_factor)
        while not (self.paused or self._is_interrupted()):
            remaining_s = due_s - self._clock.now()
            if remaining_s <= 0.0:
                return
            if self._pacing.lockstep:
                self._clock.sleep(min(remaining_s, LOOK_PERIOD_S))
            elif self._link.wait(min(remaining_s, LOOK_PERIOD_S)):
                self._link.poll(time_us)
            if remaining_s > LOOK_PERIOD_S:
                self._attend()

    def _is_interrupted(self) -> bool:
        return self._restarted or self._should_stop()

    def _on_setpoint(self, time_boot_ms: int) -> None:
        self.meter.latency.on_setpoint(time_boot_ms, self._clock.now())
        self._lockstep.barrier.on_setpoint(time_boot_ms)

    def _attend(self) -> bool:
        """Serve other threads and report periodically. Return whether the loop is paused."""
        self._requests.serve()
        now_s = self._clock.now()
        if now_s - self._reported_s >= REPORT_PERIOD_S:
            self._reported_s = now_s
            self._output.report(self.meter.snapshot(), self.paused)
        return self.paused
