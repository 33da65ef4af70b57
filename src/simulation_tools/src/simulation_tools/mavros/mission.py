"""The mission protocol's client: reads, writes and clears the flight controller's list of waypoints.

https://mavlink.io/en/services/mission.html. Times are wall times. If the flight controller refuses an
upload, the error gives its reason.
"""

from __future__ import annotations

import queue
import threading
import time
from dataclasses import dataclass
from typing import Callable, Sequence

from pymavlink.dialects.v20 import common

from simulation_tools.bounds import fit_float32
from simulation_tools.errors import SimulationToolsError
from simulation_tools.mavros.client import FcuClient

_TRIES = 3
_KINDS = (
    "MISSION_COUNT",
    "MISSION_ITEM_INT",
    "MISSION_REQUEST",
    "MISSION_REQUEST_INT",
    "MISSION_ACK",
    "MISSION_CURRENT",
)
_REQUESTS = ("MISSION_REQUEST", "MISSION_REQUEST_INT")
_MISSION = common.MAV_MISSION_TYPE_MISSION
_LOCAL_FRAMES = (
    common.MAV_FRAME_LOCAL_NED,
    common.MAV_FRAME_LOCAL_ENU,
    common.MAV_FRAME_LOCAL_OFFSET_NED,
    common.MAV_FRAME_LOCAL_FRD,
    common.MAV_FRAME_LOCAL_FLU,
)
_INT32_MAX = 2**31 - 1


class MissionError(SimulationToolsError):
    """The flight controller refused a request. The text says why."""


@dataclass(frozen=True)
class MissionItem:
    """One waypoint. x, y: degrees, or m in a local frame; z: m."""

    frame: int
    command: int
    is_current: bool
    autocontinue: bool
    params: Sequence[float]  # 4
    x: float
    y: float
    z: float


