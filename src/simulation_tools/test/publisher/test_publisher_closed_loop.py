"""The publisher on the flight controller, in closed loop without ROS."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from simulation_tools.geometry import Pose
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
from simulation_tools.px4.modes import LandedState


def fly_closed_loop(extra_kg, seconds, velocity=None):
    """Fly the publisher on the flight controller; returns (flight, publisher, time when ready).

    velocity: commanded at 40 Hz all the time.
    """
    sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "px4"))
    from flight import Flight

    from simulation_tools.px4.modes import Mode
    from simulation_tools.px4.setpoint import Setpoint

    flight = Flight.of_iris(extra_kg, seed=2)
    publisher = SetpointPublisher(PublisherParameters(ground_clearance_m=0.0))
    ready_s = None

    def act(actions):
        nonlocal ready_s
        for action in actions:
            if isinstance(action, SendPosition):
                flight.px4.offer_setpoint(Setpoint.hold(action.position, action.yaw))
            elif isinstance(action, SendVelocity):
                flight.px4.offer_setpoint(Setpoint.fly(action.linear, action.yaw_rate))
            elif isinstance(action, RequestMode):
                flight.px4.request_mode(Mode.OFFBOARD)
            elif isinstance(action, RequestArm):
                flight.px4.request_arm()
            elif isinstance(action, AnnounceReady) and action.ready:
                ready_s = flight.time_s

    for tick in range(round(seconds / 0.004)):
        flight.step()
        now = 1000 * flight.body.time_us
        status = flight.px4.status
        if tick % 50 == 0:
            act(publisher.on_landed_state(now, int(status.landed_state)))
            state = FcuState(True, status.armed, status.mode.label, status.system_status)
            act(publisher.on_state(now, state))
            if flight.px4.home is not None:
                act(publisher.on_home(now))
        if tick % 8 == 0 and status.position_valid:
            act(publisher.on_local_pose(now, Pose(flight.body.position, flight.body.attitude)))
        if velocity is not None and tick % 6 == 0:
            act(publisher.on_velocity(now, "", velocity, 0.0))
    return flight, publisher, ready_s


# Over six seeds of the estimate's noise 9.6 to 10.4 s and 10.5 to 11.4 s.
@pytest.mark.parametrize(("extra_kg", "limit_s"), [(0.13, 10.6), (0.80, 11.6)])
def test_in_closed_loop_it_is_ready_soon_and_does_not_overshoot(extra_kg, limit_s):
    flight, _, ready_s = fly_closed_loop(extra_kg, 14.0)
    assert ready_s is not None
    assert ready_s < limit_s
    assert flight.body.position == pytest.approx((0.0, 0.0, 2.0), abs=0.05)
    assert flight.px4.status.landed_state is LandedState.IN_AIR


@pytest.mark.parametrize("extra_kg", [0.13, 0.80])
def test_in_closed_loop_commands_of_zero_hover_at_the_hover_height(extra_kg):
    flight, _, ready_s = fly_closed_loop(extra_kg, 30.0, velocity=(0.0, 0.0, 0.0))
    assert ready_s is not None
    assert flight.body.position == pytest.approx((0.0, 0.0, 2.0), abs=0.05)
