"""What the filter accepts, rejects, times out and resets, as measured on real PX4; and bad input.

A vehicle that stands still in the air is enough: the filter knows its motion by its sensors only.
"""

from __future__ import annotations

import copy
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from simulation_tools.autopilot import VehicleState
from simulation_tools.px4.estimation.ekf_estimator import EkfEstimator
from simulation_tools.px4.estimation.samples import ExternalVision, RangeSample
from simulation_tools.px4.estimation.sensors import SensorErrors
from simulation_tools.px4.parameters import Px4Parameters
from simulation_tools.simulation.parameters import WITHOUT_GNSS

STEP_US = 4_000
ON_THE_GROUND_US = 5_000_000  # PX4 levels itself before the take-off
AT_REST = VehicleState(0, specific_force_body_m_s2=(0.0, 0.0, 9.80665))
NAN = math.nan
FACING_NORTH = (1.0, 0.0, 0.0, 0.0)


class Bench:
    """An estimator on a bench, its nose to the east, with a vision that says where it likes."""

    def __init__(self, rate_hz=30.0, in_air=True, **parameters):
        self.estimator = EkfEstimator(
            SensorErrors(), np.random.default_rng(5), Px4Parameters({**WITHOUT_GNSS, **parameters})
        )
        self.in_air = in_air
        self.time_us = 0
        self.sees = ExternalVision(0, (0.0, 0.0, 0.0), None, FACING_NORTH)
        self.latency_us = 50_000
        self.period_us = round(1e6 / rate_hz)
        self._due_us = 0

    def run(self, seconds, until=lambda: False):
        """Return the time, s, until something is true, or None."""
        for k in range(round(1e6 * seconds / STEP_US)):
            if self.sees is not None and self.time_us >= self._due_us:
                self._due_us += self.period_us
                self.estimator.offer_external_vision(replace(self.sees, time_us=self.time_us))
            in_air = self.in_air and self.time_us > ON_THE_GROUND_US
            self.estimator.update(AT_REST._replace(time_us=self.time_us), 1e-6 * STEP_US, in_air)
            self.time_us += STEP_US
            if until():
                return 1e-6 * STEP_US * (k + 1)
        return None

    def move_to(self, *position):
        self.sees = replace(self.sees, position_m=position)

    @property
    def position(self):
        return self.estimator.estimate["position"][0]

    @property
    def status(self):
        return self.estimator.status


@pytest.fixture(scope="module")
def hovers():
    bench = Bench()
    bench.run(20.0)
    assert bench.estimator.horizontal_valid
    return bench


@pytest.fixture
def hovering(hovers):
    return copy.deepcopy(hovers)


def test_no_local_position_before_the_first_vision():
    bench = Bench(in_air=False)
    seen, bench.sees = bench.sees, None
    bench.run(8.0)
    assert not bench.estimator.horizontal_valid
    assert bench.estimator.vertical_valid
    assert bench.status.flags == 228
    bench.sees = seen
    valid_s = bench.run(3.0, lambda: bench.estimator.horizontal_valid)
    assert valid_s == pytest.approx(1.05, abs=0.15)
    assert bench.status.flags == 895
    bench.in_air = True
    bench.run(0.1)
    assert bench.status.flags == 831


def test_a_magnetometer_gives_the_attitude_before_the_first_vision():
    bench = Bench(in_air=False, SYS_HAS_MAG=1)
    bench.sees = None
    bench.run(8.0)
    assert bench.status.flags == 229
    assert bench.estimator.estimate["yaw"][0] == pytest.approx(math.pi / 2, abs=0.05)


def test_gnss_alone():
    bench = Bench(in_air=False, SYS_HAS_MAG=1, SYS_HAS_GPS=1, EKF2_AID_MASK=1, EKF2_HGT_MODE=0)
    bench.sees = None
    bench.run(8.0)
    assert bench.estimator.horizontal_valid
    assert bench.status.flags == 895
    assert np.abs(bench.position).max() < 0.1
    assert bench.status.horizontal_position_ratio < 1.0


def test_vision_lost_is_dead_reckoning_for_5_s_then_no_position(hovering):
    hovering.sees = None
    lost_s = hovering.run(10.0, lambda: not hovering.estimator.horizontal_valid)
    assert lost_s == pytest.approx(5.0, abs=0.1)
    assert hovering.status.flags == 831
    assert lost_s + hovering.run(5.0, lambda: hovering.status.flags == 165) == pytest.approx(7.0, abs=0.1)
    assert hovering.estimator.vertical_valid


def test_vision_that_is_back_counts_after_a_second(hovering):
    seen, hovering.sees = hovering.sees, None
    hovering.run(12.0)
    hovering.sees = seen
    hovering.move_to(3.0, -2.0, 0.5)
    back_s = hovering.run(3.0, lambda: hovering.estimator.horizontal_valid)
    assert back_s == pytest.approx(1.05, abs=0.15)
    assert hovering.position == pytest.approx([3.0, -2.0, 0.5], abs=0.2)