class MissionClient:
    """Makes one transfer at a time. Its methods block. Any thread but the client's own may call them."""

    def __init__(
        self,
        client: FcuClient,
        timeout_s: float = 1.0,
        mission_type: int = _MISSION,
        lock: threading.Lock | None = None,
    ) -> None:
        """Make a client for one list.

        Args:
            client: the link.
            timeout_s: of each try to get an answer.
            mission_type: MAV_MISSION_TYPE: the mission, or the fence.
            lock: of all lists of one flight controller, which makes one transfer at a time.
        """
        self._client = client
        self._timeout_s = timeout_s
        self._type = mission_type
        self._lock = lock or threading.Lock()
        self._answers: queue.Queue = queue.Queue()
        self._listening = False
        for kind in _KINDS:
            client.on(kind, self._on_message)

    def read(self) -> list[MissionItem]:
        """Return the flight controller's mission; raises MissionError."""
        with self._lock:
            target = self._target
            ask = common.MAVLink_mission_request_list_message(*target, self._type)
            count = self._ask(ask, lambda m: m.get_type() == "MISSION_COUNT").count
            items = [self._read_item(seq) for seq in range(count)]
            # For an empty mission, too: until then PX4 takes no upload.
            self._client.send(
                common.MAVLink_mission_ack_message(*target, common.MAV_MISSION_ACCEPTED, self._type)
            )
            return items

    def write(self, items: Sequence[MissionItem]) -> None:
        """Replace the flight controller's mission; raises MissionError."""
        messages = [self._item_message(seq, item) for seq, item in enumerate(items)]
        with self._lock:
            message = common.MAVLink_mission_count_message(*self._target, len(items), self._type)
            while True:
                answer = self._ask(message, lambda m: m.get_type() in (*_REQUESTS, "MISSION_ACK"))
                if answer.get_type() == "MISSION_ACK":
                    _require_accepted(answer)
                    return
                if answer.seq >= len(messages):
                    raise MissionError(f"the flight controller asks for item {answer.seq} of {len(items)}")
                message = messages[answer.seq]

    def clear(self) -> None:
        """Delete the flight controller's mission; raises MissionError."""
        with self._lock:
            ask = common.MAVLink_mission_clear_all_message(*self._target, self._type)
            _require_accepted(self._ask(ask, lambda m: m.get_type() == "MISSION_ACK"))

    def set_current(self, seq: int) -> None:
        """Choose the item to fly to; raises MissionError."""
        with self._lock:
            ask = common.MAVLink_mission_set_current_message(*self._target, seq)
            self._ask(ask, lambda m: m.get_type() == "MISSION_CURRENT" and m.seq == seq)

    @property
    def _target(self) -> tuple[int, int]:
        return self._client.target.system_id, self._client.target.component_id

    def _read_item(self, seq: int) -> MissionItem:
        ask = common.MAVLink_mission_request_int_message(*self._target, seq, self._type)
        m = self._ask(
            ask,
            lambda m: m.get_type() == "MISSION_ACK" or (m.get_type() == "MISSION_ITEM_INT" and m.seq == seq),
        )
        if m.get_type() == "MISSION_ACK":
            raise MissionError(f"the flight controller does not give item {seq}: {_result(m)}")
        scale = _scale(m.frame)
        return MissionItem(
            frame=m.frame,
            command=m.command,
            is_current=bool(m.current),
            autocontinue=bool(m.autocontinue),
            params=(m.param1, m.param2, m.param3, m.param4),
            x=m.x / scale,
            y=m.y / scale,
            z=m.z,
        )

    def _item_message(self, seq: int, item: MissionItem) -> common.MAVLink_message:
        scale = _scale(item.frame)
        x, y = item.x * scale, item.y * scale
        # NaN in the parameters means "not given" to many commands.
        params = [p for p in item.params if p == p]
        if not (abs(x) <= _INT32_MAX and abs(y) <= _INT32_MAX and fit_float32([*params, item.z])):
            raise MissionError(f"item {seq} holds NaN, infinity or a number beyond MAVLink's")
        return common.MAVLink_mission_item_int_message(
            *self._target,
            seq,
            item.frame,
            item.command,
            int(item.is_current),
            int(item.autocontinue),
            *item.params,
            round(x),
            round(y),
            item.z,
            self._type,
        )

    def _ask(
        self, message: common.MAVLink_message, is_answer: Callable[[common.MAVLink_message], bool]
    ) -> common.MAVLink_message:
        """Send a message repeatedly until an answer comes; raises MissionError if none does."""
        self._answers = queue.Queue()
        self._listening = True
        try:
            for _ in range(_TRIES):
                self._client.send(message)
                answer = self._wait_for(is_answer)
                if answer is not None:
                    return answer
        finally:
            self._listening = False
        raise MissionError(f"the flight controller does not answer {message.get_type()}")

    def _wait_for(self, is_answer: Callable) -> common.MAVLink_message | None:
        end_s = time.monotonic() + self._timeout_s
        while True:
            try:
                answer = self._answers.get(timeout=max(end_s - time.monotonic(), 0.0))
            except queue.Empty:
                return None
            if is_answer(answer):
                return answer

    def _on_message(self, message: common.MAVLink_message) -> None:
        if self._listening and getattr(message, "mission_type", _MISSION) == self._type:
            self._answers.put(message)


def _scale(frame: int) -> float:
    """Return the factor of MISSION_ITEM_INT's x and y."""
    return 1e4 if frame in _LOCAL_FRAMES else 1e7


def _require_accepted(ack: common.MAVLink_message) -> None:
    if ack.type != common.MAV_MISSION_ACCEPTED:
        raise MissionError(f"the flight controller refuses the mission: {_result(ack)}")


def _result(ack: common.MAVLink_message) -> str:
    known = common.enums["MAV_MISSION_RESULT"].get(ack.type)
    return known.name if known else f"MAV_MISSION_RESULT {ack.type}"
