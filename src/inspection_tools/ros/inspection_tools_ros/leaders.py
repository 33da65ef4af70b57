"""Which node leads the UAV: it does so until it says that it has ended, or is gone. Silence is neither."""

from __future__ import annotations

import time
from functools import partial
from typing import Callable

import rospy
from actionlib_msgs.msg import GoalStatus, GoalStatusArray
from std_srvs.srv import Trigger

from node_tools.services import NoServiceError, ServiceCall

LEADERS = {"explore": "/explore/explore", "inspect": "/inspect/survey"}
"""Nodes that lead the UAV, with their action. While none leads, it flies by position setpoints."""
UNDER_WAY = (GoalStatus.PENDING, GoalStatus.ACTIVE, GoalStatus.PREEMPTING, GoalStatus.RECALLING)
RESTART_S = 30.0
"""Wall time in which a node that died has started again, and goes on with its goal."""


class Leaders:
    """Hears the status of their actions, and passes orders on.

    Args:
        leads: who led when this node died; empty: nobody. on_change: told who leads, to keep it.
    """

    def __init__(self, leads: str = "", on_change: Callable[[str], None] = lambda _: None) -> None:
        self._leads: dict[str, bool | None] = {name: True if name == leads else None for name in LEADERS}
        """Whether each is under way; None: not heard of yet."""
        self._tells_goals = dict.fromkeys(LEADERS, False)
        self._heard_s = dict.fromkeys(LEADERS, time.monotonic())
        self._on_change = on_change

    def listen(self) -> None:
        """Begin to hear them."""
        for name, action in LEADERS.items():
            rospy.Subscriber(f"{action}/status", GoalStatusArray, partial(self.note, name), queue_size=1)

    def note(self, name: str, goals: GoalStatusArray) -> None:
        """Take a status. A node that has just started again knows no goals yet: that is no end."""
        before, self._tells_goals[name] = self.leading, bool(goals.status_list)
        self._heard_s[name] = time.monotonic()
        if goals.status_list or not self._leads[name]:
            self._set(name, any(goal.status in UNDER_WAY for goal in goals.status_list), before)

    def begin(self, name: str) -> None:
        """A goal is sent to a node: it leads from now on."""
        before, self._tells_goals[name], self._heard_s[name] = self.leading, True, time.monotonic()
        self._set(name, True, before)

    def _set(self, name: str, leads: bool, before: str) -> None:
        self._leads[name] = leads
        if self.leading != before:
            self._on_change(self.leading)

    @property
    def leading(self) -> str:
        """Who is under way, or was so when it was heard last; empty: nobody."""
        return next((name for name, leads in self._leads.items() if leads), "")

    def may_lead(self, name: str, is_there: bool) -> bool:
        """Whether a node leads, or nobody knows. is_there: it hears this node."""
        if is_there:
            return self._leads[name] is not False
        return bool(self._leads[name]) and time.monotonic() - self._heard_s[name] < RESTART_S

    def order(self, service: str) -> tuple[bool, str] | None:
        """Pass an order on to who leads. Return whether it obeys, and its words; None: nobody leads."""
        refusals = []
        for name in sorted(LEADERS, key=lambda name: not self._leads[name]):
            try:
                answer = ServiceCall(f"/{name}/{service}", Trigger)()
            except rospy.ServiceException as error:
                if self.may_lead(name, is_there=not isinstance(error, NoServiceError)):
                    refusals.append(
                        f"The node {name} leads the UAV and does not answer ({error}). So no setpoint "
                        "is sent: give the order again, or land."
                    )
                continue
            if answer.success:
                return True, answer.message
            if self._leads[name] and self._tells_goals[name]:
                refusals.append(answer.message)
            else:
                self._set(name, False, self.leading)
        return (False, " ".join(refusals)) if refusals else None
