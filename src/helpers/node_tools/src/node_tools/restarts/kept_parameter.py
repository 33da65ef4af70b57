"""What a node must still know when it dies and the same roslaunch starts it again.

It stands in a private parameter of the node. The ROS master may outlive the launch, and so does the
parameter. Therefore it also tells which launch it belongs to.
"""

from __future__ import annotations

from contextlib import suppress
from typing import Any, Mapping

import rospy

from node_tools.ending import Ending
from node_tools.restarts.launch import launch_of_this_process
from node_tools.restarts.newest_writer import NewestWriter

LAUNCH = "launch"
"""Key of the launch in the parameter."""


class KeptParameter:
    """A parameter that a node finds again if it died, and that no later launch finds.

    Args:
        name: of the parameter, such as ~begun.
        ending: of the node. A node that a signal ends was not lost, so it takes the parameter away. None: the
            parameter stays.

    Attributes:
        values: what is kept; empty: nothing, or it is another launch's.
    """

    def __init__(self, name: str, ending: Ending | None = None) -> None:
        self._name, self._ending, self._launch = name, ending, launch_of_this_process()
        self._writer = NewestWriter(self._write)
        told = rospy.get_param(name, None)
        is_ours = isinstance(told, dict) and told.get(LAUNCH) == self._launch
        self.values: dict[str, Any] = {k: v for k, v in told.items() if k != LAUNCH} if is_ours else {}
        if ending is not None:
            rospy.on_shutdown(self._take_away)

    def keep(self, values: Mapping[str, Any]) -> None:
        """Keep these in place of what was kept. They are numbers, words, lists of them, or mappings.

        Without a master nothing is kept, and the flight goes on. A master that hangs is not waited for.
        """
        self.values = dict(values)
        if self._ending is None or not self._ending.received:
            self._writer.write(self._content)

    def _write(self, told: dict[str, Any]) -> None:
        with suppress(OSError, rospy.ROSException):
            rospy.set_param(self._name, told)

    @property
    def _content(self) -> dict[str, Any]:
        return {**self.values, LAUNCH: self._launch}

    def _take_away(self) -> None:
        """Delete the parameter after a signal, unless another node of this name has written it meanwhile."""
        assert self._ending is not None
        if not self._ending.received or not self.values:
            return
        with suppress(OSError, KeyError, rospy.ROSException):  # the master may have ended before
            if rospy.get_param(self._name, None) == self._content:
                rospy.delete_param(self._name)
