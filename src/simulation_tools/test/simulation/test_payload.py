"""The further sensors on a UAV, against closed form: range, cloud, pictures, pressure; all opt-in."""

from __future__ import annotations

import math
import shutil
from pathlib import Path

import numpy as np
import pytest

from simulation_tools.geometry import Pose
from simulation_tools.sdf.frames import OPTICAL
from simulation_tools.sdf.parser import load_model, parse_model
from simulation_tools.sensors.barometer import pressure_pa
from simulation_tools.simulation import Simulation, SimulationParameters, sensor_kinds
from simulation_tools.simulation.payload import PayloadError, further_sensors, unsimulated
from simulation_tools.vehicle.uav import load_uav
from simulation_tools.world.world import BodyState

EMPTY = str(Path(__file__).resolve().parents[2] / "worlds" / "empty.world")
MODELS = Path(__file__).resolve().parents[2] / "models"
FOUR = ("range_finder", "camera", "depth_camera", "barometer")


@pytest.fixture
def make():
    """Returns a function that makes a simulation with further sensors -> (simulation, sensors by name)."""
    made = []

    def build(sensors=FOUR, **changes):
        made.append(Simulation(SimulationParameters(EMPTY, sensors=tuple(sensors), **changes)))
        return made[-1], {sensor.name: sensor for sensor in made[-1].payload}

    yield build
    for simulation in made:
        simulation.close()


def put(simulation, pose):
    """Puts the UAV somewhere, at rest."""
    simulation.world.set_state("iris", BodyState(pose))
    simulation.models_moved()


def spawn(simulation, name, geometry, pose, colour="1 0 0 1"):
    text = (
        f'<sdf version="1.6"><model name="{name}"><static>1</static><link name="l">'
        f'<collision name="c"><geometry>{geometry}</geometry></collision><visual name="v">'
        f"<geometry>{geometry}</geometry><material><diffuse>{colour}</diffuse></material></visual>"
        "</link></model></sdf>"
    )
    simulation.world.spawn(parse_model(text, name, []), name, pose)


def test_a_uav_without_further_sensors_has_none_and_flies_as_ever(make):
    plain, sensors = make(sensors=())
    assert sensors == {}
    assert plain.step().payload == ()
    laden, _ = make(sensors=("barometer",))
    scans = []
    for simulation in (plain, laden):
        simulation.reset()
        put(simulation, Pose((0.0, 0.0, 3.0)))
        spawn(simulation, "wall", "<box><size>1 9 9</size></box>", Pose((4.0, 0.0, 3.0)))
        scans.append(simulation.sense().scan)
    np.testing.assert_array_equal(*scans)  # the lidar's noise is its own


def test_each_fires_at_its_rate_and_starts_anew_after_a_reset(make):
    simulation, _ = make()
    for _ in range(2):
        outputs = [simulation.sense(), *(simulation.step() for _ in range(499))]  # 2 s less a step
        counts = {name: sum(name in {s.name for s in out.payload} for out in outputs) for name in FOUR}
        assert counts == {"range_finder": 40, "camera": 30, "depth_camera": 30, "barometer": 40}
        simulation.reset()


@pytest.mark.parametrize("lean", [0.0, 0.2])
def test_the_range_finder_measures_the_nearest_of_its_bundle(make, lean):
    simulation, sensors = make(sensors=("range_finder",))
    put(simulation, Pose.from_xyz_rpy(0.0, 0.0, 5.0, lean, 0.0, 0.7))
    # It sits 0.055 m under the origin; of its beams the one that leans least meets the floor first.
    height = 5.0 - 0.055 * math.cos(lean)
    expected = height / math.cos(max(lean - math.radians(1.0), 0.0))
    ranges = [sensors["range_finder"].read() for _ in range(200)]
    assert np.mean(ranges) == pytest.approx(expected, abs=0.003)
    assert np.std(ranges) == pytest.approx(0.01, rel=0.3)


