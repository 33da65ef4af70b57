"""No node can block for ever, or for long, while it holds a lock that a callback takes.

rospy holds no lock of its own while it calls a callback, and a publisher with a queue never waits. So a node
may publish under its own lock, and does: a node's end waits for it. actionlib holds its lock in callbacks and
in calls to it. So the one class with an action server (`ErrandServer`) has no lock: its callbacks fill an
inbox. dynamic_reconfigure holds its lock in callbacks, too.
"""

import ast
from functools import cache

from locked_calls import LockedCall, LockedCalls, NodeClass, classes_in, dotted
from python_sources import folder_of, sources

ENDS = {"set_succeeded", "set_aborted", "set_canceled", "set_accepted", "publish_feedback"}
"""Methods of actionlib's goals that take its lock."""
BLOCKS = {"wait_for_service", "wait_for_message", "wait_for_result", "wait_for_server", "sleep", "wallsleep"}
BLOCKS |= {"get_param", "set_param", "has_param", "delete_param"}  # the master may be far away
BLOCKS |= {"join", "result", "communicate", "check_call", "check_output", "urlopen", "recv", "accept"}


@cache
def classes() -> list[NodeClass]:
    """Return the nodes' classes."""
    return [each for path in sources("ros") for each in classes_in(path)]


@cache
def locked_calls() -> list[LockedCall]:
    """Return what all classes call under a lock."""
    calls = LockedCalls(classes())
    return [call for owner in classes() for call in calls.of(owner)]


@cache
def servers() -> list[NodeClass]:
    """Return the classes that have an action server."""
    return [each for each in classes() if {"SimpleActionServer", "ActionServer"} & set(each.made_by.values())]


def blocks(call):
    """Whether a call waits for something else than the lock that is held."""
    *owner, last = call.call.split(".")
    if owner[:1] == ["subprocess"] or (last in BLOCKS and owner[:2] != ["os", "path"]):
        return True
    if "self" in owner and call.made_by == "Thread":
        return last == "join"
    is_service = call.made_by in {"ServiceProxy", "ServiceCall"}
    waits = last in {"wait", "wait_for"} and call.made_by in {"Event", "Condition", "Popen"}
    return is_service or (waits and ".".join(owner) != call.lock)


KNOWN = {
    # The node's own condition is over the lock that is held.
    "mavros_publisher: MavrosPublisherNode._on_velocity": {"self._pose_came.wait_for"},
}


def test_no_node_waits_for_anything_under_a_lock():
    found = [call for call in locked_calls() if blocks(call)]
    assert [call for call in found if call.call not in KNOWN.get(call.where, set())] == []


def test_whoever_has_an_action_server_has_no_lock():
    # actionlib holds its own in callbacks, and in calls to it: another one could deadlock with it
    assert [owner.path.name for owner in servers()] == ["errand_server.py"]
    for owner in servers():
        assert owner.locks == set(), owner.path.name
        assert LockedCalls(classes()).of(owner) == []


def test_an_errand_has_no_lock():
    errand = sorted((folder_of("flight_basics") / "src/flight_basics/errand").glob("*.py"))
    assert len(errand) > 5
    for path in errand:
        text = path.read_text(encoding="utf-8")
        assert not any(f"{kind}(" in text for kind in ("Lock", "RLock", "Condition")), path.name


def test_a_goal_s_callback_only_hands_it_on():
    for owner in servers():
        text = "".join(ast.unparse(owner.methods[name]) for name in ("_on_goal", "_on_cancel"))
        assert not any(each in text for each in (".wait", "identity_of(", *(f".{end}(" for end in ENDS)))


def test_nobody_reconfigures_under_a_lock():
    # dynamic_reconfigure holds its lock while it calls back, and the callback takes the node's
    assert [call for call in locked_calls() if call.call.endswith(".update_configuration")] == []


def test_a_publisher_never_waits_for_a_subscriber():
    for path in sources("ros"):
        if "rospy.Publisher" not in path.read_text(encoding="utf-8"):
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and dotted(node.func).endswith("rospy.Publisher"):
                given = {keyword.arg for keyword in node.keywords}
                assert "queue_size" in given, f"{path.name}: {ast.unparse(node)}"


def test_the_reading_of_sources_sees_a_wait_under_a_lock(tmp_path):
    # Given a class that waits in a method which it calls under its lock, and in one of an object that it has
    source = tmp_path / "node.py"
    source.write_text(
        "class Other:\n"
        "    def ask(self):\n"
        "        rospy.wait_for_service('x')\n"
        "class Node:\n"
        "    def __init__(self):\n"
        "        self._lock = threading.Lock()\n"
        "        self._other, self._call = Other(), rospy.ServiceProxy('x', Y)\n"
        "    def _on_pose(self):\n"
        "        with self._lock:\n"
        "            self._act()\n"
        "            self._other.ask()\n"
        "    def _act(self):\n"
        "        self._call(1)\n"
        "        self._later(lambda: time.sleep(1.0))\n"
    )
    read = list(classes_in(source))
    found = [call.call for call in LockedCalls(read).of(read[1]) if blocks(call)]
    assert found == ["self._call", "rospy.wait_for_service"]
