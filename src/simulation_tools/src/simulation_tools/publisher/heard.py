"""The newest messages from the flight controller, and which ones are missing."""

from __future__ import annotations

from typing import NamedTuple

from simulation_tools.geometry import Pose
from simulation_tools.publisher.history import History
from simulation_tools.publisher.interface import FcuState, PublisherParameters

_NS = 1e-9


class Known(NamedTuple):
    """The messages known at one time; None: not received.

    landed: MAV_LANDED_STATE. home: True if there is one. told_ns: stamp of the state; 0: there is none.
    """

    pose: Pose | None
    state: FcuState | None
    landed: int | None
    home: bool | None
    told_ns: int


class Heard:
    """Keeps the last messages of each kind."""

    def __init__(self) -> None:
        self.poses, self.states, self.landed, self.homes = History(), History(), History(), History()

    def forget(self) -> None:
        """Forget all messages."""
        for history in (self.poses, self.states, self.landed, self.homes):
            history.clear()

    def known(self, now_ns: int, p: PublisherParameters) -> Known:
        """Return the newest messages that have surely arrived by now."""
        then_ns = now_ns - p.decision_delay_s / _NS
        kinds = self.poses, self.states, self.landed, self.homes
        (_, pose), (told_ns, state), (_, landed), (_, home) = [kind.item_at(then_ns) for kind in kinds]
        return Known(pose, state, landed, home, told_ns or 0)

    def state_newer_than(self, stamp_ns: int, now_ns: int, p: PublisherParameters) -> bool:
        """Whether the newest state that has surely arrived by now was sent after a time."""
        newest_ns = self.states.stamp_at(now_ns - p.decision_delay_s / _NS)
        return newest_ns is not None and newest_ns > stamp_ns

    def lacking(self, gets_vision: bool, p: PublisherParameters) -> str:
        """Return in words what is missing for a flight by setpoints; empty: nothing.

        gets_vision: whether external poses have gone to MAVROS.
        """
        state = self.states.newest()
        if state is None:
            return "no `state` from MAVROS yet"
        if not state.connected:
            return "MAVROS hears no flight controller"
        if self.landed.newest() is None:
            return "no `extended_state` from MAVROS yet"
        if self.poses.newest() is None:
            words = "no `local_position/pose` from MAVROS yet"
            if not p.needs_vision:
                return words
            if gets_vision:
                return f"{words} (external poses go there: has it mavros_extras, and are they used?)"
            return (
                f"{words} (the flight controller needs external poses; /UAV/vision_state says what it gets)"
            )
        if p.needs_home and self.homes.newest() is None and not state.armed:
            return "no home position (`home_position/home`) from MAVROS yet"
        if p.awaits_order and not state.armed:
            return "no order to take off yet (rosservice call /mavros_publisher/restart)"
        if state.mode != p.family.guided:
            return f"the mode is {state.mode}, not {p.family.guided}"
        return "" if state.armed else "the flight controller is not armed"