def test_out_of_its_reach_the_range_finder_says_so(make):
    simulation, sensors = make(sensors=("range_finder",))
    put(simulation, Pose((0.0, 0.0, 45.0)))
    assert sensors["range_finder"].read() == math.inf
    put(simulation, Pose((0.0, 0.0, 0.09)))
    assert sensors["range_finder"].read() == -math.inf
    put(simulation, Pose.from_xyz_rpy(0.0, 0.0, 5.0, math.pi))
    assert sensors["range_finder"].read() == math.inf


@pytest.mark.parametrize(("lidar", "channels", "low", "high"), [("puck", 16, -15, 15), ("m8", 8, -17, 3)])
def test_a_cloud_lies_on_what_its_channels_meet(make, lidar, channels, low, high):
    simulation, sensors = make(sensors=(), lidar=lidar)
    put(simulation, Pose.from_xyz_rpy(1.0, 2.0, 5.0, 0.1, -0.2, 0.5))
    spawn(simulation, "ball", "<sphere><radius>2</radius></sphere>", Pose((7.0, 3.0, 5.0)))
    cloud = sensors["cloud"].read()
    assert len(np.unique(cloud.rings)) > channels // 2  # those that look up meet nothing
    assert cloud.rings.max() < channels
    elevations = np.degrees(np.arcsin(cloud.points_m[:, 2] / np.linalg.norm(cloud.points_m, axis=1)))
    expected = low + cloud.rings * (high - low) / (channels - 1)
    np.testing.assert_allclose(elevations, expected, atol=1e-3)
    points = (simulation._body.pose @ sensors["cloud"].mount.pose).transform(cloud.points_m)
    on_ball = abs(np.linalg.norm(points - (7.0, 3.0, 5.0), axis=1) - 2.0) < 0.09
    on_floor = abs(points[:, 2]) < 0.09
    assert (on_ball | on_floor).all()
    assert on_ball.sum() > 500
    assert on_floor.sum() > 2000


def test_the_flat_scan_of_a_puck_is_the_same_as_ever(make):
    simulation, _ = make(sensors=(), lidar="puck")
    assert simulation.lidar.beams == 1800
    np.testing.assert_allclose(simulation.lidar.directions[:, 2], 0.0, atol=1e-9)


def test_the_optical_frame_has_x_to_the_right_y_down_and_z_ahead():
    np.testing.assert_allclose(OPTICAL.rotation @ np.eye(3), [[0, 0, 1], [-1, 0, 0], [0, -1, 0]], atol=1e-12)


def pixels_of(camera, points):
    """Where a pinhole sees points given in its optical frame; depth in the last column."""
    u = camera.focal_px * points[:, 0] / points[:, 2] + camera.centre_px[0]
    v = camera.focal_px * points[:, 1] / points[:, 2] + camera.centre_px[1]
    return np.column_stack((u, v, points[:, 2]))


def test_a_depth_camera_sees_distances_along_its_axis(make):
    simulation, sensors = make(sensors=("depth_camera",))
    camera = sensors["depth_camera"].device
    pose = Pose.from_xyz_rpy(0.0, 0.0, 2.0, 0.1, 0.15, 0.3)
    put(simulation, pose)
    spawn(simulation, "wall", "<box><size>2 40 40</size></box>", Pose((7.0, 0.0, 0.0)))
    depth = sensors["depth_camera"].read()
    assert depth.shape == (240, 320)
    assert depth.dtype == np.float32
    # Through the middle of each pixel goes a ray; it meets the wall at x = 6 or the floor at z = 0.
    u, v = np.meshgrid(np.arange(320), np.arange(240))
    rays = np.stack(
        (
            (u - camera.centre_px[0]) / camera.focal_px,
            (v - camera.centre_px[1]) / camera.focal_px,
            np.ones(u.shape),
        ),
        axis=-1,
    )
    eye = pose @ sensors["depth_camera"].mount.pose @ OPTICAL
    ahead = rays @ eye.rotation.T
    x, _, z = eye.position_m
    with np.errstate(divide="ignore"):
        to_wall, to_floor = (6.0 - x) / ahead[..., 0], -z / ahead[..., 2]
    expected = np.minimum(to_wall, np.where(to_floor > 0.0, to_floor, np.inf))
    inside = abs(to_wall - to_floor) > 0.1  # not on the edge between the two
    error = (depth - expected)[inside]
    assert abs(np.median(error)) < 1e-3
    assert np.percentile(abs(error), 99.5) < 5 * 0.005
    assert np.std(error[abs(error) < 0.03]) == pytest.approx(0.005, rel=0.1)  # the SDF's noise
    put(simulation, Pose.from_xyz_rpy(0.0, 0.0, 2.0, 0.0, -1.2))
    assert np.isinf(sensors["depth_camera"].read()[0]).all()  # the sky


