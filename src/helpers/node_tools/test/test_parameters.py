"""A node asks the parameter server once for all its parameters, and sets them once."""

from __future__ import annotations

from dataclasses import dataclass

import pytest

pytestmark = pytest.mark.ros

parameters = pytest.importorskip(
    "node_tools.parameters", reason="needs the workspace's environment: source devel/setup.bash"
)


@dataclass(frozen=True)
class Sizes:
    """Parameters of a node."""

    length: float = 1.0
    count: int = 2
    name: str = "a"
    wide: bool = False


class Server:
    """A parameter server with the private parameters of one node, which counts its calls."""

    def __init__(self, given):
        self.given, self.calls = given, []

    def get_param(self, name, default):
        self.calls.append("get")
        assert name == "~"
        return self.given if self.given is not None else default

    def set_param(self, name, value):
        self.calls.append("set")
        assert name == "~"
        self.given = value


@pytest.fixture
def server(monkeypatch, request):
    """Be the parameter server; the test's parameter is what is set there."""
    found = Server(request.param)
    monkeypatch.setattr(parameters.rospy, "get_param", found.get_param)
    monkeypatch.setattr(parameters.rospy, "set_param", found.set_param)
    return found


@pytest.mark.parametrize("server", [{"length": 3, "name": 7, "other": {"kept": 1}}], indirect=True)
def test_parameters_are_read_and_written_in_one_call_each(server):
    assert parameters.read_parameters(Sizes) == Sizes(3.0, 2, "7", False)
    # What dynamic_reconfigure reads has the wanted types, and what belongs to others stays
    assert server.given == {
        "length": 3.0,
        "count": 2,
        "name": "7",
        "wide": False,
        "other": {"kept": 1},
    }
    assert server.calls.count("set") == 1
    assert len(server.calls) <= 3  # whatever the number of parameters


@pytest.mark.parametrize("server", [None], indirect=True)
def test_without_any_parameter_the_defaults_count(server):
    assert parameters.read_parameters(Sizes) == Sizes()


@pytest.mark.parametrize("server", [{"model": {"hit": 0.7, "miss": 1}, "max": 3}], indirect=True)
def test_a_name_may_lead_into_a_namespace(server):
    defaults = {"model/hit": 0.5, "model/miss": 0.4, "model/none": 0.1, "max/none": 2.0}
    found = parameters.read_values(defaults)
    assert found == {"model/hit": 0.7, "model/miss": 1.0, "model/none": 0.1, "max/none": 2.0}
    assert server.calls == ["get"]
