"""Readings on their way to who decides: none that counts is lost."""

from __future__ import annotations

from inspection_tools.energy import EnergyWatch, Readings, Verdict, WayHome
from inspection_tools.energy.readings import MOST_READINGS

HERE = WayHome(0.0, 0.0)


def decision_of(readings: Readings, now_s: float):
    watch = EnergyWatch()
    watch.restart_clock(now_s)  # the node tells the watch of the jump before it decides
    for reading in readings.take():
        watch.offer(*reading)
    return watch.decide(now_s, HERE)


def test_a_clock_that_jumps_back_before_the_first_decision_loses_no_reading():
    readings = Readings()
    readings.begin(100.0, 0.9)
    readings.restart_clock(0.0)
    decision = decision_of(readings, 0.0)
    assert (decision.verdict, decision.charge) == (Verdict.GO_ON, 0.9)


def test_a_low_charge_from_before_the_jump_counts():
    readings = Readings()
    readings.begin(100.0, 0.9)
    readings.add(101.0, 0.1)
    readings.restart_clock(0.0)
    assert decision_of(readings, 0.0).verdict is Verdict.RETURN


def test_a_reading_is_taken_once_and_the_oldest_come_first():
    readings = Readings()
    readings.add(1.0, 0.9)
    readings.add(2.0, 0.8)
    assert readings.take() == [(1.0, 0.9), (2.0, 0.8)]
    assert readings.take() == []


def test_a_flight_begins_with_the_newest_reading_only():
    readings = Readings()
    readings.add(1.0, 0.2)
    readings.begin(5.0, 0.9)
    assert readings.take() == [(5.0, 0.9)]


def test_if_nobody_decides_the_newest_readings_stay():
    readings = Readings()
    for i in range(MOST_READINGS + 5):
        readings.add(float(i), 0.5)
    taken = readings.take()
    assert len(taken) == MOST_READINGS
    assert taken[-1] == (MOST_READINGS + 4.0, 0.5)
