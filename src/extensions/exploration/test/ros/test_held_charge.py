"""At which charge a simulated battery stays is asked of the flight controller, by MAVROS."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from exploration.energy import EnergyParameters, EnergyWatch, Verdict, WayHome

held_charge = pytest.importorskip("exploration_ros.held_charge", reason="needs the workspace's environment")

HOME = WayHome(time_s=20.0, length_m=10.0)


def answer(success, real):
    return SimpleNamespace(success=success, value=SimpleNamespace(integer=0, real=real))


def verdict_after_a_flight(monkeypatch, name, *answers):
    """At 30 % for 400 s, after these answers of MAVROS; and the names that it was asked for."""
    monkeypatch.setattr(held_charge.rospy, "get_param", {"~held_by": name}.get)
    monkeypatch.setattr(held_charge.rospy, "logwarn", lambda *_: None)
    asked, left = [], list(answers)

    def call(parameter):
        asked.append(parameter)
        return left.pop(0) if left else answer(False, 0.0)

    energy = EnergyWatch(EnergyParameters())
    held = held_charge.HeldCharge(energy, call)
    if name:
        held.ask_now(again_s=0.0)
    else:
        held.ask()
    for i in range(200):
        energy.offer(2.0 * i, 0.3)
    return energy.decide(400.0, HOME).verdict, asked


def test_the_battery_of_px4_sitl_is_not_frozen_where_it_stays(monkeypatch):
    verdict, asked = verdict_after_a_flight(
        monkeypatch, "SIM_BAT_MIN_PCT", answer(False, 0.0), answer(True, 30.0)
    )
    assert (verdict, asked) == (Verdict.GO_ON, ["SIM_BAT_MIN_PCT"] * 2)


@pytest.mark.parametrize("stays_at", [50.0, 0.0])
def test_it_is_elsewhere(monkeypatch, stays_at):
    assert verdict_after_a_flight(monkeypatch, "SIM_BAT_MIN_PCT", answer(True, stays_at))[0] is Verdict.LAND


def test_a_real_battery_is_not_asked_about_and_one_that_nobody_knows_may_be_frozen(monkeypatch):
    assert verdict_after_a_flight(monkeypatch, "") == (Verdict.LAND, [])
    verdict, asked = verdict_after_a_flight(monkeypatch, "SIM_BAT_MIN_PCT")
    assert (verdict, len(asked)) == (Verdict.LAND, held_charge.TRIES)