def test_a_camera_sees_coloured_balls_where_a_pinhole_would(make):
    simulation, sensors = make(sensors=("camera",))
    pose = Pose.from_xyz_rpy(1.0, -2.0, 3.0, 0.05, -0.1, 0.4)
    put(simulation, pose)
    eye = pose @ sensors["camera"].mount.pose @ OPTICAL
    optical = np.array([(-1.2, -0.8, 4.0), (1.5, 0.5, 5.0), (0.0, 0.0, 3.0)])
    colours = {"0 0 1 1": 2, "0 1 0 1": 1, "1 0 0 1": 0}
    for number, (colour, place) in enumerate(zip(colours, eye.transform(optical))):
        ball = "<sphere><radius>.15</radius></sphere>"
        spawn(simulation, f"ball_{number}", ball, Pose(tuple(place)), colour)
    picture = sensors["camera"].read().astype(int)
    assert picture.shape == (240, 320, 3)
    for channel, pixel in zip(colours.values(), pixels_of(sensors["camera"].device, optical)):
        others = [c for c in range(3) if c != channel]
        rows, columns = np.nonzero(picture[:, :, channel] > picture[:, :, others].max(axis=2) + 60)
        assert len(rows) > 50
        np.testing.assert_allclose((columns.mean(), rows.mean()), pixel[:2], atol=0.7)


def test_the_same_seed_gives_the_same_picture(make):
    pictures = [make(sensors=("camera",), seed=seed)[1]["camera"].read() for seed in (3, 3, 4)]
    np.testing.assert_array_equal(pictures[0], pictures[1])
    assert (pictures[0] != pictures[2]).any()


def test_a_barometer_tells_height(make):
    simulation, sensors = make(sensors=("barometer",))
    put(simulation, Pose((0.0, 0.0, 100.0)))
    readings = [sensors["barometer"].read() for _ in range(400)]
    assert np.mean(readings) == pytest.approx(pressure_pa(100.02), abs=0.3)
    assert np.std(readings) == pytest.approx(1.5, rel=0.15)


def test_a_sensor_on_the_gimbal_turns_with_it(make):
    simulation, sensors = make(sensors=(), lidar="puck", level_lidar=True)
    lean = 0.3
    put(simulation, Pose.from_xyz_rpy(0.0, 0.0, 2.0, 0.0, lean))
    for _ in range(50):
        simulation.gimbal.step(simulation._body.pose.orientation_xyzw, 0.004)
    cloud = sensors["cloud"].read()
    floor = cloud.points_m[cloud.points_m[:, 2] < -1.0]
    assert len(floor) > 5000
    assert np.ptp(floor[:, 2]) < 0.1  # level: the floor is one height, whichever way a channel looks


def test_two_sensors_of_one_name_are_refused(tmp_path):
    twin = (
        (Path(EMPTY).parents[1] / "models/barometer/model.sdf").read_text().replace("barometer_link", "other")
    )
    (tmp_path / "twin.sdf").write_text(twin)
    with pytest.raises(PayloadError, match='Two sensors are called "barometer"'):
        further_sensors(load_uav("iris", sensors=("barometer", str(tmp_path / "twin.sdf"))))


def test_a_second_flat_lidar_is_told_of(tmp_path):
    lidar = (MODELS / "lidar_urg/model.sdf").read_text()
    (tmp_path / "second.sdf").write_text(lidar.replace('"hokuyo"', '"second"').replace('"lidar"', '"spare"'))
    uav = load_uav("iris", "ust", sensors=(str(tmp_path / "second.sdf"),))
    (sentence,) = unsimulated(uav)
    assert '"spare" is not simulated' in sentence
    assert unsimulated(load_uav("iris", "puck", sensors=FOUR)) == ()


