"""While the UAV stands, simulated time passes slowly, but no more slowly than heartbeats may come."""

from __future__ import annotations

import pytest

services = pytest.importorskip(
    "flights_ros.drivers.simulator_services", reason="needs the workspace's environment"
)


def test_our_stand_in_for_mavros_waits_in_simulated_time():
    assert services.slow_pace(None) == services.SLOW


@pytest.mark.parametrize(("waits_s", "pace"), [(10.0, 0.3), (60.0, services.SLOW), (2.0, 1.0)])
def test_real_mavros_gets_three_heartbeats_while_it_waits_for_one(waits_s, pace):
    """At 0.1, one came every 10 s of wall time, and MAVROS lost PX4 after 10 s."""
    assert services.slow_pace(waits_s) == pytest.approx(pace)


@pytest.mark.parametrize(
    ("parameters", "pace"),
    [({}, 0.1), ({"/mavros/conn/timeout": 10.0}, 0.3), ({"/mavros/conn/timeout": 5.0}, 0.6)],
)
def test_the_simulator_is_told(monkeypatch, parameters, pace):
    told = []
    monkeypatch.setattr(services.rospy, "get_param", parameters.get)
    monkeypatch.setattr(services, "ServiceCall", lambda *_: told.append)
    monkeypatch.setattr(services.threading, "Thread", AtOnce)
    services.slow_down()
    assert [(each.name, each.value) for (config,) in [told] for each in config.doubles] == [
        ("real_time_factor", pytest.approx(pace))
    ]


class AtOnce:
    """A thread that does its work when it is started."""

    def __init__(self, target, **_):
        self.start = target
