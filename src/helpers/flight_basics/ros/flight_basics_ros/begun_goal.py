"""The goal of an action that a node flies: what it must know to go on if it dies in flight."""

from __future__ import annotations

import hashlib
from io import BytesIO
from typing import Any

import rosgraph
import rospy
from actionlib import ServerGoalHandle

from node_tools.ending import Ending
from node_tools.restarts.kept_parameter import KeptParameter


class BegunGoal:
    """Keeps one goal in the node's parameter ~begun, which outlives the node.

    The goal is latched, so a node that starts again gets it again. A goal of another launch, or of a node
    that was told to end by a signal, belongs to nobody any more, and is not found.

    Args:
        ending: of the node.
    """

    def __init__(self, ending: Ending) -> None:
        self._kept = KeptParameter("~begun", ending)
        self._ended_before = self._kept.values["goal"] if self._kept.values.get("has_ended") else ""

    def begin(self, identity: str, **known: Any) -> None:
        """Keep what is flown. identity: of the goal. known: what to find again, as `home` and `began`."""
        self._kept.keep({"goal": identity, "has_ended": False, **known})

    def note(self, **known: Any) -> None:
        """Keep something new of the goal that is flown."""
        self._kept.keep({**self._kept.values, **known})

    def end(self) -> None:
        """Keep that the goal has ended."""
        if self._kept.values:
            self._kept.keep({**self._kept.values, "has_ended": True})

    def is_flown(self, identity: str) -> bool:
        """Whether a goal was begun and has not ended."""
        return self._kept.values.get("goal") == identity and not self._kept.values["has_ended"]

    def had_ended(self, identity: str) -> bool:
        """Whether a goal had ended before the node started again. It comes again, because it is latched."""
        return identity == self._ended_before

    def __getitem__(self, name: str) -> Any:
        """Return what is known of the goal that was begun last."""
        return self._kept.values[name]


def identity_of(goal: ServerGoalHandle, *content: str) -> str:
    """Return what tells a goal of an action from all others: its id, stamp, content, and who sent it.

    A sender that counts its goals begins anew with each start, so an id may come again. A latched goal that
    comes again to a node that has started again is the same.

    Args:
        goal: as the action server got it.
        content: what the goal's files hold.
    """
    message, flown = goal.goal, BytesIO()
    message.goal.serialize(flown)
    sender = message._connection_header.get("callerid", "")
    stamp = message.header.stamp  # actionlib sets that of goal_id, if it is 0
    words = (message.goal_id.id, sender, _address_of(sender), str(stamp), *content)
    digest = hashlib.sha256("\n".join(words).encode() + flown.getvalue()).hexdigest()
    return f"{message.goal_id.id} {digest[:16]}"


def _address_of(node: str) -> str:
    """Return the address of a node, which is another one after each start; empty: it has ended."""
    try:
        return str(rosgraph.Master(rospy.get_name()).lookupNode(node))
    except (rosgraph.MasterException, OSError):
        return ""
