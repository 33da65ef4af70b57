"""Serves the map and the complete state. SLAM's thread gives the answers."""

from __future__ import annotations

from concurrent import futures
from concurrent.futures import Future
from typing import Any, Callable

import rospy
from nav_msgs.msg import OccupancyGrid
from nav_msgs.srv import GetMap, GetMapRequest, GetMapResponse
from std_srvs.srv import Trigger, TriggerRequest, TriggerResponse

from gridslam import SlamError, StateError

PATIENCE_S = 60.0
"""Wall time for which a service waits for SLAM's thread."""


class Services:
    """Serves dynamic_map, ~save_state and ~load_state.

    Args:
        ask: has SLAM's thread call a function, and returns its future answer.
        map_now: publishes and returns the map as it is now.
        save: writes the state to a file. It returns what is to be known of the map; empty: nothing.
        load: goes on from the state in a file, and returns the same.

    The last three run in SLAM's thread. They raise SlamError with one sentence, which the caller gets.
    """

    def __init__(
        self,
        ask: Callable[[Callable[[], Any]], Future],
        map_now: Callable[[], OccupancyGrid],
        save: Callable[[str], str],
        load: Callable[[str], str],
    ) -> None:
        self._ask, self._map_now, self._save, self._load = ask, map_now, save, load
        self._services = [
            rospy.Service("dynamic_map", GetMap, self._serve_map),
            rospy.Service("~save_state", Trigger, self._serve_save),
            rospy.Service("~load_state", Trigger, self._serve_load),
        ]

    def _serve_map(self, _request: GetMapRequest) -> GetMapResponse:
        try:
            return GetMapResponse(map=self._answer(self._map_now))
        except SlamError as error:
            raise rospy.ServiceException(str(error)) from None

    def _serve_save(self, _request: TriggerRequest) -> TriggerResponse:
        return self._with_state_file(self._save, "The state is saved in")

    def _serve_load(self, _request: TriggerRequest) -> TriggerResponse:
        return self._with_state_file(self._load, "Going on from the state in")

    def _with_state_file(self, act: Callable[[str], str], words: str) -> TriggerResponse:
        path = str(rospy.get_param("~state_file", "")).strip()
        if not path:
            return TriggerResponse(False, f"Set the parameter {rospy.get_name()}/state_file to a path first.")
        try:
            remark = self._answer(lambda: act(path))
        except SlamError as error:
            return TriggerResponse(False, str(error))
        return TriggerResponse(True, f"{words} {path}. {remark}".rstrip())

    def _answer(self, question: Callable[[], Any]) -> Any:
        try:
            return self._ask(question).result(PATIENCE_S)
        except futures.TimeoutError:
            raise StateError(f"SLAM is busy and did not answer within {PATIENCE_S:.0f} s.") from None
