"""Commands, references and their stamps on the way to a yaw rate."""

from __future__ import annotations

import pytest

from inspection_tools import YawRegulatorParameters, YawSteering

S = 1_000_000_000
LEFT, STANDS = (0.0, 1.0), (0.0, 0.0)
LOOKS_LEFT = 1.0
"""The greatest rate, because 1.5 / s times 90 degrees is more."""


def test_a_uav_that_is_held_back_looks_where_it_is_wanted_to_fly():
    steering = YawSteering()
    assert not steering.on_reference(S, LEFT)
    assert steering.on_command(S, STANDS, "held back") == [("held back", LOOKS_LEFT)]


@pytest.mark.table(("age_s", "rate"), [(0.5, LOOKS_LEFT), (0.6, 0.0)])
def test_an_old_reference_counts_as_none(age_s, rate):
    steering = YawSteering(YawRegulatorParameters(reference_max_age=0.5))
    steering.on_reference(S, LEFT)
    assert steering.on_command(S + round(age_s * S), STANDS)[0].yaw_rate_rad_s == rate


def test_a_command_waits_for_the_reference_of_its_stamp():
    steering = YawSteering()
    steering.on_reference(S, STANDS)
    steering.on_command(S, STANDS)
    assert not steering.on_command(2 * S, STANDS, "waits")
    assert steering.on_reference(2 * S, LEFT) == [("waits", LOOKS_LEFT)]


def test_the_yaw_rate_changes_no_faster_than_it_may():
    steering = YawSteering(YawRegulatorParameters(max_yaw_acceleration=4.0))
    assert steering.on_command(S, STANDS)[0].yaw_rate_rad_s == 0.0
    rates = []
    for turn in range(1, 41):
        stamp_ns = S + turn * S // 20
        steering.on_front(stamp_ns, LEFT if turn <= 10 or turn % 2 else (0.0, -1.0))
        rates.append(steering.on_command(stamp_ns, (1.0, 0.0))[0].yaw_rate_rad_s)
    assert rates[:10] == pytest.approx([0.2, 0.4, 0.6, 0.8, *[LOOKS_LEFT] * 6])
    assert max(abs(a - b) for a, b in zip(rates, rates[1:])) == pytest.approx(0.2)  # 4 rad/s^2 for 0.05 s
    steering.restart()
    assert steering.on_command(S, (0.0, -1.0))[0].yaw_rate_rad_s == -LOOKS_LEFT


def test_after_a_restart_nothing_of_before_counts():
    steering = YawSteering()
    steering.on_reference(S, LEFT)
    steering.restart()
    assert steering.on_command(S, STANDS)[0].yaw_rate_rad_s == 0.0


def test_a_front_that_is_told_counts_whatever_the_velocity_for_as_long_as_a_reference():
    steering = YawSteering(YawRegulatorParameters(reference_max_age=0.5))
    steering.on_front(S, (0.0, -1.0))
    assert steering.on_command(S, (1.0, 0.0))[0].yaw_rate_rad_s == -LOOKS_LEFT
    assert steering.on_command(S + S // 2, STANDS)[0].yaw_rate_rad_s == -LOOKS_LEFT
    assert steering.on_command(2 * S, STANDS)[0].yaw_rate_rad_s == 0.0
    steering.on_front(3 * S, (0.0, -1.0))
    steering.on_front(3 * S, STANDS)
    assert steering.on_command(3 * S, STANDS)[0].yaw_rate_rad_s == 0.0
