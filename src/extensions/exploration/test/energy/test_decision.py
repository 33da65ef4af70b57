"""When to go on, return or land: worked out by hand, as properties, and in whole flights."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from exploration.energy import EnergyParameters, EnergyWatch, Verdict, WayHome

P = EnergyParameters()
CHARGES, TIMES_S = st.floats(0.0, 1.0), st.floats(0.0, 1000.0)


def verdict(charge, time_s, now_s=0.0):
    watch = EnergyWatch()
    watch.offer(0.0, charge)
    return watch.decide(now_s, WayHome(time_s, time_s))


@pytest.mark.table(
    ("charge", "time_s", "expected", "sentence"),
    [
        # At 1 / 600 s the way takes (1.3 x 120 s + 8 s + 10 s) / 600 s = 29 %, and 12 % stay.
        (0.42, 120.0, Verdict.GO_ON, "The way home of 120 m takes 29%, 42% are left: go on."),
        (0.40, 120.0, Verdict.RETURN, "takes 29%, 40% are left, and 12% are the reserve: return."),
        (0.19, 120.0, Verdict.LAND, "The way home of 120 m takes 29%, 19% are left: land here."),
        # A way of 1 m takes (1.3 x 1 s + 8 s + 10 s) / 600 s = 3.2 %, for the UAV must settle, too.
        (0.16, 1.0, Verdict.GO_ON, "The way home of 1 m takes 3%, 16% are left: go on."),
        (0.15, 1.0, Verdict.RETURN, "takes 3%, 15% are left, and 12% are the reserve: return."),
        (0.05, 0.0, Verdict.LAND, "The battery is at 5%: land here."),
    ],
)
def test_what_is_left_decides(charge, time_s, expected, sentence):
    decision = verdict(charge, time_s)
    assert decision.verdict is expected
    assert decision.reason.endswith(sentence)


def test_a_battery_that_tells_nothing_sends_the_uav_home():
    watch, way = EnergyWatch(), WayHome(10.0, 10.0)
    assert watch.decide(0.0, way).verdict is Verdict.RETURN
    watch.offer(0.0, 0.9)
    assert watch.decide(5.0, way).verdict is Verdict.GO_ON
    silent = watch.decide(7.0, way)
    assert (silent.verdict, silent.reason) == (
        Verdict.RETURN,
        "The battery has told nothing to believe for 7 s: return.",
    )
    watch.offer(8.0, math.nan)
    assert watch.decide(8.0, way).verdict is Verdict.RETURN
    watch.offer(9.0, 0.88)
    assert watch.decide(9.0, way).verdict is Verdict.GO_ON  # it speaks again, and there is enough


def test_without_a_way_home_it_goes_back_until_it_must_land():
    watch = EnergyWatch()
    watch.offer(0.0, 0.9)
    decision = watch.decide(0.0, None)
    assert (decision.verdict, decision.reason) == (
        Verdict.RETURN,
        "No way home is known: go back the way you came.",
    )
    assert watch.decide(700.0, None).verdict is Verdict.LAND  # silent, and by now empty


def test_a_return_is_final_until_the_next_take_off():
    watch = EnergyWatch()
    watch.offer(0.0, 0.3)
    assert watch.decide(0.0, WayHome(120.0, 120.0)).verdict is Verdict.RETURN
    assert watch.decide(1.0, WayHome(0.0, 0.0)).verdict is Verdict.RETURN
    watch.take_off()
    watch.offer(2.0, 1.0)
    assert watch.decide(2.0, WayHome(0.0, 0.0)).verdict is Verdict.GO_ON


@given(CHARGES, CHARGES, TIMES_S, TIMES_S)
def test_less_charge_or_a_longer_way_is_never_less_cautious(one, other, here_s, there_s):
    low, high = sorted((one, other))
    near_s, far_s = sorted((here_s, there_s))
    assert verdict(low, far_s).verdict >= verdict(high, near_s).verdict


@given(CHARGES, TIMES_S, st.floats(0.0, 6.0))
def test_going_on_leaves_the_reserve_after_the_way_home_with_its_margin(charge, time_s, age_s):
    decision = verdict(charge, time_s, age_s)
    if decision.verdict is Verdict.GO_ON:
        assert (
            charge - (age_s + 1.3 * time_s + P.settling_time + P.landing_time) / P.endurance
            >= P.reserve - 1e-9
        )


def fly(seed, lasts_s=(300.0, 1500.0), least_charge=0.5):
    """Fly out at 1 m/s until told to return, then home; return the charge and whether it got home.

    The battery lasts 5 to 25 minutes, sinks by up to 20 % faster on the way home (head wind), tells whole
    percents every 2 s, and sometimes NaN, too much, or nothing.
    """
    rng = np.random.default_rng(seed)
    rate, wind = 1.0 / rng.uniform(*lasts_s), rng.uniform(1.0, 1.2)
    watch, charge, distance_m, outward = EnergyWatch(), rng.uniform(least_charge, 1.0), 0.0, True
    now_s = 0.0
    while outward or distance_m > 0.0:
        if now_s % 2.0 == 0.0 and (now_s == 0.0 or rng.random() > 0.1):
            odd = now_s > 0.0 and rng.random() < 0.1
            watch.offer(now_s, rng.choice([math.nan, 1.0, -0.01]) if odd else round(charge, 2))
        verdict = watch.decide(now_s, WayHome(distance_m, distance_m)).verdict
        if verdict is Verdict.LAND or charge <= 0.0:
            return charge, False
        outward = outward and verdict is Verdict.GO_ON
        now_s += 1.0
        distance_m += 1.0 if outward else -1.0
        charge -= rate * (1.0 if outward else wind)
    return charge - rate * P.landing_time, True


def test_hundreds_of_flights_come_home_with_the_reserve():
    """The reserve less the rounding of what the battery tells; the issue's bound is 10 %."""
    landed = [fly(seed) for seed in range(300)]
    assert all(home for _, home in landed)
    left = np.array([charge for charge, _ in landed])
    assert left.min() >= P.reserve - 0.02


def test_a_weak_battery_that_is_empty_before_the_window_is_full_brings_the_uav_home():
    """It lasts 1 to 5 minutes in place of the 10 that are supposed. A flight to its end comes back."""
    landed = [fly(seed, lasts_s=(60.0, 300.0), least_charge=0.9) for seed in range(300)]
    assert all(home for _, home in landed)
    assert min(charge for charge, _ in landed) > P.land_at


@pytest.mark.table("wrong", [0.0, 0.04, 0.11])
def test_one_wrong_reading_neither_lands_it_nor_brings_it_home(wrong):
    watch = EnergyWatch()
    for now_s in range(0, 60, 2):
        watch.offer(now_s, wrong if now_s == 30 else 0.8 - now_s / 600.0)
        assert watch.decide(now_s + 1.0, WayHome(30.0, 30.0)).verdict is Verdict.GO_ON


def test_an_empty_battery_lands_it_with_the_second_reading():
    watch = EnergyWatch()
    watch.offer(0.0, 0.8)
    watch.offer(2.0, 0.0)
    assert watch.decide(2.0, WayHome(30.0, 30.0)).verdict is Verdict.GO_ON
    watch.offer(4.0, 0.0)
    assert watch.decide(4.0, WayHome(30.0, 30.0)).verdict is Verdict.LAND
