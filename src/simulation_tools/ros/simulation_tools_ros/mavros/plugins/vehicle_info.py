"""MAVROS's information on vehicles; part of its plugin `sys_status`."""

from __future__ import annotations

import rospy
from mavros_msgs.msg import VehicleInfo
from mavros_msgs.srv import VehicleInfoGet, VehicleInfoGetRequest, VehicleInfoGetResponse
from pymavlink.dialects.v20 import common

from simulation_tools.mavros.stacks import stack_of
from simulation_tools_ros.mavros.uas import Uas

_REQUEST_AUTOPILOT_CAPABILITIES = 520
_CUSTOM_MODE_ENABLED = 1
_TRIES = 3


class VehicleInfoPlugin:
    """Serves vehicle_info_get. The flight controller is the only vehicle that the node listens to."""

    def __init__(self, uas: Uas) -> None:
        self._uas = uas
        self._info: VehicleInfo | None = None
        uas.client.on("HEARTBEAT", self._on_heartbeat)
        uas.client.on("AUTOPILOT_VERSION", self._on_version)
        uas.serve("vehicle_info_get", VehicleInfoGet, self._on_request)
        uas.on_connection(self._ask_for_version)

    def _ask_for_version(self) -> None:
        for _ in range(_TRIES):
            if self._uas.client.command(_REQUEST_AUTOPILOT_CAPABILITIES, 1.0) is not None:
                return
        rospy.logwarn("The flight controller does not tell its version (MAV_CMD 520).")

    def _on_heartbeat(self, heartbeat: common.MAVLink_message) -> None:
        info = self._the_info(VehicleInfo.HAVE_INFO_HEARTBEAT)
        info.autopilot, info.type = heartbeat.autopilot, heartbeat.type
        info.system_status, info.base_mode = heartbeat.system_status, heartbeat.base_mode
        info.custom_mode = heartbeat.custom_mode
        info.mode = stack_of(heartbeat.autopilot).mode_name(heartbeat.custom_mode)
        is_custom = heartbeat.base_mode & _CUSTOM_MODE_ENABLED
        info.mode_id = heartbeat.custom_mode if is_custom else heartbeat.base_mode

    def _on_version(self, version: common.MAVLink_message) -> None:
        info = self._the_info(VehicleInfo.HAVE_INFO_AUTOPILOT_VERSION)
        info.capabilities, info.flight_sw_version = version.capabilities, version.flight_sw_version
        info.middleware_sw_version, info.os_sw_version = version.middleware_sw_version, version.os_sw_version
        info.board_version, info.uid = version.board_version, version.uid
        info.flight_custom_version = bytes(reversed(version.flight_custom_version)).hex()
        info.vendor_id, info.product_id = version.vendor_id, version.product_id

    def _the_info(self, what: int) -> VehicleInfo:
        target = self._uas.client.target
        if self._info is None:
            self._info = VehicleInfo(sysid=target.system_id, compid=target.component_id)
        self._info.header.stamp = self._uas.now
        self._info.available_info |= what
        return self._info

    def _on_request(self, request: VehicleInfoGetRequest) -> VehicleInfoGetResponse:
        info = self._info
        if request.get_all:
            return VehicleInfoGetResponse(True, [] if info is None else [info])
        is_meant = info is not None and (request.sysid, request.compid) in (
            (VehicleInfoGet._request_class.GET_MY_SYSID, VehicleInfoGet._request_class.GET_MY_COMPID),
            (info.sysid, info.compid),
        )
        return VehicleInfoGetResponse(is_meant, [info] if is_meant else [])
