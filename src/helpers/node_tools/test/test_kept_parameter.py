"""What a node that died finds again, and who else does not: without a graph."""

import os
import subprocess
import sys
import threading
from types import SimpleNamespace

import pytest

pytestmark = pytest.mark.ros

kept_parameter = pytest.importorskip("node_tools.restarts.kept_parameter", reason="needs ROS")
BEGUN = "~begun"


@pytest.fixture
def server(monkeypatch):
    """A parameter server, and a node's end. `end()` ends the node as rospy does."""
    parameters, hooks = {}, []

    def end():
        while hooks:
            hooks.pop(0)()

    fake = {
        "get_param": lambda name, default=None: parameters.get(name, default),
        "set_param": parameters.__setitem__,
        "delete_param": parameters.pop,
        "on_shutdown": hooks.append,
    }
    for name, function in fake.items():
        monkeypatch.setattr(kept_parameter.rospy, name, function)
    return SimpleNamespace(parameters=parameters, end=end)


def ending(received=False):
    return SimpleNamespace(received=received)


def kept(values=None, end=None):
    parameter = kept_parameter.KeptParameter(BEGUN, end or ending())
    if values is not None:
        parameter.keep(values)
    return parameter.values


def test_a_node_that_died_finds_what_it_kept(server):
    kept({"home": [1.0, 2.0]})
    assert kept() == {"home": [1.0, 2.0]}


def test_a_later_launch_finds_nothing(server, monkeypatch):
    kept({"home": [1.0, 2.0]})
    monkeypatch.setattr(kept_parameter, "launch_of_this_process", lambda: "another one")
    assert kept() == {}


@pytest.mark.parametrize("foreign", [None, 3, "words", {"home": [1.0]}, {"launch": 5}])
def test_what_others_wrote_there_does_not_count(server, foreign):
    server.parameters[BEGUN] = foreign
    assert kept() == {}


def test_a_signal_takes_it_away_and_another_end_does_not(server):
    told = ending()
    kept({"home": [1.0]}, told)
    server.end()  # rosnode kill
    assert BEGUN in server.parameters
    kept({"home": [1.0]}, told)
    told.received = True
    server.end()
    assert server.parameters == {}


def test_what_another_node_of_this_name_has_written_since_stays(server):
    told = ending()
    kept({"home": [1.0]}, told)
    server.parameters[BEGUN] = {"home": [2.0]}
    told.received = True
    server.end()
    assert server.parameters == {BEGUN: {"home": [2.0]}}


def test_after_the_signal_nothing_is_kept(server):
    kept({"home": [1.0]}, ending(received=True))
    assert server.parameters == {}


def test_without_a_master_the_node_goes_on(server, monkeypatch):
    def refuse(*_):
        raise ConnectionRefusedError

    monkeypatch.setattr(kept_parameter.rospy, "set_param", refuse)
    parameter = kept_parameter.KeptParameter(BEGUN)
    parameter.keep({"home": [1.0]})
    assert parameter.values == {"home": [1.0]}


PRINT = "from node_tools.restarts.launch import launch_of_this_process as launch; print(launch())"
LAUNCH = f"""import subprocess, sys
for _ in range(2):
    subprocess.run([*sys.argv[1:], sys.executable, "-c", {PRINT!r}], start_new_session=True)
"""


def launched(*prefix):
    """What two nodes of one parent tell as their launch; each has a session of its own."""
    path = os.pathsep.join(filter(None, sys.path))
    command = [sys.executable, "-c", LAUNCH, *prefix]
    told = subprocess.run(command, env={**os.environ, "PYTHONPATH": path}, capture_output=True, text=True)
    return told.stdout.splitlines()


@pytest.mark.table("prefix", [(), ("nice", "-n", "1"), ("sh", "-c", '"$@"; true', "sh")])
def test_nodes_of_one_parent_are_of_one_launch_and_those_of_another_are_not(prefix):
    first, second = launched(*prefix), launched(*prefix)
    assert len(first) == len(second) == 2
    assert first[0] == first[1]
    assert second[0] == second[1] != first[0]


def test_a_master_that_hangs_does_not_hold_up_the_flight_and_gets_the_newest_later(server, monkeypatch):
    # Given a master that takes a parameter only when it is let go
    go_on, begun, written, asked = threading.Event(), threading.Event(), threading.Event(), []

    def hang(name, told):
        asked.append(told)
        begun.set()
        go_on.wait()
        server.parameters[name] = told
        if told["reached"] == 3:
            written.set()

    monkeypatch.setattr(kept_parameter.rospy, "set_param", hang)
    parameter = kept_parameter.KeptParameter(BEGUN, ending())
    # When three values are kept, then nobody waits for the end
    parameter.keep({"reached": 1})
    assert begun.wait(30.0)
    for reached in (2, 3):
        parameter.keep({"reached": reached})
    assert [told["reached"] for told in asked] == [1]
    assert not server.parameters
    # When the master goes on, then it has the newest
    go_on.set()
    assert written.wait(30.0)
    assert [told["reached"] for told in asked] == [1, 3]
