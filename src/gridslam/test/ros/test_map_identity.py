"""Which map it is: another name for each map that begins, the same one for a map that is taken up again."""

from types import SimpleNamespace

import numpy as np
import pytest

pytestmark = pytest.mark.ros

map_identity = pytest.importorskip("gridslam_ros.publishing.map_identity", reason="needs ROS")


@pytest.fixture
def begun(monkeypatch):
    """Starts the node's identity: what it publishes, on one parameter server."""
    parameters, told = {}, []
    publisher = SimpleNamespace(publish=lambda name: told.append(str(name)))
    for owner, name, function in [
        (map_identity.rospy, "Publisher", lambda *_, **__: publisher),
        (map_identity.rospy, "get_time", lambda: 5.0),
        (map_identity.rospy, "get_param", lambda name, default=None: parameters.get(name, default)),
        (map_identity.rospy, "on_shutdown", lambda hook: None),
        (map_identity.KeptParameter, "_write", lambda self, told: parameters.__setitem__(self._name, told)),
    ]:
        monkeypatch.setattr(owner, name, function)

    def start(given=""):
        identity = map_identity.MapIdentity(given, SimpleNamespace(received=False))
        identity._kept._writer = SimpleNamespace(write=identity._kept._write)
        return identity, told

    return start


def session(first_s, odom_in_map=(0.0, 0.0, 0.0)):
    path = SimpleNamespace(stamps_s=np.array([first_s, first_s + 1.0]))
    return SimpleNamespace(slam=object(), trajectory=lambda: path, map_to_odom=odom_in_map)


def test_each_map_that_begins_has_a_name_of_its_own_even_at_the_same_stamp(begun):
    identity, told = begun()
    one, other = session(1731.25), session(1731.25)
    for each in (one, one, other):
        identity.tell(each, is_saved=False)
    assert told == ["1731.250-1", "1731.250-2"]


def test_a_map_that_is_loaded_again_keeps_its_name(begun):
    identity, told = begun()
    identity.tell(session(100.0), is_saved=False)
    identity.tell(session(100.0), is_saved=True)  # its own state
    identity.tell(session(7.0), is_saved=True)  # another one's, wherever it is loaded
    assert told == ["100.000-1", "100.000-1", "7.000-0"]
    again, told = begun("deck.yaml")
    again.tell(session(100.0), is_saved=False)
    assert told[-1] == "deck.yaml"


def test_a_node_that_died_finds_its_frame_and_gives_its_map_another_name(begun):
    identity, _ = begun()
    identity.tell(session(100.0), is_saved=False)
    identity.keep(160.0, session(100.0, (3.0, -1.0, 0.2)), (20.0, 4.0, 1.0))
    again, told = begun()
    assert again.former() == (160.0, (3.0, -1.0, 0.2), (20.0, 4.0, 1.0))
    again.tell(session(162.0), is_saved=False)
    assert told[-1] == "162.000-2"
    assert begun("deck.yaml")[0].former() is None