def test_a_jump_of_half_a_metre_is_followed_within_a_second(hovering):
    hovering.move_to(0.5, 0.0, 0.0)
    assert hovering.run(1.0, lambda: hovering.position[0] > 0.5)
    hovering.run(8.0)
    assert hovering.position[0] == pytest.approx(0.5, abs=0.05)


def test_a_jump_of_two_metres_is_rejected_for_some_seconds(hovering):
    hovering.move_to(2.0, 0.0, 0.0)
    hovering.run(0.2)
    assert hovering.status.horizontal_position_ratio == pytest.approx(3.5, abs=0.5)
    accepted_s = hovering.run(6.0, lambda: hovering.status.horizontal_position_ratio < 1.0)
    assert accepted_s == pytest.approx(3.5, abs=0.5)
    hovering.run(8.0)
    assert hovering.position[0] == pytest.approx(2.0, abs=0.1)
    assert hovering.estimator.horizontal_valid


def test_a_jump_of_ten_metres_costs_the_position_and_resets_it_after_7_s(hovering):
    hovering.move_to(10.0, 0.0, 0.0)
    resets = hovering.status.resets
    assert hovering.run(6.0, lambda: not hovering.estimator.horizontal_valid) == pytest.approx(5.0, abs=0.1)
    assert hovering.status.resets == resets
    hovering.run(2.2)
    assert hovering.status.resets == resets + 1
    assert hovering.position[0] == pytest.approx(10.0, abs=0.2)
    assert hovering.run(2.0, lambda: hovering.estimator.horizontal_valid)


def test_a_position_of_nan_is_taken_for_zero_as_in_px4(hovering):
    hovering.move_to(1.0, 1.0, 0.0)
    hovering.run(8.0)
    hovering.move_to(NAN, NAN, NAN)
    hovering.run(0.2)
    assert hovering.status.horizontal_position_ratio > 1.0
    hovering.move_to(1.0, 1.0, 0.0)
    hovering.run(4.0)
    assert hovering.position[:2] == pytest.approx([1.0, 1.0], abs=0.2)


@pytest.mark.parametrize(
    "attitude", [None, (NAN,) * 4, (0.0,) * 4, (5.0, 0.0, 0.0, 0.0), (NAN, 0.0, 0.0, 1.0)]
)
def test_a_quaternion_that_is_none_is_no_turn(hovering, attitude):
    hovering.sees = replace(hovering.sees, attitude=attitude)
    hovering.run(2.0)
    assert hovering.estimator.estimate["yaw"][0] == pytest.approx(0.0, abs=0.02)


def test_a_heading_that_jumps_in_the_air_is_rejected(hovering):
    hovering.sees = replace(hovering.sees, attitude=(math.cos(0.25), 0.0, 0.0, math.sin(0.25)))
    hovering.run(1.0)
    assert hovering.status.magnetometer_ratio > 1.0
    assert hovering.estimator.estimate["yaw"][0] == pytest.approx(0.0, abs=0.05)
    assert hovering.estimator.horizontal_valid


@pytest.mark.parametrize("late_us", [-3_600_000_000, 400_000])
def test_samples_from_the_future_or_older_than_the_buffer_do_not_count(hovering, late_us):
    offer = hovering.estimator.offer_external_vision
    hovering.estimator.offer_external_vision = lambda s: offer(
        replace(s, time_us=max(s.time_us - late_us, 0))
    )
    assert hovering.run(8.0, lambda: not hovering.estimator.horizontal_valid) == pytest.approx(5.0, abs=0.1)


def test_variances_count_when_they_are_greater_than_the_parameters(hovering):
    innovation_m = 0.4
    for deviation_m, ratio in (
        (0.001, innovation_m / 0.5),
        (0.8, innovation_m / 4.0),
        (NAN, innovation_m / 0.5),
    ):
        bench = Bench()
        bench.run(10.0)
        bench.sees = replace(bench.sees, position_variance_m2=(deviation_m**2,) * 3)
        bench.move_to(innovation_m, 0.0, 0.0)
        bench.run(2.0, lambda b=bench: b.status.horizontal_position_ratio > 0.05)
        assert bench.status.horizontal_position_ratio == pytest.approx(ratio, rel=0.25)


@pytest.mark.parametrize("rate_hz", [1.0, 2.0, 5.0, 1000.0])
def test_any_rate_holds_the_position(hovering, rate_hz):
    hovering.period_us = round(1e6 / rate_hz)
    lost_s = hovering.run(10.0, lambda: not hovering.estimator.horizontal_valid)
    assert lost_s is None
    assert np.abs(hovering.position).max() < 0.1


