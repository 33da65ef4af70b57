"""The frame of a plugin's setpoints: MAVROS's parameters and services `mav_frame`."""

from __future__ import annotations

import rospy
from mavros_msgs.srv import SetMavFrame, SetMavFrameRequest, SetMavFrameResponse

from simulation_tools.errors import SimulationToolsError
from simulation_tools_ros.mavros.uas import Uas

MAV_FRAMES = {"LOCAL_NED": 1, "LOCAL_OFFSET_NED": 7, "BODY_NED": 8, "BODY_OFFSET_NED": 9}


class MavFrame:
    """Holds ~<plugin>/mav_frame, LOCAL_NED by default, and serves <plugin>/mav_frame."""

    def __init__(self, uas: Uas, plugin: str) -> None:
        self._parameter = f"~{plugin}/mav_frame"
        name = rospy.get_param(self._parameter, "LOCAL_NED")
        if name not in MAV_FRAMES:
            raise SimulationToolsError(
                f"{self._parameter} must be one of {', '.join(MAV_FRAMES)}, not {name!r}."
            )
        self.number = MAV_FRAMES[name]
        uas.serve(f"{plugin}/mav_frame", SetMavFrame, self._on_request)

    def _on_request(self, request: SetMavFrameRequest) -> SetMavFrameResponse:
        names = {number: name for name, number in MAV_FRAMES.items()}
        if request.mav_frame not in names:
            rospy.logwarn(f"{self._parameter} stays as it is: {request.mav_frame} is none of 1, 7, 8 and 9.")
            return SetMavFrameResponse(success=False)
        self.number = request.mav_frame
        rospy.set_param(self._parameter, names[request.mav_frame])
        return SetMavFrameResponse(success=True)