def test_a_range_finder_is_no_lidar():
    uav = load_uav("iris", "ust", sensors=("range_finder",))
    assert uav.lidar.link == "hokuyo"
    assert uav.model.link("range_finder_link")
    bare = load_uav("iris", None, sensors=("range_finder",))
    assert bare.lidar is None


def test_all_who_ask_at_one_instant_share_a_reading(make):
    simulation, sensors = make(sensors=("range_finder",))
    finder = sensors["range_finder"]
    first = finder.shared()
    assert finder.shared() == first
    assert finder.read() != first  # noise
    while not any(sensor is finder for sensor in simulation.step().payload):
        pass
    assert finder.shared() != first


@pytest.mark.table(("kind", "range_m"), [("ray", 4.5), ("gpu_ray", 2.5)])
def test_a_gpu_ray_sees_what_is_drawn_and_a_ray_what_touches(tmp_path, kind, range_m):
    """A bush without a collision shape 2.5 m ahead, and an invisible wall 4.5 m ahead."""
    shape = "<geometry><box><size>1 9 9</size></box></geometry>"
    look = f'<link name="l"><visual name="v">{shape}</visual></link>'
    bush = f'<model name="bush"><static>1</static><pose>3 0 0 0 0 0</pose>{look}</model>'
    wall = bush.replace("bush", "wall").replace("visual", "collision").replace("3 0 0", "5 0 0", 1)
    path = tmp_path / "w.world"
    path.write_text(f'<sdf version="1.6"><world name="w">{bush}{wall}</world></sdf>')
    home = tmp_path / "lidar_own"
    shutil.copytree(MODELS / "lidar_ust", home)
    text = (home / "model.sdf").read_text().replace('type="ray"', f'type="{kind}"')
    (home / "model.sdf").write_text(text)
    simulation = Simulation(
        SimulationParameters(
            str(path), lidar="own", model_path=(tmp_path, MODELS), lidar_noise_factor=0.0, static_models=True
        )
    )
    try:
        scan = simulation.sense().scan
        assert scan[len(scan) // 2] == pytest.approx(range_m, abs=0.01)
        assert simulation.warnings == ()
    finally:
        simulation.close()


class Altimeter:
    """A sensor of one's own, known by its plugin; it is no part of this package."""

    def __init__(self, sensor, rng):
        self.pitch_m = float(rng.uniform(0.1, 0.2))

    def read(self, pose):
        return self.pitch_m * round(pose.position_m[2] / self.pitch_m)


def test_a_kind_of_ones_own_is_one_class_and_one_entry(make, monkeypatch, tmp_path):
    def is_one(sensor):
        return any(plugin.filename == "libmy_altimeter.so" for plugin in sensor.plugins)

    kind = sensor_kinds.SensorKind(is_one, Altimeter, lambda device, around, pose: device.read(pose))
    monkeypatch.setattr(sensor_kinds, "KINDS", (kind, *sensor_kinds.KINDS))
    model = tmp_path / "altimeter.sdf"
    text = (MODELS / "barometer/model.sdf").read_text().replace("barometer", "altimeter")
    model.write_text(
        text.replace("</sensor>", '<plugin name="altimeter" filename="libmy_altimeter.so"/></sensor>')
    )
    simulation, sensors = make(sensors=("barometer", str(model)))
    put(simulation, Pose((0.0, 0.0, 3.0)))
    device = sensors["altimeter"].device
    assert isinstance(device, Altimeter)
    height_m = 3.0 + 0.02  # that of the sensor's link
    assert sensors["altimeter"].read() == pytest.approx(height_m, abs=0.5 * device.pitch_m + 1e-9)
    assert sensors["barometer"].read() == pytest.approx(pressure_pa(height_m), abs=6 * 1.5)


@pytest.mark.table("model", [*FOUR, "range_finder_up", "lidar_puck", "lidar_utm", "inspection_camera"])
def test_a_shipped_sensor_is_of_one_kind_at_most(model):
    for link in load_model(f"model://{model}", [str(MODELS)]).links:
        for sensor in link.sensors:
            assert sum(kind.is_one(sensor) for kind in sensor_kinds.KINDS) <= 1, sensor.name
