"""MAVLink's mission protocol: a client uploads or downloads the mission or the fence.

https://mavlink.io/en/services/mission.html. Each port has its own transfer, but only one client uploads at a
time. All times are simulation time. Rally points are refused: the return goes home.
"""

from __future__ import annotations

import enum
from typing import Callable

from pymavlink.dialects.v20 import common

from simulation_tools.mavlink import Address
from simulation_tools.px4.failsafe import Say
from simulation_tools.px4.mavlink.missions.items import from_message, to_message
from simulation_tools.px4.modes import Severity
from simulation_tools.px4.plan.items import FENCE_COMMANDS, Command, PlanError, PlanItem
from simulation_tools.px4.plan.plan import CAPACITY, Plan, PlanKind

_RETRY_US, _TIMEOUT_US = 250_000, 5_000_000
_LEAST_VERTICES = 3
_POLYGONS = (Command.FENCE_POLYGON_INCLUSION, Command.FENCE_POLYGON_EXCLUSION)
_KINDS = frozenset(PlanKind)


class _State(enum.Enum):
    IDLE = 0
    SENDING = 1
    RECEIVING = 2


class UploadLock:
    """Whether a client uploads, on any port."""

    def __init__(self) -> None:
        self.held = False


class MissionProtocol:
    """One port's transfer. Call `handle` for each of `messages`, and `due` often."""

    def __init__(self, plan: Plan, lock: UploadLock, identity: tuple[int, int], say: Say) -> None:
        """identity: the flight controller's system and component id."""
        self._plan = plan
        self._lock = lock
        self._identity = identity
        self._say = say
        self._is_int = False
        self._kind: int = PlanKind.MISSION
        self._items: list[PlanItem] = []
        self._chosen: int | None = None
        self._count = self._seq = 0
        self._client = (0, 0)
        self._address: Address | None = None
        self._state = _State.IDLE
        self._sent_us = self._heard_us = 0
        self._handlers: dict[str, Callable[[common.MAVLink_message], common.MAVLink_message | None]] = {
            "MISSION_REQUEST_LIST": self._list,
            "MISSION_REQUEST": self._send,
            "MISSION_REQUEST_INT": self._send,
            "MISSION_ACK": self._acknowledged,
            "MISSION_COUNT": self._begin_upload,
            "MISSION_ITEM": self._receive,
            "MISSION_ITEM_INT": self._receive,
            "MISSION_CLEAR_ALL": self._clear,
            "MISSION_SET_CURRENT": self._choose,
        }
        self.messages = tuple(self._handlers)

    def handle(
        self, m: common.MAVLink_message, sender: Address, time_us: int
    ) -> common.MAVLink_message | None:
        """Return the answer to a message; None: there is none, or it is for another flight controller."""
        system, component = self._identity
        components = (component, common.MAV_COMP_ID_MISSIONPLANNER, common.MAV_COMP_ID_ALL)
        if m.target_system != system or m.target_component not in components:
            return None
        if self._state is _State.IDLE:
            self._address = sender
        answer = self._handlers[m.get_type()](m)
        self._heard_us = time_us
        if answer is not None:
            self._sent_us = time_us
        return answer

    def due(self, time_us: int) -> tuple[common.MAVLink_message, Address] | None:
        """Return a repeated request and its receiver; gives up after 5 s without a message."""
        if self._state is _State.IDLE or self._address is None:
            return None
        if time_us - self._heard_us > _TIMEOUT_US:
            self._complain("Operation timeout")
            self._end()
        elif self._state is _State.RECEIVING and time_us - self._sent_us > _RETRY_US:
            self._sent_us = time_us
            return self._request(), self._address
        return None

    # Download

    def _list(self, m: common.MAVLink_message) -> common.MAVLink_message | None:
        completed = self._state is _State.SENDING and self._seq == self._count
        if self._state is not _State.IDLE and not completed and m.mission_type != self._kind:
            self._inform("Mission download request ignored, already active")
            return None
        if self._state is _State.RECEIVING:
            return None
        self._state, self._kind, self._seq = _State.SENDING, m.mission_type, 0
        self._client = _sender(m)
        self._count = len(self._list_of(m.mission_type))
        return common.MAVLink_mission_count_message(*self._client, self._count, m.mission_type)

    def _send(self, m: common.MAVLink_message) -> common.MAVLink_message | None:
        self._is_int = m.get_type() == "MISSION_REQUEST_INT"
        if self._state is _State.IDLE:
            return None  # PX4 is silent here, too
        if _sender(m) != self._client:
            self._complain("WPM: REJ. CMD: partner id mismatch")
            return None
        if self._state is _State.RECEIVING:
            self._complain("WPM: REJ. CMD: Busy")
            return None
        if self._kind != m.mission_type:
            return None
        items = self._list_of(self._kind)
        is_next = m.seq == self._seq and self._seq < self._count
        if not (is_next or m.seq == self._seq - 1) or m.seq >= len(items):
            self._end()
            self._complain("WPM: REJ. CMD: Req. WP was unexpected")
            return self._ack(common.MAV_MISSION_ERROR)
        self._seq = m.seq + 1
        is_current = self._kind == PlanKind.MISSION and m.seq == self._plan.current
        return to_message(items[m.seq], self._client, m.seq, is_current, self._kind, self._is_int)

    def _acknowledged(self, m: common.MAVLink_message) -> common.MAVLink_message | None:
        if self._state is _State.IDLE:
            return None
        if _sender(m) != self._client:
            self._complain("REJ. WP CMD: partner id mismatch")
            return None
        if self._state is _State.SENDING:
            self._end()
        elif m.type == common.MAV_MISSION_UNSUPPORTED:
            self._is_int = not self._is_int
            return self._request()
        elif m.type == common.MAV_MISSION_OPERATION_CANCELLED:
            self._end()
        return None

    # Upload

    def _begin_upload(self, m: common.MAVLink_message) -> common.MAVLink_message | None:
        if self._state is _State.SENDING:
            self._complain("WPM: IGN MISSION_COUNT: Busy")
            return self._ack(common.MAV_MISSION_ERROR)
        if self._state is _State.RECEIVING:
            if self._seq == 0:
                return self._request()  # it was lost
            self._complain("WPM: REJ. CMD: Busy")
            return self._ack(common.MAV_MISSION_ERROR)
        self._client, self._kind = _sender(m), m.mission_type
        if self._lock.held:
            return self._ack(common.MAV_MISSION_ERROR)
        if m.count == 0:
            self._empty(m.mission_type)
            return self._ack(common.MAV_MISSION_ACCEPTED)
        if m.mission_type not in _KINDS:
            return self._ack(common.MAV_MISSION_UNSUPPORTED)
        if m.count > CAPACITY[PlanKind(m.mission_type)]:
            return self._ack(common.MAV_MISSION_NO_SPACE)
        self._lock.held = True
        self._state, self._count, self._seq = _State.RECEIVING, m.count, 0
        self._items, self._chosen = [], None
        return self._request()

    def _receive(self, m: common.MAVLink_message) -> common.MAVLink_message | None:
        self._is_int = m.get_type() == "MISSION_ITEM_INT"
        if m.mission_type != self._kind:
            return self._ack(common.MAV_MISSION_ERROR)
        if self._state is not _State.RECEIVING:
            if self._state is _State.IDLE and self._seq == m.seq + 1:
                return self._ack(common.MAV_MISSION_ACCEPTED)  # the last acknowledgement was lost
            trouble = "No transfer" if self._state is _State.IDLE else "Busy"
            self._complain(f"IGN MISSION_ITEM: {trouble}")
            return self._ack(common.MAV_MISSION_ERROR)
        if m.seq != self._seq:
            return self._request()
        try:
            item = self._checked(from_message(m))
        except PlanError as error:
            self._complain("IGN MISSION_ITEM: Invalid item")
            self._end()
            return self._ack(error.result)
        self._items.append(item)
        if m.current:
            self._chosen = m.seq
        self._seq += 1
        if self._seq < self._count:
            return self._request()
        self._plan.replace(PlanKind(self._kind), self._items, self._chosen)
        self._end()
        return self._ack(common.MAV_MISSION_ACCEPTED)

    def _checked(self, item: PlanItem) -> PlanItem:
        """Return an item that may be in this list; raises PlanError."""
        is_fence = item.command in FENCE_COMMANDS
        if is_fence is not (self._kind == PlanKind.FENCE):
            raise PlanError(common.MAV_MISSION_ERROR)
        if item.command in _POLYGONS and not item.params[0] + 0.5 >= _LEAST_VERTICES:
            self._empty(PlanKind.FENCE)  # as PX4 does
            raise PlanError(common.MAV_MISSION_ERROR)
        return item

    # Changes

    def _clear(self, m: common.MAVLink_message) -> common.MAVLink_message | None:
        if self._state is not _State.IDLE:
            self._complain("WPM: IGN CLEAR CMD: Busy")
            return None
        self._client, self._kind = _sender(m), m.mission_type
        self._empty(m.mission_type)
        return self._ack(common.MAV_MISSION_ACCEPTED)

    def _choose(self, m: common.MAVLink_message) -> common.MAVLink_message | None:
        if self._state is not _State.IDLE:
            self._complain("WPM: IGN WP CURR CMD: Busy")
            return None
        if not self._plan.choose(m.seq):
            self._complain("WPM: WP CURR CMD: Not in list")
            return None
        return None

    def _empty(self, mission_type: int) -> None:
        for kind in PlanKind:
            if mission_type in (kind, common.MAV_MISSION_TYPE_ALL):
                self._plan.replace(kind, ())

    # Parts

    def _list_of(self, mission_type: int) -> tuple[PlanItem, ...]:
        return self._plan.items(PlanKind(mission_type)) if mission_type in _KINDS else ()

    def _request(self) -> common.MAVLink_message:
        kinds = common.MAVLink_mission_request_message, common.MAVLink_mission_request_int_message
        return kinds[int(self._is_int)](*self._client, self._seq, self._kind)

    def _ack(self, result: int) -> common.MAVLink_message:
        return common.MAVLink_mission_ack_message(*self._client, result, self._kind)

    def _end(self) -> None:
        if self._state is _State.RECEIVING:
            self._lock.held = False
        self._state = _State.IDLE

    def _complain(self, text: str) -> None:
        self._say(Severity.CRITICAL, text)

    def _inform(self, text: str) -> None:
        self._say(Severity.INFO, text)


def _sender(m: common.MAVLink_message) -> tuple[int, int]:
    return m.get_srcSystem(), m.get_srcComponent()
