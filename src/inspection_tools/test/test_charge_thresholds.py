"""Thresholds of the charge are told once each, by readings that agree, and begin anew with a flight."""

import math

import pytest

from inspection_tools.charge_thresholds import ChargeLevel, ChargeWatch


def told(*charges, watch=None):
    watch = watch or ChargeWatch()
    return [sentence for charge in charges if (sentence := watch.offer(charge))]


def test_each_threshold_is_told_once_and_at_the_last_the_uav_lands():
    sinking = [0.01 * percent for percent in range(30, 2, -1) for _ in range(3)]
    assert told(*sinking) == [
        "The battery is at 15%: come home.",
        "The battery is at 7%: land soon.",
        "The battery is at 5%: the UAV lands here.",
    ]


@pytest.mark.table("wrong", [0.0, 0.04, math.nan, -1.0, 7.0])
def test_a_single_wrong_reading_says_nothing(wrong):
    watch = ChargeWatch()
    assert told(0.8, wrong, 0.8, wrong, 0.8, watch=watch) == []
    assert watch.level is ChargeLevel.FINE


def test_a_level_does_not_rise_in_flight_but_with_a_new_battery():
    watch = ChargeWatch()
    assert told(0.1, 0.1, 0.16, 0.16, 0.1, 0.1, watch=watch) == ["The battery is at 10%: come home."]
    watch.begin()
    assert told(0.9, 0.9, 0.05, 0.05, watch=watch) == ["The battery is at 5%: the UAV lands here."]
