"""What is asked of other nodes before a UAV takes off again, and what keeps it on the ground."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from flights.errors import FlightError

rospy = pytest.importorskip("rospy", reason="needs the workspace's environment")
taking_off = pytest.importorskip("flights_ros.drivers.taking_off", reason="needs the workspace's environment")


class Services:
    """Notes what is called. room_m: above the UAV."""

    def __init__(self, room_m):
        self.calls, self._room_m = [], room_m

    def __call__(self, name, kind, *arguments):
        self.calls.append((name, *arguments))
        return SimpleNamespace(room=self._room_m)

    @property
    def names(self):
        return [name for name, *_ in self.calls]


NAMES = ["/inspect/room_above", "/mavros_publisher/set_parameters", "/mavros_publisher/restart"]


@pytest.mark.parametrize(("room_m", "height_m"), [(5.0, 2.0), (1.0, 1.12)])
def test_it_rises_to_its_usual_height_or_as_far_as_there_is_room(room_m, height_m):
    services = Services(room_m)
    assert taking_off.take_off_again("/inspect", 2.0, 0.12, services) == pytest.approx(height_m)
    assert services.names == NAMES
    (_, wanted_m), (_, config), _ = services.calls
    assert wanted_m == 2.0
    assert [(each.name, each.value) for each in config.doubles] == [("hover_height", pytest.approx(height_m))]


def test_the_first_take_off_is_told_its_height_and_then_ordered():
    services = Services(0.0)
    taking_off.take_off(0.49, services)
    assert services.names == NAMES[1:]
    (_, config), _ = services.calls
    assert [(each.name, each.value) for each in config.doubles] == [("hover_height", 0.49)]


def test_without_room_it_stays_on_the_ground():
    services = Services(0.1)
    with pytest.raises(FlightError, match="stays on the ground"):
        taking_off.take_off_again("/inspect", 2.0, 0.12, services)
    assert services.names == NAMES[:1]


def with_answers(monkeypatch, answers):
    """Let a service give these answers one after the other, or raise them. Return how long it slept."""
    left, slept_s = list(answers), []

    def called(*_):
        answer = left.pop(0)
        if isinstance(answer, Exception):
            raise answer
        return answer

    monkeypatch.setattr(taking_off, "ServiceCall", lambda name, kind, patience_s: called)
    monkeypatch.setattr(taking_off.time, "sleep", slept_s.append)
    return slept_s


def test_a_service_that_fails_is_called_again(monkeypatch):
    good = SimpleNamespace(success=True)
    bad = (rospy.ServiceException("it starts"), SimpleNamespace(success=False, message="the rotors turn"))
    slept_s = with_answers(monkeypatch, (*bad, good))
    assert taking_off.call_service("/gazebo/swap_battery", None) is good
    assert slept_s == [0.5, 0.5]


def test_one_that_goes_on_failing_is_told_with_its_reason(monkeypatch):
    refusals = [SimpleNamespace(success=False, message="the rotors turn")] * 20
    with_answers(monkeypatch, refusals)
    with pytest.raises(FlightError, match="/gazebo/swap_battery says: the rotors turn"):
        taking_off.call_service("/gazebo/swap_battery", None)


@pytest.mark.parametrize("kind", ["ParamGet", "ParamSet"])
def test_one_whose_refusal_has_no_reason_is_told_all_the_same(monkeypatch, kind):
    services = pytest.importorskip("mavros_msgs.srv", reason="needs the workspace's environment")
    with_answers(monkeypatch, [getattr(services, f"{kind}Response")(success=False)] * 20)
    with pytest.raises(FlightError, match="/mavros/param says: no, and gives no reason"):
        taking_off.call_service("/mavros/param", None)
