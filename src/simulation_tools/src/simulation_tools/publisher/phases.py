"""The phases of the publisher and the transitions between them."""

from __future__ import annotations

import enum

from simulation_tools.geometry import Pose
from simulation_tools.publisher.brake import Brake
from simulation_tools.publisher.heard import Heard, Known
from simulation_tools.publisher.hover import Hover
from simulation_tools.publisher.interface import (
    Action,
    AnnounceReady,
    FcuState,
    Log,
    PublisherParameters,
    RequestArm,
    RequestMode,
    RequestTakeoff,
    SetOrigin,
)
from simulation_tools.publisher.vision_watch import Blindness

_ON_GROUND = 1  # MAV_LANDED_STATE
_LANDS_BLIND_S = 0.5
"""Without external poses for so long, a landing is one without a place, and is told as such."""
_SINKS_BLIND_S = 1.0
"""After so long the publisher itself brings down level a UAV whose landing does not. Poses may be late."""
_BLIND_QUIET_S, _BLIND_LASTS_S = 10.0, 1.0
"""Poses that go and come are told once in this time, and again only where they are missing for so long."""
_TOGETHER_S = 5.0
"""What the flight controller says within this time before a change of mode explains it."""
_NS = 1e-9


class Phase(enum.Enum):
    """A phase of the publisher. The value is its description in the log."""

    WAITING = "waiting for the flight controller"
    TAKING_OFF = "taking off"
    RETURNING = "getting back to hover after the flight controller or MAVROS was away"
    FLYING = "flying by commands"
    BLIND = "standing still without a pose"
    SINKING = "coming down level without a pose"
    YIELDED = "leaving the UAV to whoever changed its mode"
    IDLE = "on the ground, done"


_LED = (Phase.TAKING_OFF, Phase.RETURNING, Phase.FLYING)  # by this node's setpoints


