"""The goal of an action that a node flies: where it is kept, and what tells it from all others."""

from __future__ import annotations

import hashlib
from io import BytesIO

import rosgraph
import rospy
from actionlib import ServerGoalHandle

from flight_basics.errand.begun import BegunGoal
from node_tools.ending import Ending
from node_tools.restarts.kept_parameter import KeptParameter


def begun_goal(ending: Ending) -> BegunGoal:
    """Return the goal that is kept in the node's parameter ~begun. ending: of the node."""
    return BegunGoal(KeptParameter("~begun", ending))


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
