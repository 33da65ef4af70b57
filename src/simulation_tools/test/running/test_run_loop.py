"""Time: pacing, pausing, requests of other threads, lockstep; with the real simulation and the real link."""

from __future__ import annotations

import queue
import socket
import threading
import time
from pathlib import Path

import pytest
from pymavlink.dialects.v20 import common as mavlink

from simulation_tools.px4.mavlink.link import MavlinkLink
from simulation_tools.running.pacing import FORGIVEN_LAG_S, PacingParameters, WallClock
from simulation_tools.running.requests import RunLoopError
from simulation_tools.running.run_loop import RunLoop
from simulation_tools.simulation import Simulation, SimulationParameters

EMPTY = str(Path(__file__).resolve().parents[2] / "worlds" / "empty.world")
VELOCITY_ONLY = 0b0000_0101_1100_0111
STEP_S = 0.004  # the loop ends before it waits for its last step


class Recorder:
    """Takes what the loop publishes."""

    def __init__(self):
        self.outputs = []
        self.reports = []
        self.scans = queue.Queue()  # stamps in ms

    def publish(self, output):
        self.outputs.append(output)
        if output.scan is not None:
            self.scans.put(output.time_us // 1000)

    def report(self, figures, paused):
        self.reports.append((figures, paused))


class Client(threading.Thread):
    """An offboard client on its own socket: answers every scan with a setpoint of that scan's stamp."""

    def __init__(self, port, scans, delay_s=0.0, answers=lambda stamp_ms: [stamp_ms]):
        super().__init__(daemon=True)
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", port))
        self._socket.settimeout(5.0)
        self._scans, self._delay_s, self._answers = scans, delay_s, answers
        self._mavlink = mavlink.MAVLink(None, srcSystem=255, srcComponent=190)
        self.stopped = threading.Event()

    def run(self):
        _, address = self._socket.recvfrom(2048)  # the flight controller speaks first
        while not self.stopped.is_set():
            try:
                stamp_ms = self._scans.get(timeout=0.05)
            except queue.Empty:
                continue
            time.sleep(self._delay_s)
            for answer_ms in self._answers(stamp_ms):
                message = mavlink.MAVLink_set_position_target_local_ned_message(
                    answer_ms, 1, 1, mavlink.MAV_FRAME_BODY_NED, VELOCITY_ONLY, *[0.0] * 11
                )
                self._socket.sendto(message.pack(self._mavlink), address)
        self._socket.close()


def free_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class ExactClock:
    """A wall clock of a machine on which work takes no time: it goes on only while somebody waits."""

    def __init__(self):
        self.now_s = 0.0
        self.wall_clock = WallClock(now=lambda: self.now_s, sleep=self.sleep)

    def sleep(self, seconds):
        self.now_s += seconds


class UnhurriedLink(MavlinkLink):
    """The link of a loop whose clock is exact: waiting for input is waiting by that clock."""

    clock: ExactClock

    def wait(self, timeout_s):
        self.clock.sleep(timeout_s)
        return super().wait(0.0)


class Rig:
    """A simulation with its link and loop; `exact`: by a clock on which the machine has no influence."""

    def __init__(self, exact=False, **pacing):
        self.port = free_port()
        self.simulation = Simulation(SimulationParameters(world=EMPTY))
        link_type = UnhurriedLink if exact else MavlinkLink
        self.link = link_type(self.simulation.px4, self.port, 0, offboard_local_port=0)
        self.link.clock = ExactClock()
        self.clock = self.link.clock.wall_clock if exact else WallClock()
        self.recorder = Recorder()
        self.loop = RunLoop(
            self.simulation, self.link, self.recorder, PacingParameters(**pacing), clock=self.clock
        )
        self.warnings = []
        self.loop.on_warning = self.warnings.append
        self.client = None

    def answer(self, **how):
        self.client = Client(self.port, self.recorder.scans, **how)
        self.client.start()

    def run_until(self, simulated_s, wall_s=10.0):
        """Returns the wall time that it took."""
        began = self.clock.now()
        self.loop.run(
            lambda: self.simulation.time_us >= 1e6 * simulated_s or self.clock.now() - began > wall_s
        )
        return self.clock.now() - began

    def close(self):
        if self.client is not None:
            self.client.stopped.set()
            self.client.join(2.0)
        self.link.close()
        self.simulation.close()


@pytest.fixture
def rig():
    rigs = []

    def build(**pacing):
        rigs.append(Rig(**pacing))
        return rigs[-1]

    yield build
    for made in rigs:
        made.close()


def in_background(function):
    """Runs a function of another thread's; returns a function that gives its result."""
    results = queue.Queue()
    threading.Thread(target=lambda: results.put(function()), daemon=True).start()
    return lambda: results.get(timeout=10.0)


@pytest.mark.parametrize("factor", [0.5, 1.0, 4.0])
def test_simulated_time_keeps_to_the_real_time_factor(rig, factor):
    rig = rig(exact=True, real_time_factor=factor)
    took_s = rig.run_until(2.0)
    assert took_s == pytest.approx((2.0 - STEP_S) / factor, rel=1e-6)


def test_simulated_time_never_runs_ahead_of_the_machines_clock(rig):
    rig = rig(real_time_factor=2.0)
    assert rig.run_until(0.8) >= (0.8 - STEP_S) / 2.0  # on a busy machine it may be more


def test_after_a_stall_it_does_not_sprint(rig):
    rig = rig(exact=True, real_time_factor=1.0)
    rig.run_until(0.5)
    rig.clock.sleep(3.0)
    assert rig.run_until(1.5) == pytest.approx(1.0, abs=0.01)
    rig.clock.sleep(0.9 * FORGIVEN_LAG_S)  # so little is caught up with
    assert rig.run_until(2.5) == pytest.approx(1.0 - 0.9 * FORGIVEN_LAG_S, abs=0.01)


def test_factor_zero_never_waits(rig):
    rig = rig(exact=True, real_time_factor=0.0)
    assert rig.run_until(1.0) == 0.0


def test_every_output_is_published_once_in_the_order_of_time(rig):
    rig = rig(real_time_factor=0.0)
    rig.run_until(0.5)
    times = [output.time_us for output in rig.recorder.outputs]
    assert times == list(range(0, 500_001, 4000))


def test_a_paused_simulation_stands_still_and_serves_requests(rig):
    rig = rig(real_time_factor=1.0)

    def pause_and_look():
        time.sleep(0.1)
        rig.loop.call(lambda: rig.loop.set_paused(True))
        first = rig.loop.call(lambda: rig.simulation.time_us)
        time.sleep(0.3)
        second = rig.loop.call(lambda: rig.simulation.time_us)
        rig.loop.call(lambda: rig.loop.set_paused(False))
        return first, second

    result = in_background(pause_and_look)
    took_s = rig.run_until(0.3)
    first, second = result()
    assert 0 < first == second
    assert took_s >= 0.3 - STEP_S + 0.3  # the pause is not caught up with


def test_a_request_gets_its_result_or_its_exception_from_the_simulation_thread(rig):
    rig = rig(real_time_factor=1.0)
    own = threading.get_ident()

    def ask():
        where = rig.loop.call(threading.get_ident)
        with pytest.raises(ZeroDivisionError):
            rig.loop.call(lambda: 1 / 0)
        return where, rig.loop.call(lambda: "still there")

    result = in_background(ask)
    rig.run_until(0.3)
    assert result() == (own, "still there")


def test_after_the_end_requests_are_refused_instead_of_waiting(rig):
    rig = rig()
    rig.run_until(0.01)

    def ask():
        with pytest.raises(RunLoopError, match="shutting down"):
            rig.loop.call(lambda: None)
        return True

    began = time.perf_counter()
    assert in_background(ask)()
    assert time.perf_counter() - began < 5.0  # a request's time-out is 10 s


def test_figures_are_reported_every_second_also_while_paused(rig):
    rig = rig(exact=True, real_time_factor=1.0)
    rig.run_until(10.0, wall_s=1.5)
    rig.loop.set_paused(True)
    rig.run_until(10.0, wall_s=1.5)
    (running, was_paused), (standing, is_paused) = rig.recorder.reports
    assert not was_paused
    assert is_paused
    assert 0.9 < running.simulated_s <= standing.simulated_s


def test_latency_is_the_wall_time_from_scan_to_its_setpoint(rig):
    rig = rig(real_time_factor=0.02)  # a step each 200 ms, so that also a busy machine answers between two
    rig.answer(delay_s=0.008)
    rig.run_until(0.06)
    figures = rig.loop.meter.snapshot()
    assert figures.setpoint_latency_count >= 2
    assert 8.0 <= figures.setpoint_latency_ms_median < 150.0  # received at once, not at the next step


class TestLockstep:
    """What holds at a scan instant in lockstep."""

    def test_time_waits_for_the_setpoint_of_each_scan(self, rig):
        rig = rig(real_time_factor=0.0, lockstep=True)
        rig.answer(delay_s=0.02)
        took_s = rig.run_until(0.5)
        scans = sum(output.scan is not None for output in rig.recorder.outputs)
        assert scans == 20 or scans == 21
        assert took_s >= scans * 0.02
        assert rig.loop.meter.lockstep_misses == 0

    def test_before_anybody_answers_the_first_scan_is_repeated(self, rig):
        rig = rig(real_time_factor=0.0, lockstep=True)
        rig.run_until(0.1, wall_s=1.0)
        assert rig.simulation.time_us == 0
        assert len(rig.recorder.outputs) >= 4
        assert {output.time_us for output in rig.recorder.outputs} == {0}
        assert rig.loop.meter.lockstep_misses == 0

    def test_who_misses_the_time_out_is_counted_and_left_behind(self, rig):
        rig = rig(real_time_factor=0.0, lockstep=True, lockstep_timeout_s=0.5)
        rig.answer(answers=lambda stamp_ms: [stamp_ms] if stamp_ms < 200 else [])
        rig.run_until(0.23)
        missed = [o for o in rig.recorder.outputs if o.scan is not None and o.time_us >= 200_000]
        assert rig.simulation.time_us >= 230_000
        assert len(rig.warnings) == len(missed)
        assert "a setpoint" in rig.warnings[0]
        assert rig.loop.meter.lockstep_misses == len(missed) > 0

    def test_a_setpoint_of_another_stamp_opens_nothing(self, rig):
        rig = rig(real_time_factor=0.0, lockstep=True, lockstep_timeout_s=0.1)
        rig.answer(answers=lambda stamp_ms: [stamp_ms] if stamp_ms == 0 else [stamp_ms - 1, stamp_ms + 1])
        rig.run_until(0.11)
        assert rig.loop.meter.lockstep_misses == 4

    def test_every_participant_is_waited_for(self, rig):
        rig = rig(real_time_factor=0.0, lockstep=True, participants=frozenset({"slam"}))
        rig.answer()
        stop = threading.Event()

        def acknowledge_late():
            while not stop.is_set():
                time.sleep(0.01)
                if rig.recorder.outputs:
                    rig.loop.acknowledge("slam", rig.recorder.outputs[-1].time_us)
            return True

        done = in_background(acknowledge_late)
        took_s = rig.run_until(0.3)
        stop.set()
        assert done()
        assert took_s >= 12 * 0.005
        assert rig.loop.meter.lockstep_misses == 0

    def test_a_missing_participant_is_counted(self, rig):
        rig = rig(
            real_time_factor=0.0, lockstep=True, lockstep_timeout_s=0.1, participants=frozenset({"slam"})
        )
        rig.answer()
        in_background(lambda: (time.sleep(0.3), rig.loop.acknowledge("slam", 0)))
        rig.run_until(0.11)
        assert "an acknowledgement on slam did not come" in rig.warnings[0]
        assert rig.loop.meter.lockstep_misses == 4

    def test_nobody_is_late_while_it_is_paused(self, rig):
        rig = rig(
            real_time_factor=0.0, lockstep=True, lockstep_timeout_s=0.2, participants=frozenset({"placer"})
        )
        rig.answer()
        stop = threading.Event()

        def acknowledge_but_stop_time_once():
            has_stopped = False
            while not stop.is_set():
                time.sleep(0.01)
                newest_us = rig.recorder.outputs[-1].time_us if rig.recorder.outputs else 0
                if newest_us > 100_000 and not has_stopped:
                    rig.loop.call(lambda: rig.loop.set_paused(True))
                    time.sleep(0.5)  # longer than the time-out
                    rig.loop.call(lambda: rig.loop.set_paused(False))
                    has_stopped = True
                rig.loop.acknowledge("placer", newest_us)
            return has_stopped

        done = in_background(acknowledge_but_stop_time_once)
        took_s = rig.run_until(0.3)
        stop.set()
        assert done()
        assert took_s >= 0.5
        assert rig.loop.meter.lockstep_misses == 0

    def test_a_reset_begins_again_at_zero(self, rig):
        rig = rig(real_time_factor=1.0, lockstep=True)
        rig.answer()

        def reset():
            rig.simulation.reset()
            rig.link.reset()
            rig.loop.restart()

        in_background(lambda: (time.sleep(0.2), rig.loop.call(reset)))
        rig.run_until(0.5, wall_s=3.0)
        times = [output.time_us for output in rig.recorder.outputs]
        (back,) = (k for k in range(1, len(times)) if times[k] < times[k - 1])
        assert times[back] == 0
        assert times[-1] >= 500_000

    def test_the_end_does_not_wait_for_the_barrier(self, rig):
        rig = rig(real_time_factor=0.0, lockstep=True, lockstep_timeout_s=60.0)
        assert rig.run_until(1.0, wall_s=0.2) < 20.0


@pytest.mark.parametrize(
    "bad", [{"real_time_factor": -1.0}, {"real_time_factor": float("nan")}, {"lockstep_timeout_s": 0.0}]
)
def test_pacing_that_makes_no_sense_is_refused(bad):
    with pytest.raises(RunLoopError):
        PacingParameters(**bad)
