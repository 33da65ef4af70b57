"""MAVLink's mission protocol for a flight controller that flies no missions.

Its lists of mission items, fence points and rally points are empty, like PX4's before an upload. It refuses
every upload.
"""

from __future__ import annotations

from pymavlink.dialects.v20 import common

MISSION_MESSAGES = (
    "MISSION_REQUEST_LIST",
    "MISSION_REQUEST_INT",
    "MISSION_REQUEST",
    "MISSION_COUNT",
    "MISSION_CLEAR_ALL",
)
"""The messages that `answer_mission` answers."""


def answer_mission(
    m: common.MAVLink_message, system_id: int, component_id: int
) -> common.MAVLink_message | None:
    """Return the answer to one of MISSION_MESSAGES; None when it is for another system or component."""
    addressees = (component_id, common.MAV_COMP_ID_MISSIONPLANNER, common.MAV_COMP_ID_ALL)
    if m.target_system not in (0, system_id) or m.target_component not in addressees:
        return None
    client = (m.get_srcSystem(), m.get_srcComponent())
    if m.get_type() == "MISSION_REQUEST_LIST":
        return common.MAVLink_mission_count_message(*client, 0, m.mission_type)
    return common.MAVLink_mission_ack_message(*client, _result(m), m.mission_type)


def _result(m: common.MAVLink_message) -> int:
    """Return MAV_MISSION_RESULT. An upload of no items empties a list, which is empty already."""
    kind = m.get_type()
    if kind == "MISSION_COUNT" and m.count:
        return common.MAV_MISSION_UNSUPPORTED
    if kind in ("MISSION_COUNT", "MISSION_CLEAR_ALL"):
        return common.MAV_MISSION_ACCEPTED
    return common.MAV_MISSION_ERROR  # there is no such item