class Phases:
    """Holds the present phase. `advance` makes the transitions. Every call returns actions."""

    def __init__(self, heard: Heard, hover: Hover) -> None:
        self._heard = heard
        self._hover = hover

    def restart(self, p: PublisherParameters) -> None:
        """Begin again: take off if the UAV stands on the ground, else take over in flight."""
        self.phase = Phase.WAITING
        self._requested_ns: int | None = None
        self._hover.release()
        self._hover_z_m = (
            p.hover_height_m - p.ground_clearance_m
        )  # the local frame begins where the UAV stood
        self._seen_offboard = self._has_flown = self._may_arm = self._was_failsafe = False
        self._knows_home = False
        self._flew = False  # before it became blind, by commands or by itself
        self._blind_told_ns: int | None = None
        self._blind_is_told = False  # of the present time without poses
        self._lands_blind = False  # and that was told
        self._said: tuple[int, str] | None = None
        self._told_ns = 0  # stamp of the newest state that made a decision
        self.brake: Brake | None = None  # of the last time it became blind
        self.sinking_yaw_rad = 0.0

    def advance(
        self,
        now_ns: int,
        known: Known,
        stream_began_ns: int,
        poses_missing: bool,
        blindness: Blindness,
        p: PublisherParameters,
    ) -> list[Action]:
        """Make the transitions by the messages known `decision_delay_s` ago.

        A late command looks back to a state that is older than the last one. It makes no transition.

        stream_began_ns: time of the first setpoint. poses_missing: poses came earlier and have stopped.
        """
        pose, state, landed, home, told_ns = known
        if pose is None or state is None or landed is None or not state.connected or told_ns < self._told_ns:
            return []
        self._told_ns = told_ns
        self._knows_home = bool(home)
        needs_home = p.needs_home or (p.needs_vision and p.family.needs_origin)
        may_fly = self._knows_home or not needs_home
        self._may_arm = may_fly and not (blindness.is_too_long or p.awaits_order)
        is_flying = state.armed and landed != _ON_GROUND
        actions: list[Action] = []
        takes_over = self.phase is Phase.YIELDED or (self.phase is Phase.WAITING and is_flying)
        if blindness.is_too_long and state.is_guided(p.family) and (self.phase in _LED or takes_over):
            actions = self._enter_blind(now_ns, blindness.lasts_s, p)
        elif self.phase is Phase.BLIND:
            actions = self._stand(now_ns, pose, state, blindness, p)
        elif self.phase is Phase.WAITING:
            actions = self._begin(pose, state, is_flying, p)
        elif self.phase is Phase.TAKING_OFF:
            has_streamed = (now_ns - stream_began_ns) * _NS >= p.min_stream_s
            actions = self._take_off(now_ns, pose, state, is_flying, has_streamed, p)
        elif self.phase is Phase.FLYING:
            actions = self._fly(now_ns, pose, state, p)
        elif self.phase is Phase.RETURNING:
            actions = self._return(now_ns, pose, state, is_flying, poses_missing, p)
        elif self.phase is Phase.YIELDED:
            actions = self._yield(now_ns, pose, state, is_flying, blindness, p)
        elif self.phase is Phase.SINKING:
            actions = self._sink(now_ns, state, is_flying, p)
        self._was_failsafe = state.failsafe(p.family) or (self._was_failsafe and not state.armed)
        return actions

    def on_text(self, stamp_ns: int, text: str) -> None:
        """Note what the flight controller says to people."""
        self._said = (stamp_ns, text)

    def return_to(self, pose: Pose) -> list[Action]:
        """Hover over a pose before taking commands again. The UAV flew without setpoints and may be low."""
        self.phase = Phase.RETURNING
        self._requested_ns = None
        self._hover.climb_over(pose, self._hover_z_m)
        return [AnnounceReady(False), Log("the connection to the flight controller broke: hovering first.")]

    # One method for each phase

    def _begin(self, pose: Pose, state: FcuState, is_flying: bool, p: PublisherParameters) -> list[Action]:
        if is_flying and state.mode != p.family.guided and not state.failsafe(p.family):
            return self._enter_yielded(state, p)
        if is_flying:
            if state.failsafe(p.family):
                return self.return_to(pose)
            return self._enter_flying(pose, "the UAV is in the air: taking over where it is.")
        self.phase = Phase.TAKING_OFF
        self._aim_over(pose, p)
        self._seen_offboard = self._has_flown = False
        return []

    def _aim_over(self, pose: Pose, p: PublisherParameters) -> None:
        """Hover over where the UAV stands on the ground."""
        self._hover_z_m = pose.position_m[2] + (p.hover_height_m - p.ground_clearance_m)
        self._hover.climb_over(pose, self._hover_z_m)

    def _take_off(
        self,
        now_ns: int,
        pose: Pose,
        state: FcuState,
        is_flying: bool,
        has_streamed: bool,
        p: PublisherParameters,
    ) -> list[Action]:
        is_guided = state.is_guided(p.family)
        self._seen_offboard = self._seen_offboard or is_guided
        self._has_flown = self._has_flown or is_flying
        if self._has_flown and not state.armed and not self._was_failsafe:
            return self._enter_idle()
        if self._seen_offboard and is_flying and not is_guided and not state.failsafe(p.family):
            return self._enter_yielded(state, p)
        if is_guided and self._hover.reached(now_ns, p):
            return self._enter_flying(None, "hovering, ready.")
        if is_guided:
            waits = p.family.takes_off_by_command and not is_flying
            height_m = p.hover_height_m - p.ground_clearance_m
            return self._request(now_ns, p, RequestTakeoff(height_m)) if waits else []
        if not (state.armed or self._may_arm):
            self._aim_over(pose, p)  # a new estimate still moves
            has_none = p.needs_vision and p.family.needs_origin and not self._knows_home
            return self._request(now_ns, p, SetOrigin()) if has_none else []
        return self._request(now_ns, p, RequestMode(p.family.guided), RequestArm()) if has_streamed else []

    def _fly(self, now_ns: int, pose: Pose, state: FcuState, p: PublisherParameters) -> list[Action]:
        if not state.armed:
            return self._end_flight()
        if state.failsafe(p.family):
            return self.return_to(pose) + self._request(now_ns, p, RequestMode(p.family.guided))
        return [] if state.mode == p.family.guided else self._enter_yielded(state, p)

    def _return(
        self,
        now_ns: int,
        pose: Pose,
        state: FcuState,
        is_flying: bool,
        poses_missing: bool,
        p: PublisherParameters,
    ) -> list[Action]:
        if not state.armed:
            return self._end_flight()
        if state.failsafe(p.family):
            self._hover.climb_over(pose, self._hover_z_m)
            return self._request(now_ns, p, RequestMode(p.family.guided))
        if state.mode != p.family.guided:
            return self._enter_yielded(state, p)
        if p.family.takes_off_by_command and not is_flying:  # a setpoint does not lift it
            self.phase = Phase.TAKING_OFF
            self._aim_over(pose, p)
            return []
        if poses_missing or not self._hover.reached(now_ns, p):
            return []
        return self._enter_flying(None, "hovering again, ready.")

    def _stand(
        self, now_ns: int, pose: Pose, state: FcuState, blindness: Blindness, p: PublisherParameters
    ) -> list[Action]:
        if not state.armed:
            return self._end_flight()
        if state.failsafe(p.family):
            return self.return_to(pose)
        if state.mode != p.family.guided:
            return self._enter_yielded(state, p)
        if not blindness.is_too_long:
            text = "the flight controller gets poses again"
            if self._flew:
                actions = self._enter_flying(pose, f"{text}, ready.")
            else:
                actions = [*self.return_to(pose)[:1], Log(f"{text}: hovering first.", is_warning=False)]
            return actions if self._blind_is_told else actions[:1]
        if blindness.lasts_s < p.vision_landing_s:
            return self._tell_blind(now_ns, blindness.lasts_s) if blindness.lasts_s >= _BLIND_LASTS_S else []
        return self._request(now_ns, p, RequestMode(p.family.landing))

    def _yield(
        self,
        now_ns: int,
        pose: Pose,
        state: FcuState,
        is_flying: bool,
        blindness: Blindness,
        p: PublisherParameters,
    ) -> list[Action]:
        if not state.armed:
            return self._enter_idle()
        patience_s = _SINKS_BLIND_S if p.family.levelled else _LANDS_BLIND_S
        if state.mode == p.family.landing and blindness.lasts_s >= patience_s and not self._lands_blind:
            self._lands_blind = True
            if p.family.levelled and is_flying:
                return self._enter_sinking(now_ns, pose, p)
            return [Log("no sure pose while the UAV lands: the flight controller brings it down level.")]
        guided = p.family.guided
        if state.mode == guided and not state.failsafe(p.family):
            return self._enter_flying(pose, f"{guided} again: taking over where the UAV is.")
        return []

    def _sink(self, now_ns: int, state: FcuState, is_flying: bool, p: PublisherParameters) -> list[Action]:
        """Come down level. On the ground the landing disarms. Who changes the mode meanwhile has the UAV."""
        if not state.armed:
            return self._enter_idle()
        if state.mode not in (p.family.landing, p.family.levelled):
            return self._enter_yielded(state, p)
        mode = p.family.levelled if is_flying else p.family.landing
        return [] if state.mode == mode else self._request(now_ns, p, RequestMode(mode))

    def _end_flight(self) -> list[Action]:
        """Take off again after a failsafe's landing. Any other landing ends the flight."""
        if not self._was_failsafe:
            return self._enter_idle()
        self.phase = Phase.WAITING
        return [AnnounceReady(False), Log("the flight controller landed in a failsafe: taking off again.")]

    # Entering a phase

    def _enter_flying(self, pose: Pose | None, text: str) -> list[Action]:
        """pose: the UAV holds it until a command comes; None keeps the hover point."""
        self.phase = Phase.FLYING
        self._requested_ns = None
        if pose is not None:
            self._hover.hold(pose)
        return [AnnounceReady(True), Log(text, is_warning=False)]

    def _enter_blind(self, now_ns: int, blind_s: float, p: PublisherParameters) -> list[Action]:
        self.brake = self._hover.brake(now_ns, p) if p.family.brakes_by_plan else None
        self._flew = self.phase not in (Phase.TAKING_OFF, Phase.RETURNING)
        self.phase = Phase.BLIND
        self._requested_ns = None
        self._hover.release()
        self._blind_is_told = False
        told_ns = self._blind_told_ns
        is_news = told_ns is None or not 0.0 <= (now_ns - told_ns) * _NS < _BLIND_QUIET_S
        return [AnnounceReady(False), *(self._tell_blind(now_ns, blind_s) if is_news else ())]

    def _tell_blind(self, now_ns: int, blind_s: float) -> list[Action]:
        if self._blind_is_told:
            return []
        self._blind_is_told, self._blind_told_ns = True, now_ns
        text = f"the flight controller has had no external pose for {blind_s:.2f} s: stopping, then landing."
        return [Log(text)]

    def _enter_sinking(self, now_ns: int, pose: Pose, p: PublisherParameters) -> list[Action]:
        self.phase = Phase.SINKING
        self.sinking_yaw_rad = pose.yaw_rad
        self._requested_ns = None
        text = "no sure pose while the UAV lands: it comes down level, and may drift."
        return [Log(text), *self._request(now_ns, p, RequestMode(p.family.levelled))]

    def _enter_yielded(self, state: FcuState, p: PublisherParameters) -> list[Action]:
        self.phase = Phase.YIELDED
        guided, landing = p.family.guided, p.family.landing
        if state.mode == landing and not state.failsafe(p.family) and not self._explains:
            text = f"{landing} was ordered: the flight controller lands the UAV by itself."
            return [AnnounceReady(False), Log(text, is_warning=False)]
        return [AnnounceReady(False), Log(f"{self._who(state)}: leaving the UAV to it until it is {guided}.")]

    def _who(self, state: FcuState) -> str:
        if self._explains:
            return f'the mode is {state.mode} now, and the flight controller says "{self._explains}"'
        return f"somebody else has set the mode {state.mode}"

    @property
    def _explains(self) -> str:
        """What the flight controller has just said to people; empty: nothing."""
        if self._said is None or abs(self._told_ns - self._said[0]) * _NS > _TOGETHER_S:
            return ""
        return self._said[1]

    def _enter_idle(self) -> list[Action]:
        self.phase = Phase.IDLE
        text = "disarmed: the flight is over. For another take-off: rosservice call /mavros_publisher/restart"
        return [AnnounceReady(False), Log(text, is_warning=False)]

    def _request(self, now_ns: int, p: PublisherParameters, *requests: Action) -> list[Action]:
        """Return the requests, unless they were just made or their result is not known yet."""
        if self._requested_ns is not None:
            since_s = (now_ns - self._requested_ns) * _NS
            told = self._heard.state_newer_than(self._requested_ns, now_ns, p)
            if since_s < (p.retry_period_s if told else p.state_patience_s):
                return []
        self._requested_ns = now_ns
        return list(requests)
