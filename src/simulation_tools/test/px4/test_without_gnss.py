"""Flights by external vision alone, on the body of PX4's measurements: with it, and after its loss."""

from __future__ import annotations

import copy
from collections import deque
from functools import lru_cache

import numpy as np
import pytest
from bodies import RigidBody, reference_quad
from flight import Flight

from simulation_tools.ned_frames import attitude_to_ned, enu_to_ned
from simulation_tools.px4.estimation.choice import EKF2
from simulation_tools.px4.estimation.samples import ExternalVision
from simulation_tools.px4.mavlink import telemetry
from simulation_tools.px4.modes import LandedState, Mode, Result
from simulation_tools.px4.parameters import Px4Parameters
from simulation_tools.px4.plan.items import Command, PlanItem
from simulation_tools.px4.plan.plan import PlanKind
from simulation_tools.px4.px4 import Px4
from simulation_tools.px4.setpoint import Setpoint
from simulation_tools.simulation.parameters import WITHOUT_GNSS

PERIOD_US, LATE_US, NOISE_M = 33_333, 50_000, 0.01  # of the vision in the measurements on real PX4
MEASURED_WITH = {**WITHOUT_GNSS, "EKF2_EV_DELAY": 50.0}  # ms


class VisionFlight(Flight):
    """A flight whose vision can be switched off; without GNSS and magnetometer."""

    def __init__(self, seed=0):
        super().__init__(reference_quad(), RigidBody.reference_quad(), seed=seed)
        parameters = Px4Parameters(MEASURED_WITH)
        self.px4 = Px4(self.airframe, parameters, np.random.default_rng(seed), estimator=EKF2)
        self.px4.on_statustext = self._hear
        self.sees = True
        self._rng = np.random.default_rng(seed + 1)
        self._under_way = deque()
        self._due_us = 0

    def step(self):
        now_us = self.body.time_us
        if self.sees and now_us >= self._due_us:
            self._due_us += PERIOD_US
            pose = self.body.state.pose
            seen = np.array(enu_to_ned(pose.position_m)) + NOISE_M * self._rng.standard_normal(3)
            sample = ExternalVision(now_us, tuple(seen), attitude=attitude_to_ned(pose.orientation_xyzw))
            self._under_way.append((now_us + LATE_US, sample))
        while self._under_way and self._under_way[0][0] <= now_us:
            self.px4.offer_external_vision(self._under_way.popleft()[1])
        super().step()


@lru_cache(maxsize=1)
def taken_off():
    flight = VisionFlight()
    flight.stream = Setpoint.hold((0.0, 0.0, 2.0))
    flight.run(6.0)
    assert flight.px4.request_mode(Mode.OFFBOARD) is Result.ACCEPTED
    assert flight.px4.request_arm() is Result.ACCEPTED
    flight.run(10.0)
    return flight


def flying(setpoint, seconds):
    """Return a flight that has taken off to 2 m and followed a setpoint; what has been said is forgotten."""
    flight = copy.deepcopy(taken_off())
    flight.stream = setpoint
    flight.run(seconds)
    flight.texts.clear()
    return flight


@pytest.fixture(scope="module")
def hover():
    """A minute of hover: its rows from 5 s on, half a minute long, and what the estimator says at its end."""
    flight = flying(Setpoint.hold((0.0, 0.0, 2.0)), 5.0)
    rows = flight.record(30.0)
    flight.run(25.0)
    return rows, flight.px4.estimator_status


def test_a_hover_by_vision_is_as_steady_as_px4s(hover):
    rows, _ = hover
    assert (100.0 * rows[:, 1:4].std(axis=0) < (0.9, 0.8, 0.7)).all()  # real PX4: 0.8, 0.7 and 0.6 cm


def test_a_hover_by_vision_has_px4s_covariance(hover):
    """Real PX4's `estimator_states`, median of 10 minutes of hover with this vision (commit 34160bb6c9)."""
    _, status = hover
    assert status.position_variance_m2 == pytest.approx((7.62e-4, 7.62e-4, 7.16e-4), rel=0.05)
    assert status.velocity_variance_m2_s2 == pytest.approx((1.933e-3, 1.933e-3, 1.656e-3), rel=0.05)


def test_a_velocity_step_by_vision_is_px4s():
    flight = flying(Setpoint.hold((0.0, 0.0, 2.0)), 2.0)
    flight.stream = Setpoint(velocity=(2.0, 0.0, 0.0))
    rows = flight.record(5.0)
    north = rows[:, 5]
    reached_s = [rows[np.argmax(north > share * 2.0), 0] for share in (0.1, 0.5, 0.9)]
    assert reached_s == pytest.approx([0.18, 0.50, 1.08], abs=0.05)
    assert 50.0 * north.max() - 100.0 == pytest.approx(10.1, abs=1.5)


