"""Wind: its statistics in closed form, PX4's plugin, and what it does to a UAV in hover."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from simulation_tools.geometry import Pose
from simulation_tools.px4.modes import Mode
from simulation_tools.px4.setpoint import Setpoint
from simulation_tools.sdf.parser import load_world
from simulation_tools.simulation import Simulation, SimulationParameters
from simulation_tools.vehicle.wind import AirStream, Wind, WindError, streams_of

EMPTY = Path(__file__).resolve().parents[2] / "worlds" / "empty.world"
DT = 0.1


def blown(stream, count, seed=1, dt_s=DT):
    wind = Wind([stream], np.random.default_rng(seed))
    return np.array([wind.step(k * dt_s, dt_s) for k in range(count)])


def test_its_mean_deviation_and_memory_are_those_asked_for():
    """A Gauss-Markov process correlates over a time t by exp(-t / correlation_s)."""
    stream = AirStream(8.0, 0.8, direction=(0.0, 2.0, 0.0), direction_deviation=0.1, correlation_s=0.5)
    air = blown(stream, 40_000)
    # 4,000 s hold 4,000 independent values: means to 1/60 of a deviation, deviations to 1/90
    assert air.mean(axis=0) == pytest.approx((0.0, 8.0, 0.0), abs=0.06)
    across_m_s = 0.1 * math.hypot(8.0, 0.8)
    along_m_s = math.hypot(0.8, across_m_s)
    assert air.std(axis=0) == pytest.approx((across_m_s, along_m_s, across_m_s), rel=0.05)
    x = air[:, 0]
    assert np.corrcoef(x[:-3], x[3:])[0, 1] == pytest.approx(math.exp(-3 * DT / 0.5), abs=0.03)


def test_a_gust_blows_in_its_time_and_never_above_its_maximum():
    air = blown(AirStream(9.0, 5.0, max_m_s=10.0, start_s=2.0, end_s=4.0), 100)
    blows = np.linalg.norm(air, axis=1) > 0.0
    assert np.flatnonzero(blows).tolist() == list(range(20, 40))
    assert air[:, 0].max() == 10.0
    assert air[:, 0].min() >= 0.0


def test_the_same_seed_gives_the_same_wind():
    gusty = AirStream.gusty(5.0, 0.3)
    assert np.array_equal(blown(gusty, 50), blown(gusty, 50))
    assert not np.array_equal(blown(gusty, 50), blown(gusty, 50, seed=2))


PLUGIN = """<sdf version="1.6"><world name="w">
<plugin name="wind_plugin" filename="libgazebo_wind_plugin.so">
  <frameId>base_link</frameId><robotNamespace/><xyzOffset>1 0 0</xyzOffset>
  <windVelocityMean>{mean}</windVelocityMean><windVelocityMax>20.0</windVelocityMax>
  <windVelocityVariance>0.25</windVelocityVariance><windDirectionMean>0 1 0</windDirectionMean>
  <windDirectionVariance>0.04</windDirectionVariance>
  <windGustStart>5</windGustStart><windGustDuration>2</windGustDuration>
  <windGustVelocityMean>3</windGustVelocityMean><windGustDirectionMean>{gust}</windGustDirectionMean>
  <windPubTopic>world_wind</windPubTopic>
