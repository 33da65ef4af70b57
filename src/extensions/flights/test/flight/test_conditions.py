"""Worse conditions in the closed loop: each as large as asked, repeated with its seed, off by default."""

import numpy as np
import pytest

from flights.flight.closed_loop import ClosedLoop
from flights.flight.conditions import Conditions, Delivery
from flights.flight.parameters import ClosedLoopParameters
from simulation_tools.geometry import Pose
from simulation_tools.publisher import PublisherParameters
from simulation_tools.sensors.odometry import OdometrySample
from simulation_tools.simulation import SimulationParameters
from simulation_tools.vehicle.uav import load_uav

AT_REST = (0.0, 0.0, 0.0)


def sample(t_s):
    return OdometrySample(Pose((t_s, 0.0, 0.0)), AT_REST, AT_REST)


def test_the_defaults_change_nothing():
    simulation = SimulationParameters("a.world")
    assert Conditions().applied_to(simulation) == simulation
    assert Conditions().hover_of(PublisherParameters()) == PublisherParameters()
    delivery = Delivery(Conditions(), seed=1)
    assert all(delivery.scan_arrives() for _ in range(1000))
    assert delivery.odometry(0.3, sample(0.3)) == (0.0, sample(0.3))


def test_the_lidars_noise_is_multiplied():
    """An UST's standard deviation is a third of its accuracy, 0.04 m (thesis, table 8.2)."""
    given = Conditions(lidar_noise_factor=3.0).applied_to(SimulationParameters("a.world"))
    noise = load_uav("iris", "ust", noise_factor=given.lidar_noise_factor).lidar.sensor.noise
    assert noise.stddev == pytest.approx(0.04, abs=1e-3)


def test_scans_are_lost_at_the_rate_asked_for_by_the_seed():
    def arrived(seed):
        delivery = Delivery(Conditions(scan_loss=0.2), seed)
        return [delivery.scan_arrives() for _ in range(10_000)]

    assert np.mean(arrived(1)) == pytest.approx(0.8, abs=0.016)  # four standard deviations
    assert arrived(1) == arrived(1) != arrived(2)


def test_odometry_is_as_late_as_asked_for():
    delivery = Delivery(Conditions(odometry_delay_s=0.15), seed=1)
    for k in range(50):
        age_s, newest = delivery.odometry(0.01 * k, sample(0.01 * k))
        assert age_s == pytest.approx(min(0.15, 0.01 * k))
        assert newest.pose.position_m[0] == pytest.approx(max(0.0, 0.01 * k - 0.15))


def test_the_wind_has_its_mean_and_a_direction_of_the_seed():
    def wind(seed):
        (stream,) = Conditions(wind_m_s=5.0).applied_to(SimulationParameters("a.world", seed=seed)).wind
        return stream

    assert wind(1) == wind(1)
    assert wind(1).direction != wind(2).direction
    assert wind(1).mean_m_s == 5.0
    assert wind(1).direction[2] == 0.0


class Listener:
    """Steers as another does, and writes down what it was told."""

    wants_cloud = True
    wants_motion = True

    def __init__(self, inner):
        self.inner, self.told, self.wants_single_beams = inner, [], False
        self.parameters, self.commit_s = inner.parameters, inner.commit_s

    def on_next_scan(self, gap_s, turn_rad):
        pass

    def take_ranges(self, rangings):
        pass

    def steer(self, scan, v_ref_xy, v_uav_xy, motion, cloud):
        self.told.append((scan, motion, cloud))
        return self.inner.steer(scan, v_ref_xy, v_uav_xy, motion)


@pytest.mark.flight
def test_the_loop_hands_on_a_late_odometrys_age_and_a_cloud(worlds_folder):
    from flights.baselines import NoAvoidance

    simulation = SimulationParameters(str(worlds_folder / "forest.world"), lidar="puck")
    conditions = Conditions(scan_loss=0.5, odometry_delay_s=0.15)
    listener = Listener(NoAvoidance())
    with ClosedLoop(ClosedLoopParameters(simulation, conditions=conditions), listener) as loop:
        loop.run(until=lambda loop: loop.time_s >= 2.0)
    assert 10 < len(listener.told) < 30  # of 41 scans at 20 Hz
    scan, motion, cloud = listener.told[-1]
    assert motion.age_s == pytest.approx(0.15, abs=0.011)
    assert cloud.elevation_rad == pytest.approx(np.radians((-15.0, 15.0)))
    assert cloud.range_max_m == 100.0
    # The ring nearest to the horizontal measures what the flat scan measures: both are noisy
    elevations = np.arctan2(cloud.points_m[:, 2], np.hypot(*cloud.points_m[:, :2].T))
    level = cloud.points_m[np.abs(elevations) < np.radians(1.1)]
    nearest = np.nanmin(np.where(np.isfinite(scan.ranges), scan.ranges, np.nan))
    assert np.linalg.norm(level, axis=1).min() == pytest.approx(nearest, abs=0.15)


@pytest.mark.flight
def test_the_loop_hands_the_algorithm_its_range_finders(worlds_folder):
    from flights.baselines import NoAvoidance

    finders = ("range_finder", "range_finder_up")
    simulation = SimulationParameters(str(worlds_folder / "empty.world"), sensors=finders)
    listener = Listener(NoAvoidance())
    listener.take_ranges = listener.told.append
    with ClosedLoop(ClosedLoopParameters(simulation, range_finders=True), listener) as loop:
        loop.run(until=lambda loop: loop.time_s >= 0.2)
    down, up = sorted(listener.told[0], key=lambda ranging: ranging.direction[2])
    assert down.range_m == pytest.approx(0.12 - 0.06, abs=0.01)  # so far below an Iris's middle
    assert up.range_m == np.inf


@pytest.mark.flight
def test_the_same_seed_gives_the_same_flight_in_the_worst_conditions(worlds_folder):
    def path(seed):
        simulation = SimulationParameters(str(worlds_folder / "empty.world"), seed=seed)
        conditions = Conditions(3.0, 0.2, 0.15, 5.0)
        with ClosedLoop(ClosedLoopParameters(simulation, conditions=conditions)) as loop:
            loop.run(until=lambda loop: loop.time_s >= 4.0)
            return loop.log.truth.rows

    assert path(1) == path(1) != path(2)


@pytest.mark.flight
def test_nobody_measures_a_cloud_that_is_not_wanted(worlds_folder):
    simulation = SimulationParameters(str(worlds_folder / "empty.world"), lidar="puck")
    with ClosedLoop(ClosedLoopParameters(simulation)) as loop:
        (puck,) = loop.simulation.payload
        puck.read = lambda: pytest.fail("a cloud was measured")
        loop.run(until=lambda loop: loop.time_s >= 0.3)
