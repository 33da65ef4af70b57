"""Between two parts of its flight the UAV gets a full battery, if it flies by one."""

from types import SimpleNamespace

import pytest

from flights.errors import FlightError
from flights.exploring.itinerary import Itinerary, Next

led_flight_node = pytest.importorskip(
    "flights_ros.drivers.led_flight_node", reason="needs the workspace's environment"
)
batteries = pytest.importorskip("flights_ros.drivers.batteries", reason="needs the workspace's environment")


class Part:
    node = "/inspect"


@pytest.mark.parametrize(("use_battery", "swaps"), [(True, ["px4"]), (False, [])])
def test_only_a_battery_that_gets_empty_is_swapped(monkeypatch, use_battery, swaps):
    called = []
    parameters = {"/inspect/use_battery": use_battery}
    monkeypatch.setattr(led_flight_node.rospy, "get_param", parameters.get)
    monkeypatch.setattr(
        led_flight_node.batteries, "swap", lambda autopilot, _charge: called.append(autopilot)
    )
    monkeypatch.setattr(led_flight_node.LedFlightNode, "_take_off", lambda _: called.append("take off"))
    node = object.__new__(led_flight_node.LedFlightNode)
    node._itinerary, node._parts, node._follows = Itinerary(1, 2), [Part], Next.AGAIN
    node._autopilot = "px4"
    node._go_on()
    assert called == [*swaps, "take off"]


class Px4:
    """Parameters of PX4 SITL, and its battery: it is never below one of them, and sinks by nothing here."""

    def __init__(self, stays_at, charge, fills=True):
        self.parameter, self.charge, self.names, self._fills = stays_at, charge, [], fills

    def __call__(self, name, _kind, *arguments):
        self.names.append(name)
        if name.endswith("/set"):
            self.parameter = arguments[1].real
            if self._fills:
                self.charge = max(self.charge, 0.01 * self.parameter)
        return SimpleNamespace(value=SimpleNamespace(integer=0, real=self.parameter))


@pytest.mark.parametrize("stays_at", [50.0, 0.0])
def test_px4s_own_battery_begins_again_and_its_parameter_is_as_before(stays_at):
    px4 = Px4(stays_at, charge=0.2)
    batteries.swap("px4", lambda: px4.charge, px4)
    assert (px4.charge, px4.parameter) == (1.0, stays_at)
    assert px4.names == ["/mavros/param/get", "/mavros/param/set", "/mavros/param/set"]


def test_a_battery_of_px4_that_stays_empty_is_told_and_its_parameter_is_as_before(monkeypatch):
    monkeypatch.setattr(batteries, "PATIENCE_S", 0.0)
    monkeypatch.setattr(batteries, "LOOK_S", 0.0)
    px4 = Px4(30.0, charge=0.3, fills=False)
    with pytest.raises(FlightError, match=r"after SIM_BAT_MIN_PCT was set to 100, PX4 tells 30%\."):
        batteries.swap("px4", lambda: px4.charge, px4)
    assert px4.parameter == 30.0


@pytest.mark.parametrize(("autopilot", "calls"), [("standin", ["/gazebo/swap_battery"]), ("ardupilot", [])])
def test_the_simulators_battery_is_swapped_and_ardupilots_never_gets_empty(autopilot, calls):
    called = []
    batteries.swap(autopilot, lambda: 1.0, lambda name, _kind: called.append(name))
    assert called == calls
