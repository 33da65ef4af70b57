"""The figures by which a run is judged."""

from __future__ import annotations

import math

import numpy as np
import pytest

from simulation_tools.running.performance import LatencyMeter, PerformanceMeter


def test_latency_is_from_scan_to_the_first_setpoint_of_its_stamp():
    meter = LatencyMeter()
    meter.on_scan(100, 10.0)
    meter.on_scan(125, 10.025)
    meter.on_setpoint(125, 10.032)  # 7 ms
    meter.on_setpoint(100, 10.040)  # 40 ms
    meter.on_setpoint(125, 11.000)  # the stream repeats it: counted once
    meter.on_setpoint(110, 11.000)  # made from no scan
    assert meter.count == 2
    assert meter.percentiles_ms(0.0, 100.0) == pytest.approx([7.0, 40.0])


def test_percentiles_are_those_of_the_newest():
    meter = LatencyMeter(kept=100)
    latencies_ms = np.random.default_rng(1).uniform(1.0, 30.0, 250)
    for k, latency_ms in enumerate(latencies_ms):
        meter.on_scan(k, k)
        meter.on_setpoint(k, k + 1e-3 * latency_ms)
    assert meter.count == 250
    expected = np.percentile(latencies_ms[-100:], [50.0, 99.0])
    assert meter.percentiles_ms(50.0, 99.0) == pytest.approx(expected.tolist())


def test_unanswered_scans_do_not_pile_up():
    meter = LatencyMeter()
    for k in range(10_000):
        meter.on_scan(k, 0.0)
    meter.on_setpoint(0, 1.0)  # forgotten long ago
    meter.on_setpoint(9_999, 1.0)
    assert meter.count == 1


def test_real_time_factor_is_of_the_interval_and_of_the_whole():
    meter = PerformanceMeter()
    meter.on_progress(simulated_s=10.0, wall_s=5.0)
    assert meter.snapshot().real_time_factor == pytest.approx(2.0)
    meter.on_progress(simulated_s=10.0, wall_s=20.0)
    figures = meter.snapshot()
    assert figures.real_time_factor == pytest.approx(0.5)
    assert figures.real_time_factor_mean == pytest.approx(20.0 / 25.0)
    assert meter.snapshot().real_time_factor == 0.0  # nothing happened since


def test_no_latency_is_not_zero_latency():
    figures = PerformanceMeter().snapshot()
    assert math.isnan(figures.setpoint_latency_ms_median)
    assert figures.setpoint_latency_count == 0
