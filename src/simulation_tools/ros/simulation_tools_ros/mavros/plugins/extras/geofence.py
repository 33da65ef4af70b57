"""MAVROS's plugin `geofence`: the flight controller's fence."""

from __future__ import annotations

from typing import Callable, Sequence

import rospy
from mavros_msgs import srv
from mavros_msgs.msg import Waypoint, WaypointList
from pymavlink.dialects.v20 import common

from simulation_tools.mavros.mission import MissionClient, MissionError, MissionItem
from simulation_tools_ros.mavros.plugins.waypoint import item_of, message_of
from simulation_tools_ros.mavros.uas import Uas


class GeofencePlugin:
    """Publishes geofence/waypoints (latched); serves geofence/{pull,push,clear}.

    The node reads the fence when the flight controller connects. If the flight controller refuses a request,
    success is false and the log gives the reason.
    """

    def __init__(self, uas: Uas) -> None:
        self._fence = MissionClient(
            uas.client, mission_type=common.MAV_MISSION_TYPE_FENCE, lock=uas.plan_lock
        )
        self._items: list[MissionItem] = []
        self._waypoints = uas.advertise("geofence/waypoints", WaypointList, latch=True)
        uas.serve("geofence/pull", srv.WaypointPull, self._on_pull)
        uas.serve("geofence/push", srv.WaypointPush, self._on_push)
        uas.serve("geofence/clear", srv.WaypointClear, self._on_clear)
        uas.on_connection(lambda: self._try("pull", self._pull))

    def _on_pull(self, _request: srv.WaypointPullRequest) -> srv.WaypointPullResponse:
        return srv.WaypointPullResponse(self._try("pull", self._pull), len(self._items))

    def _on_push(self, request: srv.WaypointPushRequest) -> srv.WaypointPushResponse:
        success = self._try("push", lambda: self._push(request.waypoints))
        return srv.WaypointPushResponse(success, len(request.waypoints) if success else 0)

    def _on_clear(self, _request: srv.WaypointClearRequest) -> srv.WaypointClearResponse:
        return srv.WaypointClearResponse(self._try("clear", lambda: self._push(())))

    def _pull(self) -> None:
        self._take(self._fence.read())

    def _push(self, waypoints: Sequence[Waypoint]) -> None:
        """Replace the fence, or delete it."""
        items = [item_of(waypoint) for waypoint in waypoints]
        if items:
            self._fence.write(items)
        else:
            self._fence.clear()
        self._take(items)

    def _take(self, items: list[MissionItem]) -> None:
        self._items = items
        self._waypoints.publish(lambda: WaypointList(0, [message_of(item, False) for item in self._items]))

    @staticmethod
    def _try(service: str, do: Callable[[], None]) -> bool:
        """Return whether the request succeeded. If not, log the reason."""
        try:
            do()
        except MissionError as error:
            rospy.logwarn(f"geofence/{service}: {error}.")
            return False
        return True
