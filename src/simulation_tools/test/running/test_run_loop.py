"""Time: pacing, pausing, requests of other threads; with the real simulation and the real link."""

from __future__ import annotations

import threading
import time

import pytest
from run_loop_rig import in_background

from simulation_tools.running.pacing import FORGIVEN_LAG_S
from simulation_tools.running.requests import RunLoopError

STEP_S = 0.004  # the loop ends before it waits for its last step


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


def test_a_request_gets_its_result_or_exception_from_the_simulation(rig):
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
    rig.run_until(0.032)
    figures = rig.loop.meter.snapshot()
    assert figures.setpoint_latency_count >= 2
    assert 8.0 <= figures.setpoint_latency_ms_median < 150.0  # received at once, not at the next step
