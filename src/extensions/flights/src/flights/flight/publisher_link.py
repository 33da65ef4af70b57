"""Between `mavros_publisher`'s state machine and the flight controller, in place of MAVROS and MAVLink."""

from __future__ import annotations

from dataclasses import replace
from typing import Callable

from flights.flight.due import Due
from simulation_tools.geometry import Pose, Vector3
from simulation_tools.ned_frames import attitude_to_enu, enu_to_ned
from simulation_tools.publisher import (
    AnnounceReady,
    FcuState,
    PublisherParameters,
    RequestArm,
    RequestMode,
    SendPosition,
    SendVelocity,
    SetpointPublisher,
)
from simulation_tools.px4.modes import Mode
from simulation_tools.px4.px4 import Px4
from simulation_tools.px4.setpoint import Setpoint

# Periods of PX4's LOCAL_POSITION_NED, EXTENDED_SYS_STATE and HEARTBEAT on the offboard link
POSE_PERIOD_US = 33_333
LANDED_PERIOD_US = 200_000
STATE_PERIOD_US = 1_000_000
CLOCK_PERIOD_US = 10_000
"""Of the node's own watch."""
_MODES = {mode.label: mode for mode in Mode}


class PublisherLink:
    """Passes PX4's messages to the publisher, and the publisher's actions to PX4.

    silent: nothing passes in either direction, as if the publisher had died. velocity_m_s: of the last
    setpoint (FLU); zero for a position. parameters: as given.
    """

    def __init__(self, px4: Px4, parameters: PublisherParameters) -> None:
        self.silent = False
        self.ready = False
        self.velocity_m_s: Vector3 = (0.0, 0.0, 0.0)
        self._px4, self.parameters = px4, parameters
        self._home: object = None  # the last one passed on
        self._publisher = SetpointPublisher(parameters)
        self._streams: tuple[tuple[Due, Callable[[int], list]], ...] = (
            (Due(STATE_PERIOD_US), self._tell_state),
            (Due(LANDED_PERIOD_US), self._tell_landed),
            (Due(POSE_PERIOD_US), self._tell_pose),
        )
        if parameters.needs_vision:
            self._streams += ((Due(CLOCK_PERIOD_US), self._tell_clock),)
        self._due_us = 0  # when the next message of a stream is due

    def restart(self, hover_height_m: float) -> None:
        """Take off again, after a landing that was ordered. hover_height_m: over the ground."""
        self.ready, self._home = False, None  # it forgets the home position, and PX4 tells it all the time
        self._publisher.parameters = replace(self._publisher.parameters, hover_height_m=hover_height_m)
        self._publisher.restart()

    def on_time(self, time_us: int) -> None:
        """Pass on PX4's streams of this instant, and its home position if there is one.

        Call this at every step.
        """
        if self._px4.home is not self._home and not self.silent:
            self._home = self._px4.home
            self._carry_out(self._publisher.on_home(1000 * time_us))
        if time_us < self._due_us:
            return
        for due, tell in self._streams:
            if due(time_us) and not self.silent:
                self._carry_out(tell(1000 * time_us))
        self._due_us = min(due.next_us for due, _ in self._streams)

    def on_vision(self, time_us: int) -> None:
        """Pass on that the flight controller has got an external pose."""
        if not self.silent:
            self._carry_out(self._publisher.on_vision(1000 * time_us))

    def on_velocity(self, time_us: int, velocity_flu_m_s: Vector3, yaw_rate_rad_s: float) -> None:
        """Pass on a velocity command for the scan of this instant."""
        if not self.silent:
            command = self._publisher.on_velocity(1000 * time_us, "", velocity_flu_m_s, yaw_rate_rad_s)
            self._carry_out(command)

    def use_position_setpoints(self, wanted: bool) -> None:
        """Send positions instead of velocities from now on, or velocities again."""
        self._publisher.parameters = replace(self._publisher.parameters, use_position_setpoint=wanted)

    def _tell_state(self, stamp_ns: int) -> list:
        status = self._px4.status
        state = FcuState(True, status.armed, status.mode.label, status.system_status)
        return self._publisher.on_state(stamp_ns, state)

    def _tell_landed(self, stamp_ns: int) -> list:
        return self._publisher.on_landed_state(stamp_ns, int(self._px4.status.landed_state))

    def _tell_clock(self, now_ns: int) -> list:
        return self._publisher.on_clock(now_ns)

    def _tell_pose(self, stamp_ns: int) -> list:
        if not self._px4.estimate_valid:
            return []
        estimate = self._px4.estimate[0]
        position = enu_to_ned(estimate["position"].tolist())  # its own inverse
        return self._publisher.on_local_pose(
            stamp_ns, Pose(position, attitude_to_enu(estimate["attitude"].tolist()))
        )

    def _carry_out(self, actions: list) -> None:
        for action in actions:
            if isinstance(action, SendVelocity):
                self.velocity_m_s = action.linear
                stamp_ms = action.stamp_ns // 1_000_000
                self._px4.offer_setpoint(Setpoint.fly(action.linear, action.yaw_rate, stamp_ms))
            elif isinstance(action, SendPosition):
                self.velocity_m_s = (0.0, 0.0, 0.0)
                stamp_ms = action.stamp_ns // 1_000_000
                self._px4.offer_setpoint(Setpoint.hold(action.position, action.yaw, stamp_ms))
            elif isinstance(action, RequestMode):
                self._px4.request_mode(_MODES[action.mode])
            elif isinstance(action, RequestArm):
                self._px4.request_arm()
            elif isinstance(action, AnnounceReady):
                self.ready = action.ready