</plugin></world></sdf>"""


def windy(tmp_path, mean="5", gust="1 0 0"):
    path = tmp_path / "windy.world"
    path.write_text(PLUGIN.format(mean=mean, gust=gust))
    return load_world(path, [])


def test_px4s_wind_plugin_is_read(tmp_path):
    world = windy(tmp_path)
    assert world.warnings == ()
    wind, gust = streams_of(world)
    assert wind == AirStream(5.0, 0.5, 20.0, (0.0, 1.0, 0.0), 0.2)
    assert gust == AirStream(3.0, 0.0, 10.0, (1.0, 0.0, 0.0), 0.0, 5.0, 7.0)
    assert streams_of(load_world(EMPTY)) == ()


@pytest.mark.table(
    ("changes", "saying"),
    [
        ({"mean": "strong"}, "<windVelocityMean> must be a number, got 'strong'"),
        ({"mean": "-1"}, "The wind's mean_m_s must be at least 0, not -1.0"),
        ({"gust": "0 0 0"}, "needs a direction"),
        ({"gust": "0 1"}, "<windGustDirectionMean> must be three numbers"),
    ],
)
def test_a_bad_wind_plugin_is_refused_with_its_place(tmp_path, changes, saying):
    with pytest.raises(WindError) as error:
        streams_of(windy(tmp_path, **changes))
    assert str(error.value).startswith(f"{tmp_path}/windy.world:2: ")
    assert saying in str(error.value)


def test_the_wind_pushes_what_has_drag_and_repeats_after_a_reset():
    """A quadrotor in free fall drifts with the wind, because its hull has drag."""
    given = SimulationParameters(
        str(EMPTY),
        model="reference_quad",
        lidar=None,
        spawn_pose=Pose((0.0, 0.0, 50.0)),
        wind=(AirStream.gusty(8.0, 0.5 * math.pi),),
    )
    simulation = Simulation(given)

    def drift():
        for _ in range(100):
            simulation.step()
        return simulation.world.get_state("reference_quad").linear_velocity_m_s

    try:
        first = drift()
        assert first[1] > 5.0 * abs(first[0])
        simulation.reset()
        assert drift() == first
    finally:
        simulation.close()


@pytest.mark.flight
def test_in_a_steady_wind_the_uav_leans_by_drag_over_weight():
    """Closed form: tan(lean) = 4 c w v / (m g), with c the SDF's rotorDragCoefficient and w of a rotor."""
    parameters = SimulationParameters(str(EMPTY), wind=(AirStream(5.0),))
    simulation = Simulation(parameters)
    leans, places = [], []
    try:
        for k in range(5000):
            simulation.px4.offer_setpoint(Setpoint.hold((0.0, 0.0, 2.0)))
            simulation.px4.request_mode(Mode.OFFBOARD)
            simulation.px4.request_arm()
            simulation.step()
            if k >= 4000:
                pose = simulation.world.get_state("iris").pose
                leans.append(pose.rpy_rad[1])
                places.append(pose.position_m)
        speeds = simulation.airframe.rotor_states
        drag_n = 1.75e-4 * speeds.sum() * 5.0
        weight_n = simulation.world.mass_kg("iris") * 9.80665
    finally:
        simulation.close()
    assert np.mean(leans) == pytest.approx(-math.atan(drag_n / weight_n), rel=0.03)
    assert math.degrees(-np.mean(leans)) > 5.0
    assert np.abs(np.mean(places, axis=0)[:2]).max() < 0.1


def test_px4s_wind_grows_along_its_ramp(tmp_path):
    """As gazebo_wind_plugin does: the vector times (t - start) / duration, from 0 to 1."""
    path = tmp_path / "ramp.world"
    path.write_text(
        '<sdf version="1.6"><world name="w"><plugin name="p" filename="libgazebo_wind_plugin.so">'
        "<windRampStart>10</windRampStart><windChangeRampDuration>4</windChangeRampDuration>"
        "<windRampWindVectorComponents>3 -4 1</windRampWindVectorComponents></plugin></world></sdf>"
    )
    world = load_world(path, [])
    assert world.warnings == ()
    wind = Wind(streams_of(world), np.random.default_rng(1))
    for time_s, part in ((9.99, 0.0), (11.0, 0.25), (14.0, 1.0), (100.0, 1.0)):
        np.testing.assert_allclose(wind.step(time_s, DT), part * np.array((3, -4, 1)), atol=1e-12)


def test_a_parameter_of_the_wind_that_nobody_reads_is_named(tmp_path):
    path = tmp_path / "w.world"
    path.write_text(
        '<sdf version="1.6"><world name="w"><plugin name="p" filename="libgazebo_wind_plugin.so">'
        "<robotNamespace/><windShear>3</windShear></plugin></world></sdf>"
    )
    (warning,) = load_world(path, []).warnings
    assert warning.endswith("without effect: <world/plugin/windShear> (line 1).")
