"""The publisher on the flight controller, in closed loop without ROS."""

from __future__ import annotations

import copy
import math
import sys
from collections import deque
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from simulation_tools.geometry import Pose
from simulation_tools.ned_frames import attitude_to_enu, attitude_to_ned, enu_to_ned
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
from simulation_tools.px4.estimation.choice import EKF2
from simulation_tools.px4.estimation.samples import ExternalVision
from simulation_tools.px4.modes import LandedState, Mode
from simulation_tools.px4.parameters import Px4Parameters
from simulation_tools.px4.px4 import Px4
from simulation_tools.px4.setpoint import Setpoint
from simulation_tools.simulation.parameters import WITHOUT_GNSS


class ClosedLoop:
    """The publisher flies the flight controller; ready_s: the time when it was first ready.

    vision: of a flight controller that flies by external poses at 25 Hz, 30 ms old, with 1 cm of noise.
    """

    def __init__(self, extra_kg=0.13, vision=False):
        sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "px4"))
        from flight import Flight

        self.flight = Flight.of_iris(extra_kg, seed=2)
        if vision:
            parameters = Px4Parameters(WITHOUT_GNSS)
            rng = np.random.default_rng(2)
            self.flight.px4 = Px4(self.flight.airframe, parameters, rng, estimator=EKF2)
        self.publisher = SetpointPublisher(
            PublisherParameters(ground_clearance_m=0.0, needs_vision=vision, needs_home=not vision)
        )
        self.vision = self.vision_needed = vision
        self.ready_s = None
        self._noise = np.random.default_rng(3)
        self._under_way = deque()  # poses, each with its time of arrival
        self._ticks = 0

    def _act(self, actions):
        px4 = self.flight.px4
        for action in actions:
            if isinstance(action, SendPosition):
                px4.offer_setpoint(Setpoint.hold(action.position, action.yaw))
            elif isinstance(action, SendVelocity):
                px4.offer_setpoint(Setpoint.fly(action.linear, action.yaw_rate))
            elif isinstance(action, RequestMode):
                px4.request_mode(next(mode for mode in Mode if mode.label == action.mode))
            elif isinstance(action, RequestArm):
                px4.request_arm()
            elif isinstance(action, AnnounceReady) and action.ready and self.ready_s is None:
                self.ready_s = self.flight.time_s

    def _see(self, now_us):
        body = self.flight.body
        if self.vision and self._ticks % 10 == 0:
            place = enu_to_ned(body.position + self._noise.normal(0.0, 0.01, 3))
            sample = ExternalVision(now_us, position_m=place, attitude=attitude_to_ned(body.attitude))
            self._under_way.append((now_us + 30_000, sample))
        while self._under_way and self._under_way[0][0] <= now_us:
            self.flight.px4.offer_external_vision(self._under_way.popleft()[1])
            self._act(self.publisher.on_vision(1000 * now_us))

    def run(self, seconds, velocity=None, yaw_rate=0.0):
        """Fly; velocity, yaw_rate: commanded at 40 Hz. Return rows of time, true position and speed."""
        rows = []
        for _ in range(round(seconds / 0.004)):
            self.flight.step()
            self._ticks += 1
            flight, publisher, now = self.flight, self.publisher, 1000 * self.flight.body.time_us
            status = flight.px4.status
            self._see(flight.body.time_us)
            if self.vision_needed and self._ticks % 3 == 1:
                self._act(publisher.on_clock(now))
            if self._ticks % 50 == 1:
                self._act(publisher.on_landed_state(now, int(status.landed_state)))
                state = FcuState(True, status.armed, status.mode.label, status.system_status)
                self._act(publisher.on_state(now, state))
                if flight.px4.home is not None:
                    self._act(publisher.on_home(now))
            if self._ticks % 8 == 1 and status.position_valid:
                estimate = flight.px4.estimate[0]
                seen = (enu_to_ned(estimate["position"]), attitude_to_enu(estimate["attitude"].tolist()))
                known = (flight.body.position, flight.body.attitude)
                self._act(publisher.on_local_pose(now, Pose(*(seen if self.vision_needed else known))))
            if velocity is not None and self._ticks % 6 == 1:
                self._act(publisher.on_velocity(now, "", velocity, yaw_rate))
            rows.append((flight.time_s, *flight.body.position, math.hypot(*flight.body.velocity)))
        return np.array(rows)


# Over six seeds of the estimate's noise 9.6 to 10.4 s and 10.5 to 11.4 s.
@pytest.mark.table(("extra_kg", "limit_s"), [(0.13, 10.6), (0.80, 11.6)])
def test_in_closed_loop_it_is_ready_soon_and_does_not_overshoot(extra_kg, limit_s):
    loop = ClosedLoop(extra_kg)
    loop.run(14.0)
    flight = loop.flight
    assert loop.ready_s is not None
    assert loop.ready_s < limit_s
    assert flight.body.position == pytest.approx((0.0, 0.0, 2.0), abs=0.05)
    assert flight.px4.status.landed_state is LandedState.IN_AIR
    loop.run(16.0, velocity=(0.0, 0.0, 0.0))  # commands of zero hover at the hover height
    assert flight.body.position == pytest.approx((0.0, 0.0, 2.0), abs=0.05)


@cache
def hovering_by_vision():
    loop = ClosedLoop(vision=True)
    loop.run(14.5)
    assert loop.ready_s is not None
    return loop


def test_in_closed_loop_without_vision_it_stops_and_lands():
    """Real PX4 left to itself flies on at 1 m/s for 5 s and is on the ground after 8.5 m."""
    loop = copy.deepcopy(hovering_by_vision())
    before = loop.run(4.0, velocity=(1.0, 0.0, 0.0))[-1]
    assert before[4] == pytest.approx(1.0, abs=0.1)
    loop.vision = False
    after = loop.run(12.0, velocity=(1.0, 0.0, 0.0))
    since_s, way_m = after[:, 0] - before[0], np.hypot(*(after[:, 1:3] - before[1:3]).T)
    # A brake that ends too late swings it back at 0.12 m/s.
    assert np.all(after[(since_s > 0.5) & (since_s < 3.0), 4] < 0.1)
    assert way_m[since_s < 3.0].max() < 0.5
    assert way_m.max() < 0.6
    assert loop.flight.px4.status.mode is Mode.AUTO_LAND
    assert after[since_s > 8.0, 3].max() < 0.1


@pytest.mark.table("speed_m_s", [0.5, 1.0])
def test_in_closed_loop_without_vision_it_stops_as_soon_while_it_turns(speed_m_s):
    loop = copy.deepcopy(hovering_by_vision())
    curve = {"velocity": (speed_m_s, 0.0, 0.0), "yaw_rate": 1.0}
    lost_s = loop.run(4.0, **curve)[-1, 0]
    loop.vision = False
    after = loop.run(2.5, **curve)
    since_s, speeds_m_s = after[:, 0] - lost_s, after[:, 4]
    # Over three seeds 0.43 and 0.49 s. Later it drifts by the error of PX4's estimate, at 0.15 m/s.
    assert since_s[speeds_m_s < 0.1][0] < 0.5
    assert np.all(speeds_m_s[since_s > 0.5] < 0.15)
