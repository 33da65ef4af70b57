"""A dynamic_reconfigure server that refuses values beyond a limit, and has nested groups."""

from __future__ import annotations

from typing import Any, Mapping

import rospy
from dynamic_reconfigure.server import Server


class TuningServer(Server):
    """dynamic_reconfigure's server with four differences.

    It refuses a value beyond its limits with a sentence, and the old value stays. The original silently
    clips the value to the limit, where it may have another meaning. It also understands requests with the
    state of nested groups, as `dynparam load` sends them. The original fails on these.
    It asks the parameter server for all values at once, and sets them at once. The original takes two calls
    for each value at the start, and one for each at every change: in flight, 60 for CEPA. A request that
    comes while the node ends gets a sentence. The original fails then, with a traceback.
    """

    def update_configuration(self, changes: Mapping[str, Any]) -> Any:
        """Apply the changes that are within their limits.

        Raises:
            rospy.ServiceException: the node ends. A client of the service gets this as its answer.
        """
        allowed = {name: value for name, value in changes.items() if self._is_allowed(name, value)}
        try:
            return super().update_configuration(allowed)
        except rospy.ROSException as error:
            if not rospy.is_shutdown():
                raise
            raise rospy.ServiceException("The node ends. Ask again when it runs.") from error

    def _is_allowed(self, name: str, value: Any) -> bool:
        least, most = self.type.min.get(name), self.type.max.get(name)
        if not all(isinstance(number, (int, float)) for number in (least, most, value)):
            return True  # texts, and what else has no limits
        if least <= value <= most:
            return True
        rospy.logwarn(
            f"{name} must be from {least:g} to {most:g}: {value:g} is refused, the old value stays."
        )
        return False

    def _copy_from_parameter_server(self) -> None:
        given = rospy.get_param(self.ns, {})
        self.config.update({name: given[name] for name in self.type.defaults if name in given})

    def _copy_to_parameter_server(self) -> None:
        ours = {name: self.config[name] for name in self.type.defaults}
        rospy.set_param(self.ns, {**rospy.get_param(self.ns, {}), **ours})

    def _set_callback(self, request: Any) -> Any:
        request.config.groups = []
        return super()._set_callback(request)
