"""Serves the map: octomap_server's services, and those for planners."""

from __future__ import annotations

import contextlib
from typing import Any, Callable, Iterator

import numpy as np
import rospy
from octomap_msgs.srv import BoundingBoxQuery, BoundingBoxQueryResponse, GetOctomap, GetOctomapResponse
from std_msgs.msg import Header
from std_srvs.srv import Empty, EmptyResponse, Trigger, TriggerResponse

from gridslam import SlamError
from gridslam.srv import GetDistances, GetDistancesResponse, GetFrontiers, GetFrontiersResponse
from gridslam.volume import stream_of
from gridslam_ros.volume import messages
from gridslam_ros.volume.map_in_service import MapInService
from gridslam_ros.volume.parameters import OctomapParameters
from gridslam_ros.volume.publisher import Layers, inside


class OctomapServices:
    """octomap_binary, octomap_full, ~clear_bbx, ~reset, ~save_state, ~load_state, ~distances, ~frontiers.

    Args:
        parameters: of the node.
        served: the map.
        layers: of the map.
        lock: held while one of these is read or changed.
        changed: is called after a change.
        stamp: returns the map's time.
    """

    def __init__(
        self,
        parameters: OctomapParameters,
        served: MapInService,
        layers: Layers,
        lock: Any,
        changed: Callable[[], None],
        stamp: Callable[[], rospy.Time],
    ):
        self._parameters, self._resolution_m = parameters, parameters.volume.resolution_m
        self._served, self._layers, self._lock = served, layers, lock
        self._changed, self._stamp = changed, stamp
        self._services = [
            rospy.Service("octomap_binary", GetOctomap, self._binary),
            rospy.Service("octomap_full", GetOctomap, self._full),
            rospy.Service("~clear_bbx", BoundingBoxQuery, self._clear),
            rospy.Service("~reset", Empty, self._reset),
            rospy.Service("~save_state", Trigger, self._save),
            rospy.Service("~load_state", Trigger, self._load),
            rospy.Service("~distances", GetDistances, self._distances),
            rospy.Service("~frontiers", GetFrontiers, self._frontiers),
        ]

    @contextlib.contextmanager
    def _answering(self) -> Iterator[Header]:
        """Hold the lock, and let errors reach the caller as sentences."""
        try:
            with self._lock:
                yield Header(stamp=self._stamp(), frame_id=self._parameters.frame("frame_id"))
        except SlamError as error:
            rospy.logwarn("%s", error)
            raise rospy.ServiceException(str(error)) from None

    def _binary(self, _: Any) -> GetOctomapResponse:
        with self._answering() as header:
            self._layers.refresh(self._served.corrected)
            octree = self._layers.shown.octree()
            return GetOctomapResponse(messages.octomap_answer(octree, self._resolution_m, header))

    def _full(self, _: Any) -> GetOctomapResponse:
        with self._answering() as header:
            octree = stream_of(self._served.corrected.voxels, is_binary=False)
            return GetOctomapResponse(messages.octomap_answer(octree, self._resolution_m, header))

    def _clear(self, request: Any) -> BoundingBoxQueryResponse:
        with self._answering():
            self._served.corrected.clear(messages.box_of(request.min, request.max, self._resolution_m))
        self._changed()
        return BoundingBoxQueryResponse()

    def _reset(self, _: Any) -> EmptyResponse:
        with self._answering():
            self._served.corrected.reset()
        self._changed()
        return EmptyResponse()

    def _save(self, _: Any) -> TriggerResponse:
        return self._with_file(self._served.save, "The state is saved in")

    def _load(self, _: Any) -> TriggerResponse:
        answer = self._with_file(self._served.load, "Going on from the state in")
        self._changed()
        return answer

    def _with_file(self, act: Callable[[str], None], words: str) -> TriggerResponse:
        path = str(rospy.get_param("~state_file", "")).strip()
        if not path:
            return TriggerResponse(False, f"Set the parameter {rospy.get_name()}/state_file to a path first.")
        try:
            act(path)
        except SlamError as error:
            return TriggerResponse(False, str(error))
        return TriggerResponse(True, f"{words} {path}.")

    def _distances(self, request: Any) -> GetDistancesResponse:
        with self._answering() as header:
            box = messages.box_of(request.min, request.max, self._resolution_m)
            messages.require_moderate(box)
            field = self._layers.distances
            self._layers.refresh(self._served.corrected)
            distances_m = field.distances_m(box)
            size = (np.asarray(box.high) - np.asarray(box.low)).tolist()
            greatest_m = field.reach * self._resolution_m
            low = np.asarray(box.low).tolist()
            return GetDistancesResponse(
                header, self._resolution_m, low, size, greatest_m, distances_m.ravel()
            )

    def _frontiers(self, request: Any) -> GetFrontiersResponse:
        with self._answering() as header:
            box = messages.box_of(request.min, request.max, self._resolution_m)
            frontiers = self._layers.frontiers
            self._layers.refresh(self._served.corrected)
            points = inside(frontiers.centres(), box, self._resolution_m)
            return GetFrontiersResponse(messages.cloud_of(points, header))
