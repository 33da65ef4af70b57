"""Readings on their way to who decides: none that counts is lost."""

from __future__ import annotations

import math

import pytest

from exploration.energy import Readings
from exploration.energy.readings import MOST_READINGS


def test_a_reading_is_taken_once_and_the_oldest_come_first():
    readings = Readings()
    readings.add(1.0, 0.9)
    readings.add(2.0, 0.8)
    assert readings.drain() == [(1.0, 0.9), (2.0, 0.8)]
    assert readings.drain() == []


def test_a_flight_begins_with_the_newest_reading_only():
    readings = Readings()
    readings.add(1.0, 0.2)
    readings.begin(5.0, 0.9)
    assert readings.drain() == [(5.0, 0.9)]


def test_if_nobody_decides_the_newest_readings_stay():
    readings = Readings()
    for i in range(MOST_READINGS + 5):
        readings.add(float(i), 0.5)
    taken = readings.drain()
    assert len(taken) == MOST_READINGS
    assert taken[-1] == (MOST_READINGS + 4.0, 0.5)


@pytest.mark.table(
    ("told", "begins_with"),
    [
        ((0.7, 0.0), 0.7),  # the newest one may be wrong
        ((0.0, 0.7), 0.7),
        ((0.2, 0.95), 0.95),  # the battery was swapped
        ((0.7, math.nan), 0.7),
        ((0.1, 0.1), 0.1),
    ],
)
def test_a_flight_does_not_begin_with_a_single_low_reading(told, begins_with):
    readings = Readings()
    for stamp_s, charge in enumerate(told):
        readings.add(float(stamp_s), charge)
    readings.begin(5.0, told[-1])
    assert readings.drain() == [(5.0, begins_with)]
