"""MAVROS's plugin `waypoint`: the flight controller's mission."""

from __future__ import annotations

from typing import Callable, Sequence

import rospy
from mavros_msgs import srv
from mavros_msgs.msg import Waypoint, WaypointList, WaypointReached
from pymavlink.dialects.v20 import common
from std_msgs.msg import Header

from simulation_tools.mavros.mission import MissionClient, MissionError, MissionItem
from simulation_tools_ros.mavros.uas import Uas


class WaypointPlugin:
    """Publishes mission/{waypoints,reached} (latched); serves mission/{pull,push,clear,set_current}.

    The node reads the list when the flight controller connects. Without a mission the list is empty. If the
    flight controller refuses a request, success is false and the log gives the reason.
    """

    def __init__(self, uas: Uas) -> None:
        self._uas = uas
        self._mission = MissionClient(uas.client, lock=uas.plan_lock)
        self._items: list[MissionItem] = []
        self._current = 0
        self._waypoints = uas.advertise("mission/waypoints", WaypointList, latch=True)
        self._reached = uas.advertise("mission/reached", WaypointReached, latch=True)
        for name, service_class, handler in (
            ("mission/pull", srv.WaypointPull, self._on_pull),
            ("mission/push", srv.WaypointPush, self._on_push),
            ("mission/clear", srv.WaypointClear, self._on_clear),
            ("mission/set_current", srv.WaypointSetCurrent, self._on_set_current),
        ):
            uas.serve(name, service_class, handler)
        uas.client.on("MISSION_CURRENT", self._on_current)
        uas.client.on("MISSION_ITEM_REACHED", self._on_reached)
        uas.on_connection(lambda: self._try("pull", self._pull))

    def _on_current(self, message: common.MAVLink_message) -> None:
        if message.seq != self._current and message.seq < len(self._items):
            self._current = message.seq
            self._publish()

    def _on_reached(self, message: common.MAVLink_message) -> None:
        self._reached.publish(lambda: WaypointReached(Header(stamp=self._uas.now), message.seq))

    def _on_pull(self, _request: srv.WaypointPullRequest) -> srv.WaypointPullResponse:
        return srv.WaypointPullResponse(self._try("pull", self._pull), len(self._items))

    def _on_push(self, request: srv.WaypointPushRequest) -> srv.WaypointPushResponse:
        if request.start_index:
            rospy.logwarn("mission/push: PX4 takes whole missions only; start_index must be 0.")
            return srv.WaypointPushResponse(success=False, wp_transfered=0)
        success = self._try("push", lambda: self._push(request.waypoints))
        return srv.WaypointPushResponse(success, len(request.waypoints) if success else 0)

    def _on_clear(self, _request: srv.WaypointClearRequest) -> srv.WaypointClearResponse:
        return srv.WaypointClearResponse(self._try("clear", lambda: self._push(())))

    def _on_set_current(self, request: srv.WaypointSetCurrentRequest) -> srv.WaypointSetCurrentResponse:
        success = self._try("set_current", lambda: self._mission.set_current(request.wp_seq))
        return srv.WaypointSetCurrentResponse(success)

    def _pull(self) -> None:
        self._take(self._mission.read())

    def _push(self, waypoints: Sequence[Waypoint]) -> None:
        """Replace the mission, or delete it."""
        items = [item_of(waypoint) for waypoint in waypoints]
        if items:
            self._mission.write(items)
        else:
            self._mission.clear()
        self._take(items)

    def _take(self, items: list[MissionItem]) -> None:
        self._items = items
        self._current = next((i for i, item in enumerate(items) if item.is_current), 0)
        self._publish()

    def _publish(self) -> None:
        waypoints = [message_of(item, i == self._current) for i, item in enumerate(self._items)]
        self._waypoints.publish(lambda: WaypointList(self._current, waypoints))

    @staticmethod
    def _try(service: str, do: Callable[[], None]) -> bool:
        """Return whether the request succeeded. If not, log the reason."""
        try:
            do()
        except MissionError as error:
            rospy.logwarn(f"mission/{service}: {error}.")
            return False
        return True


def item_of(waypoint: Waypoint) -> MissionItem:
    """Waypoint to MissionItem."""
    return MissionItem(
        frame=waypoint.frame,
        command=waypoint.command,
        is_current=waypoint.is_current,
        autocontinue=waypoint.autocontinue,
        params=(waypoint.param1, waypoint.param2, waypoint.param3, waypoint.param4),
        x=waypoint.x_lat,
        y=waypoint.y_long,
        z=waypoint.z_alt,
    )


def message_of(item: MissionItem, is_current: bool) -> Waypoint:
    """MissionItem to Waypoint."""
    return Waypoint(
        item.frame, item.command, is_current, item.autocontinue, *item.params, item.x, item.y, item.z
    )
