"""MAVLink's mission items to and from the items of a plan."""

from __future__ import annotations

from pymavlink.dialects.v20 import common

from simulation_tools.px4.plan.items import MISSION_FRAME, PlanItem

_DEGREES = 1e7  # MISSION_ITEM_INT's unit of latitude and longitude
_INT_FRAME = {0: 5, 3: 6, 5: 5, 6: 6}
_FLOAT_FRAME = {0: 0, 3: 3, 5: 0, 6: 3}


def from_message(m: common.MAVLink_message) -> PlanItem:
    """Read MISSION_ITEM or MISSION_ITEM_INT; raises PlanError."""
    is_int = m.get_type() == "MISSION_ITEM_INT"
    scale = _DEGREES if is_int and m.frame != MISSION_FRAME else 1.0
    return PlanItem.accepted(
        m.command,
        m.frame,
        (m.param1, m.param2, m.param3, m.param4),
        (m.x / scale, m.y / scale, m.z),
        bool(m.autocontinue),
        is_int,
    )


def to_message(
    item: PlanItem, client: tuple[int, int], seq: int, is_current: bool, kind: int, is_int: bool
) -> common.MAVLink_message:
    """Return MISSION_ITEM_INT, or MISSION_ITEM, for a client (system, component)."""
    frames = _INT_FRAME if is_int else _FLOAT_FRAME
    scale = _DEGREES if item.has_place else 1.0
    x, y = (round(scale * item.x), round(scale * item.y)) if is_int else (item.x, item.y)
    make = common.MAVLink_mission_item_int_message if is_int else common.MAVLink_mission_item_message
    return make(
        *client,
        seq,
        frames.get(item.frame, item.frame),
        item.command,
        int(is_current),
        int(item.autocontinue),
        *item.params,
        x,
        y,
        item.z,
        kind,
    )
