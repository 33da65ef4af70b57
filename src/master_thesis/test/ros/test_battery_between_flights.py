"""Between two parts of its flight the UAV gets a full battery, if it flies by one."""

import pytest

from master_thesis.exploring.errand import Errand, Next

errand_node = pytest.importorskip(
    "master_thesis_ros.experiments.errand_node", reason="needs the workspace's environment"
)


class Part:
    node = "/inspect"


@pytest.mark.parametrize(("use_battery", "swaps"), [(True, ["/gazebo/swap_battery"]), (False, [])])
def test_only_a_battery_that_gets_empty_is_swapped(monkeypatch, use_battery, swaps):
    called = []
    parameters = {"/inspect/use_battery": use_battery}
    monkeypatch.setattr(errand_node.rospy, "get_param", parameters.get)
    monkeypatch.setattr(errand_node, "call_service", lambda name, _kind: called.append(name))
    monkeypatch.setattr(errand_node.ErrandNode, "_take_off", lambda _: called.append("take off"))
    node = object.__new__(errand_node.ErrandNode)
    node._errand, node._parts, node._follows = Errand(1, 2), [Part], Next.AGAIN
    node._go_on()
    assert called == [*swaps, "take off"]
