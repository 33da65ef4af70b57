"""What the server accepts, refuses and understands, without a graph."""

import threading
from types import SimpleNamespace

import pytest

pytestmark = pytest.mark.ros

WHY = "needs the workspace's environment: source devel/setup.bash"
tuning_server = pytest.importorskip("node_tools.tuning_server", reason=WHY)
messages = pytest.importorskip("dynamic_reconfigure.msg", reason=WHY)
encoding = pytest.importorskip("dynamic_reconfigure.encoding", reason=WHY)


def described(name, kind, default, least, most):
    return {
        "name": name,
        "type": kind,
        "default": default,
        "min": least,
        "max": most,
        "level": 0,
        "description": "A sentence.",
        "edit_method": "",
    }


def group(name, number, parameters, groups=()):
    return {
        "name": name,
        "id": number,
        "parent": 0,
        "type": "",
        "state": True,
        "parameters": list(parameters),
        "groups": list(groups),
    }


NUMBER, TEXT = described("size", "double", 1.0, 0.0, 2.0), described("words", "str", "a", "", "")
TYPES = SimpleNamespace(  # what a .cfg file becomes: a group in a group, one number, one text
    config_description=group("Default", 0, [TEXT], [group("Inner", 1, [NUMBER])]),
    defaults={"size": 1.0, "words": "a"},
    min={"size": 0.0, "words": ""},
    max={"size": 2.0, "words": ""},
)


@pytest.fixture
def said(monkeypatch):
    """The warnings."""
    sentences = []
    monkeypatch.setattr(tuning_server.rospy, "logwarn", sentences.append)
    return sentences


@pytest.fixture
def server(monkeypatch, said):
    """A server whose topics and parameters lead nowhere."""
    made = object.__new__(tuning_server.TuningServer)
    made.mutex, made.type, made.config = threading.Lock(), TYPES, encoding.Config(TYPES.defaults)
    made.callback = lambda config, level: config
    monkeypatch.setattr(made, "_copy_to_parameter_server", lambda: None, raising=False)
    made.update_topic = SimpleNamespace(publish=lambda message: None)
    return made


def test_what_is_within_its_limits_is_applied(server, said):
    assert server.update_configuration({"size": 2.0, "words": "b"})["size"] == 2.0
    assert (server.config["words"], said) == ("b", [])


@pytest.mark.parametrize("value", [-3.0, 2.1, float("nan")])
def test_what_is_beyond_a_limit_is_refused_by_its_own_name(server, said, value):
    applied = server.update_configuration({"size": value, "words": "b"})
    assert (applied["size"], applied["words"]) == (1.0, "b")
    assert len(said) == 1
    assert said[0].startswith("size must be from 0 to 2")


def test_a_request_with_groups_as_dynparam_load_sends_it_is_understood(server):
    state = [messages.GroupState("Default", True, 0, 0), messages.GroupState("Inner", True, 1, 0)]
    config = messages.Config(doubles=[messages.DoubleParameter("size", 0.5)], groups=state)
    answer = server._set_callback(SimpleNamespace(config=config))
    assert [(p.name, p.value) for p in answer.doubles] == [("size", 0.5)]


@pytest.mark.parametrize(("ends", "raised"), [(True, "ServiceException"), (False, "ROSException")])
def test_a_request_that_comes_while_the_node_ends_is_answered_with_a_sentence(
    server, monkeypatch, ends, raised
):
    def publish(message):
        raise tuning_server.rospy.ROSException("publish() to a closed topic")

    server.update_topic = SimpleNamespace(publish=publish)
    monkeypatch.setattr(tuning_server.rospy, "is_shutdown", lambda: ends)
    with pytest.raises(Exception, match="The node ends" if ends else "closed topic") as refused:
        server.update_configuration({"size": 0.5})
    assert type(refused.value).__name__ == raised


def test_parameters_are_read_and_written_at_once_and_others_stay(server, monkeypatch):
    stored, calls = {"~": {"size": 0.5, "not_tuned": [1, 2]}}, []
    parameters = SimpleNamespace(
        get_param=lambda name, default: calls.append(name) or stored.get(name, default),
        set_param=lambda name, value: calls.append(name) or stored.update({name: value}),
    )
    monkeypatch.setattr(tuning_server, "rospy", parameters)
    server.ns = "~"
    server._copy_from_parameter_server()
    assert dict(server.config) == {"size": 0.5, "words": "a"}
    server.config["size"] = 0.7
    tuning_server.TuningServer._copy_to_parameter_server(server)
    assert stored["~"] == {"size": 0.7, "words": "a", "not_tuned": [1, 2]}
    assert len(calls) == 3
