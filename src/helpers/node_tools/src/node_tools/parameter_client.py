"""Sets parameters of a running node by dynamic_reconfigure, and hears whether the node uses them."""

from __future__ import annotations

import sys
import time
from typing import Any, Callable, Mapping, Sequence

import rosgraph
import rospy
from dynamic_reconfigure import DynamicReconfigureException
from dynamic_reconfigure.client import Client
from dynamic_reconfigure.srv import Reconfigure
from rosgraph_msgs.msg import Log

from node_tools.ros_servers import UNREACHABLE, server
from node_tools.services import ServiceCall

PATIENCE_S = 5.0
"""Wall time to wait for the node's descriptions and for its service."""
WORDS_S = 1.0
"""Wall time to wait for the connection to the node's log, and then for its words."""
SERVICE = "/set_parameters"
USAGE = "usage: rosrun node_tools set_parameter NODE NAME VALUE [NAME VALUE ...]"


def main(words: Sequence[str]) -> int:
    """Set the parameters of the command line; return the exit code."""
    if len(words) < 3 or len(words) % 2 == 0:
        print(USAGE, file=sys.stderr)
        return 2
    node, wanted = words[0], dict(zip(words[1::2], words[2::2]))
    try:
        refused = set_parameters(rosgraph.names.resolve_name(node, "/"), wanted)
    except (DynamicReconfigureException, rospy.ROSException) as error:
        refused = [f"{node} takes no {' and '.join(wanted)}: {error}."]
    for sentence in refused:
        print(sentence, file=sys.stderr)
    if not refused:
        print(f"{node} uses {', '.join(f'{name} = {value}' for name, value in wanted.items())}.")
    return 1 if refused else 0


def set_parameters(node: str, wanted: Mapping[str, str]) -> list[str]:
    """Set parameters of a node, by name.

    Return sentences about those that it does not use, empty if it uses all.

    Raises:
        DynamicReconfigureException: there is no such parameter, or its value has another type.
        rospy.ROSException: the node does not answer.
    """
    try:
        server(rosgraph.get_master_uri()).getPid("/set_parameter")
    except UNREACHABLE:
        return [f"No ROS master answers at {rosgraph.get_master_uri()}; start one, or set ROS_MASTER_URI."]
    if not _offers_parameters(node):
        return [f"There is no node {node} with live parameters. {_those_with_parameters()}"]
    rospy.init_node("set_parameter", anonymous=True, disable_signals=True, disable_rosout=True)
    log = _Log(node)
    client = Client(node, timeout=PATIENCE_S)
    client._set_service = ServiceCall(f"{node}/set_parameters", Reconfigure)  # the original may wait for ever
    changes: dict[str, Any] = dict(wanted)
    used = client.update_configuration(changes)  # which gives the changes their types
    kept = [name for name in wanted if not _are_alike(changes[name], used[name])]
    said = log.words() if kept else []
    return said or [f"{node} keeps {name} at {used[name]}; it refuses {wanted[name]}." for name in kept]


def _offers_parameters(node: str) -> bool:
    return node in _with_parameters()


def _with_parameters() -> list[str]:
    """Return the nodes that serve live parameters, sorted."""
    services = server(rosgraph.get_master_uri()).getSystemState("/set_parameter")[2][2]
    return sorted(name[: -len(SERVICE)] for name, _ in services if name.endswith(SERVICE))


def _those_with_parameters() -> str:
    known = _with_parameters()
    return f"These have some: {', '.join(known)}." if known else "No node that runs has any."


def _are_alike(one: Any, other: Any) -> bool:
    """Whether a value went into a message and came back."""
    return one == other or (isinstance(one, float) and abs(one - other) <= 1e-9 * max(1.0, abs(one)))


class _Log:
    """Hears the warnings of a node."""

    def __init__(self, node: str) -> None:
        self._node = node
        self._words: list[str] = []
        self._subscriber = rospy.Subscriber("/rosout_agg", Log, self._on_log, queue_size=100)
        self._wait(lambda: self._subscriber.get_num_connections() > 0)

    def _on_log(self, message: Log) -> None:
        if message.name == self._node and message.level >= Log.WARN:
            self._words.append(message.msg)

    def words(self) -> list[str]:
        """Return its warnings since the connection, as soon as there is one; empty if none comes."""
        self._wait(lambda: bool(self._words))
        return list(self._words)

    @staticmethod
    def _wait(is_there: Callable[[], bool]) -> None:
        end_s = time.monotonic() + WORDS_S
        while not is_there() and time.monotonic() < end_s:
            time.sleep(0.01)