@lru_cache(maxsize=1)
def lost_at_1_m_s():
    """The way after the loss of vision at a commanded 1 m/s: (flight, events with their times in s, m)."""
    flight = flying(Setpoint(velocity=(1.0, 0.0, 0.0)), 3.0)
    flight.sees = False
    began_s, start_m, events = flight.time_s, flight.body.position[1], {}
    while flight.time_s - began_s < 14.0:
        flight.run(0.1)
        status = flight.px4.status
        now = {
            "no position": not status.position_valid,
            "failsafe": status.failsafe,
            "flags 165": flight.px4.estimator_status.flags == 165,
            "on the ground": flight.body.position[2] == 0.0,
            "landed": status.landed_state is LandedState.ON_GROUND,
            "disarmed": not status.armed,
        }
        for name, happened in now.items():
            if happened:
                events.setdefault(name, flight.time_s - began_s)
    return flight, events, flight.body.position[1] - start_m


def test_after_the_loss_of_vision_px4_flies_on_and_lands_blind():
    """Real PX4: 5, 6, 7 and 9 s after the loss; 8.5 m from the loss to the ground."""
    flight, events, way_m = lost_at_1_m_s()
    assert events["no position"] == pytest.approx(5.0, abs=0.2)
    assert events["failsafe"] == pytest.approx(6.0, abs=0.2)
    assert events["flags 165"] == pytest.approx(7.0, abs=0.2)
    assert events["on the ground"] == pytest.approx(8.5, abs=1.0)
    assert way_m == pytest.approx(8.5, abs=1.3)
    assert flight.texts[:2] == ["Failsafe enabled: no RC and no offboard", "Failsafe mode activated"]
    assert flight.texts[2:] == ["Landing detected", "Disarmed by landing"]
    assert events["disarmed"] == pytest.approx(events["landed"] + 2.0, abs=0.2)


def test_vision_that_is_back_makes_it_offboard_again():
    flight, _, _ = lost_at_1_m_s()
    flight.texts.clear()
    flight.sees = True
    flight.run(1.5)
    assert flight.px4.status.mode is Mode.OFFBOARD
    assert flight.texts == ["Failsafe mode deactivated"]


def test_no_place_on_earth_is_told():
    flight = flying(Setpoint.hold((0.0, 0.0, 2.0)), 1.0)
    earthly = ("GLOBAL_POSITION_INT", "GPS_RAW_INT", "HOME_POSITION", "GPS_GLOBAL_ORIGIN")
    for name in earthly:
        assert telemetry.build(name, flight.px4, flight.px4.status) is None
    assert telemetry.build("LOCAL_POSITION_NED", flight.px4, flight.px4.status) is not None


def test_before_the_first_vision_only_manual_may_be_armed():
    flight = VisionFlight()
    flight.sees = False
    flight.stream = Setpoint.hold((0.0, 0.0, 2.0))
    flight.run(6.0)
    for mode in (Mode.OFFBOARD, Mode.AUTO_LOITER, Mode.AUTO_TAKEOFF):
        assert flight.px4.request_mode(mode) is Result.TEMPORARILY_REJECTED
    assert flight.px4.request_arm() is Result.ACCEPTED
    flight.run(1.0)
    assert "Failsafe enabled: No manual control stick input" in flight.texts
    assert flight.px4.status.mode is Mode.AUTO_LAND
    assert flight.body.position[2] == 0.0


def test_without_a_place_on_earth_there_is_no_mission_and_no_fence():
    flight = VisionFlight()
    flight.px4.parameters.set("GF_MAX_HOR_DIST", 1.0)
    item = PlanItem.accepted(Command.WAYPOINT, 6, (0.0,) * 4, (47.4, 8.5, 3.0), True, True)
    flight.px4.plan.replace(PlanKind.MISSION, [item])
    flight.run(6.0)
    assert flight.px4.estimate_valid
    assert flight.px4.request_mode(Mode.AUTO_MISSION) is Result.TEMPORARILY_REJECTED
    assert "Not yet ready for mission, no position lock." in flight.texts
    assert not [text for text in flight.texts if "Geofence" in text or "Maximum" in text]


def test_altctl_asks_for_a_height_only():
    """PX4 takes ALTCTL without a position, and POSCTL only with one."""
    flight = VisionFlight()
    flight.sees = False
    flight.run(4.0)
    assert not flight.px4.estimate_valid
    assert flight.px4.request_mode(Mode.ALTCTL) is Result.ACCEPTED
    assert flight.px4.request_mode(Mode.POSCTL) is Result.TEMPORARILY_REJECTED