def test_velocities_in_the_body_are_turned(hovering):
    bench = Bench(EKF2_AID_MASK=256, SYS_HAS_MAG=1, EKF2_HGT_MODE=0)
    bench.sees = ExternalVision(0, velocity_m_s=(0.3, 0.0, 0.0), velocity_in_body=True)
    bench.run(12.0)  # the magnetometer says: the nose points east
    assert bench.estimator.estimate["velocity"][0][:2] == pytest.approx([0.0, 0.3], abs=0.05)
    assert bench.status.flags & 2


def test_an_imu_that_drops_out_stops_the_estimate_until_it_is_back(hovering):
    at = hovering.position.copy()
    broken = AT_REST._replace(specific_force_body_m_s2=(NAN, NAN, NAN))
    for _ in range(50):
        hovering.time_us += STEP_US
        hovering.estimator.update(broken._replace(time_us=hovering.time_us), 1e-6 * STEP_US, True)
    assert hovering.position.tolist() == at.tolist()
    hovering.run(2.0)
    assert hovering.position == pytest.approx(at, abs=0.1)
    assert hovering.estimator.horizontal_valid


def ranges(bench, distance_m, **also):
    """Offer a distance at 25 Hz from now on."""
    bench.period_us = 40_000
    offer = bench.estimator.offer_external_vision

    def both(sample):
        offer(sample)
        bench.estimator.offer_range(RangeSample(sample.time_us, distance_m, 0.1, 10.0, **also))

    bench.estimator.offer_external_vision = both


def test_a_range_finder_gives_the_height_over_ground():
    bench = Bench(EKF2_HGT_MODE=2)
    bench.run(6.0)
    ranges(bench, 1.5)
    bench.run(4.0)
    assert bench.status.height_over_ground_m == pytest.approx(1.5, abs=0.05)
    assert bench.status.flags == 895
    assert bench.status.vertical_position_ratio < 1.0


@pytest.mark.table(
    ("distance_m", "quality"), [(0.05, -1), (12.0, -1), (NAN, -1), (math.inf, -1), (-1.0, -1), (2.0, 0)]
)
def test_a_distance_that_is_none_leaves_the_height_to_the_barometer(distance_m, quality):
    bench = Bench(EKF2_HGT_MODE=2)
    bench.run(6.0)
    ranges(bench, distance_m, quality=quality)
    bench.run(8.0)
    assert math.isnan(bench.status.height_over_ground_m)
    assert abs(bench.position[2]) < 0.3
    assert bench.status.flags == 831


wild = st.one_of(st.sampled_from([NAN, math.inf, -math.inf, 0.0, 3e38, -3e38]), st.floats(-1e3, 1e3))
threes = st.one_of(st.none(), st.tuples(wild, wild, wild))
visions = st.builds(
    ExternalVision,
    time_us=st.integers(0, 2 * 10**7),
    position_m=threes,
    velocity_m_s=threes,
    attitude=st.one_of(st.none(), st.tuples(wild, wild, wild, wild)),
    position_variance_m2=st.tuples(wild, wild, wild),
    velocity_variance_m2_s2=st.tuples(wild, wild, wild),
    yaw_variance_rad2=wild,
    velocity_in_body=st.booleans(),
)
distances = st.builds(RangeSample, st.integers(0, 2 * 10**7), wild, wild, wild, st.integers(-1, 100))


@pytest.fixture(scope="module")
def everything():
    """An estimator that takes all that vision and a range finder may say."""
    bench = Bench(EKF2_AID_MASK=8 + 16 + 256, EKF2_HGT_MODE=2)
    bench.sees = replace(bench.sees, velocity_m_s=(0.0, 0.0, 0.0))
    bench.run(10.0)
    assert bench.estimator.horizontal_valid
    bench.sees = None
    return bench


@given(st.lists(st.one_of(visions, distances), min_size=1, max_size=8), st.booleans())
def test_whatever_arrives_the_estimate_stays_a_number(everything, arriving, late):
    bench = copy.deepcopy(everything)
    if late:
        bench.run(6.9)  # just before what arrives next is reset to
    for sample in arriving:
        sample = replace(sample, time_us=bench.time_us + sample.time_us % 40_000)
        if isinstance(sample, ExternalVision):
            bench.estimator.offer_external_vision(sample)
        else:
            bench.estimator.offer_range(sample)
        bench.run(0.1)
    assert np.isfinite(bench.estimator.estimate.view(np.float64)).all()
    assert np.isfinite(bench.estimator.filter.covariance).all()
    assert bench.status.flags & 1


def test_parameters_count_from_the_next_power_on():
    bench = Bench()
    parameters = bench.estimator._parameters
    parameters.set("EKF2_AID_MASK", 1)
    bench.run(10.0)
    assert bench.estimator.horizontal_valid
    bench.estimator.reset()
    assert not bench.estimator.settings.uses_vision_position


def test_reset_repeats_the_same_flight():
    bench, ends = Bench(), []
    for _ in range(2):
        bench.estimator.reset()
        bench.time_us = bench._due_us = 0
        bench.run(3.0)
        ends.append(bench.estimator.estimate.copy())
    assert ends[0] == ends[1]
