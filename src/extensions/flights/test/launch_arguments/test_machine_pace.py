"""Which real-time factor the machine can keep is said before a flight that would be late."""

import os
import time

import pytest

from flights.launch_arguments import machine_pace
from flights.launch_arguments.machine_pace import free_cores, rounded, warning

PX4 = {"autopilot": "px4", "real_time_factor": "1.0", "lockstep": "false"}


def test_a_flight_that_would_be_late_is_told_with_a_factor_that_the_machine_keeps():
    """1.3 cores, and 2.5 s of CPU time a second: 0.52."""
    said = warning("explore.launch", PX4, lambda: 1.3)
    assert said.startswith(
        "This machine can keep a real-time factor of about 0.52 now, and 1 is asked for: 1.3 cores are free"
    )
    assert said.endswith("add real_time_factor:=0.5.")
    assert warning("explore.launch", {**PX4, "real_time_factor": "0.5"}, lambda: 1.3) == ""
    assert warning("experiment_1.launch", PX4, lambda: 1.0) != ""
    assert warning("experiment_1.launch", PX4, lambda: 1.2) == ""


@pytest.mark.table(
    ("name", "changed"),
    [
        ("explore.launch", {"real_time_factor": "0"}),
        ("explore.launch", {"autopilot": "standin", "lockstep": "true"}),
        ("experiment_1.launch", {"autopilot": "standin"}),
    ],
)
def test_where_nothing_can_be_late_nothing_is_measured(name, changed):
    assert warning(name, {**PX4, **changed}, lambda: pytest.fail("measured")) == ""
    assert warning("real.launch", {"autopilot": "px4"}, lambda: pytest.fail("measured")) == ""


def test_who_explores_without_lockstep_is_told_whatever_flies():
    assert warning("explore.launch", {**PX4, "autopilot": "standin"}, lambda: 0.5)


def test_the_machine_is_measured_by_what_it_counts(monkeypatch):
    """On any machine: twice the reference's speed is half as many cores; and no process stays behind."""
    began_s = time.perf_counter()
    cores = free_cores(0.05)
    assert cores > 0.0
    assert time.perf_counter() - began_s < 10.0
    fork, started = os.fork, []
    monkeypatch.setattr(os, "fork", lambda: noted(fork(), started))
    monkeypatch.setattr(machine_pace, "_spin", lambda _: machine_pace.REFERENCE_LOOPS_PER_S / 2.0)
    assert free_cores(0.0) == pytest.approx(0.5 * len(os.sched_getaffinity(0)))
    assert len(started) == len(os.sched_getaffinity(0))
    for pid in started:  # another test of this process may have children of its own
        with pytest.raises(ChildProcessError):
            os.waitpid(pid, os.WNOHANG)


def noted(pid, pids):
    pids.append(pid)
    return pid


@pytest.mark.table(("keeps", "typed"), [(0.52, 0.5), (0.99, 0.9), (0.04, 0.05), (1.73, 1.7)])
def test_a_factor_is_rounded_down(keeps, typed):
    assert rounded(keeps) == typed
