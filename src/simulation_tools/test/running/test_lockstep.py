"""What holds at a scan instant in lockstep."""

from __future__ import annotations

import threading
import time

import pytest
from run_loop_rig import in_background

from simulation_tools.running.lockstep import Barrier


def test_time_waits_for_the_setpoint_of_each_scan(rig):
    rig = rig(real_time_factor=0.0, lockstep=True, lockstep_timeout_s=60.0)
    rig.answer(delay_s=0.02)
    took_s = rig.run_until(0.5)
    scans = sum(output.scan is not None for output in rig.recorder.outputs)
    assert scans == 20 or scans == 21
    assert took_s >= scans * 0.02
    assert rig.loop.meter.lockstep_misses == 0


def test_before_anybody_answers_the_first_scan_is_repeated(rig):
    rig = rig(exact=True, real_time_factor=0.0, lockstep=True)
    rig.run_until(0.1, wall_s=1.0)
    assert rig.simulation.time_us == 0
    assert len(rig.recorder.outputs) >= 4
    assert {output.time_us for output in rig.recorder.outputs} == {0}
    assert rig.loop.meter.lockstep_misses == 0


def test_who_misses_the_time_out_is_counted_and_left_behind(rig):
    rig = rig(real_time_factor=0.0, lockstep=True, lockstep_timeout_s=1.0)
    rig.answer(answers=lambda stamp_ms: [stamp_ms] if stamp_ms < 200 else [])
    rig.run_until(0.21)
    missed = [o for o in rig.recorder.outputs if o.scan is not None and o.time_us >= 200_000]
    assert rig.simulation.time_us >= 210_000
    assert len(rig.warnings) == len(missed)
    assert "a setpoint" in rig.warnings[0]
    assert rig.loop.meter.lockstep_misses == len(missed) > 0


def test_a_setpoint_of_another_stamp_opens_nothing(rig):
    rig = rig(real_time_factor=0.0, lockstep=True, lockstep_timeout_s=0.3)
    rig.answer(answers=lambda stamp_ms: [stamp_ms] if stamp_ms == 0 else [stamp_ms - 1, stamp_ms + 1])
    rig.run_until(0.06)
    assert rig.loop.meter.lockstep_misses == 2


def test_every_participant_is_waited_for(rig):
    rig = rig(real_time_factor=0.0, lockstep=True, lockstep_timeout_s=60.0, participants=frozenset({"slam"}))
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


@pytest.mark.table(("sent", "lacking"), [(False, ""), (True, "the external pose")])
def test_an_external_pose_is_waited_for_if_one_was_sent(sent, lacking):
    barrier = Barrier(frozenset(), "vision")
    barrier.raise_for(100)
    barrier.on_setpoint(100)
    barrier.on_pose(75)  # of the scan before
    assert barrier.missing() == "an acknowledgement on vision"
    barrier.acknowledge("vision", 100, sent_pose=sent)
    assert barrier.missing() == lacking
    barrier.on_pose(100)
    assert not barrier.lacks_pose


def test_a_missing_participant_is_counted(rig):
    rig = rig(real_time_factor=0.0, lockstep=True, lockstep_timeout_s=0.1, participants=frozenset({"slam"}))
    rig.answer()
    in_background(lambda: (time.sleep(0.3), rig.loop.acknowledge("slam", 0)))
    rig.run_until(0.11)
    assert "an acknowledgement on slam did not come" in rig.warnings[0]
    assert rig.loop.meter.lockstep_misses == 4


def test_nobody_is_late_while_it_is_paused(rig):
    rig = rig(real_time_factor=0.0, lockstep=True, lockstep_timeout_s=0.7, participants=frozenset({"placer"}))
    rig.answer()
    stop = threading.Event()

    def acknowledge_but_stop_time_once():
        has_stopped = False
        while not stop.is_set():
            time.sleep(0.01)
            newest_us = rig.recorder.outputs[-1].time_us if rig.recorder.outputs else 0
            if newest_us > 100_000 and not has_stopped:
                rig.loop.call(lambda: rig.loop.set_paused(True))
                time.sleep(1.0)  # longer than the time-out
                rig.loop.call(lambda: rig.loop.set_paused(False))
                has_stopped = True
            rig.loop.acknowledge("placer", newest_us)
        return has_stopped

    done = in_background(acknowledge_but_stop_time_once)
    took_s = rig.run_until(0.3)
    stop.set()
    assert done()
    assert took_s >= 1.0
    assert rig.loop.meter.lockstep_misses == 0


def test_a_reset_begins_again_at_zero(rig):
    rig = rig(real_time_factor=1.0, lockstep=True)
    rig.answer()

    def reset():
        rig.simulation.reset()
        rig.link.reset()
        rig.loop.restart()

    in_background(lambda: (time.sleep(0.2), rig.loop.call(reset)))
    rig.run_until(0.5)
    times = [output.time_us for output in rig.recorder.outputs]
    (back,) = (k for k in range(1, len(times)) if times[k] < times[k - 1])
    assert times[back] == 0
    assert times[-1] >= 500_000


def test_the_end_does_not_wait_for_the_barrier(rig):
    rig = rig(real_time_factor=0.0, lockstep=True, lockstep_timeout_s=60.0)
    assert rig.run_until(1.0, wall_s=0.2) < 20.0
