"""Scans: REP-117, noise, resolution, tilt, own model; and a box and a cylinder against analytic geometry."""

from __future__ import annotations

import math

import numpy as np
import pytest

from simulation_tools.geometry import Pose
from simulation_tools.sdf.elements import Box, Cylinder, Noise, Plane, RaySensor, ScanAxis, World
from simulation_tools.sdf.frames import attach
from simulation_tools.sdf.parser import load_model, parse_model
from simulation_tools.sensors.lidar import Lidar, measured
from simulation_tools.world.rays import RayScene
from simulation_tools.world.shapes.meshes import SAGITTA_M, mesh_of
from simulation_tools.world.world import PhysicsWorld

HALF = math.radians(135.0)


def sensor(**changes):
    values = {
        "name": "lidar",
        "pose": Pose(),
        "update_rate_hz": 40.0,
        "horizontal": ScanAxis(1081, -HALF, HALF),
        "vertical": ScanAxis(1, 0.0, 0.0),
        "range_min_m": 0.06,
        "range_max_m": 10.0,
    }
    return RaySensor(**{**values, **changes})


def lidar(pose=None, seed=1, **changes):
    return Lidar(sensor(**changes), pose or Pose(), np.random.default_rng(seed))


def scene(*things):
    rays = RayScene()
    for number, (geometry, pose) in enumerate(things):
        rays.put(f"thing_{number}", mesh_of(geometry).transformed(pose))
    return rays


def room():
    return scene((Box((8.0, 6.0, 3.0)), Pose()))


def angles_of(device):
    return device.angle_min + device.angle_increment * np.arange(device.beams)


def test_the_scan_of_a_box_is_that_of_analytic_geometry():
    device = lidar()
    ranges = device.scan(room(), Pose.from_xyz_rpy(1.0, -0.5, 0.2, 0, 0, 0.3))
    angles = angles_of(device) + 0.3
    c, s = np.cos(angles), np.sin(angles)
    # From inside, along each axis to the wall that the beam heads for; the nearer one ends it.
    with np.errstate(divide="ignore"):
        to_x = np.where(c > 0, (4.0 - 1.0) / c, (-4.0 - 1.0) / c)
        to_y = np.where(s > 0, (3.0 + 0.5) / s, (-3.0 + 0.5) / s)
    assert ranges.dtype == np.float32
    np.testing.assert_allclose(ranges, np.minimum(to_x, to_y), atol=1e-5)


def test_the_scan_of_a_cylinder_is_analytic_geometry_within_its_facets():
    device = lidar()
    radius, distance = 0.3, 4.0
    ranges = device.scan(scene((Cylinder(radius, 2.0), Pose.from_xyz_rpy(distance, 0, 0))), Pose())
    angles = angles_of(device)
    miss = distance * np.sin(angles)
    hit = np.isfinite(ranges)
    np.testing.assert_array_equal(hit, (abs(miss) < radius) & (abs(angles) < 1.0))
    expected = distance * np.cos(angles[hit]) - np.sqrt(radius**2 - miss[hit] ** 2)
    cosine = np.sqrt(1 - (miss[hit] / radius) ** 2)
    assert (ranges[hit] - expected > -1e-5).all()
    assert (ranges[hit] - expected < 1.3 * SAGITTA_M / cosine + 1e-5).all()


def test_beams_go_counter_clockwise_and_the_first_looks_to_the_right():
    device = lidar(horizontal=ScanAxis(3, -math.pi / 2, math.pi / 2))
    walls = scene(
        (Box((0.1, 9, 9)), Pose.from_xyz_rpy(2.05, 0, 0)),
        (Box((9, 0.1, 9)), Pose.from_xyz_rpy(0, 3.05, 0)),
        (Box((9, 0.1, 9)), Pose.from_xyz_rpy(0, -1.05, 0)),
    )
    np.testing.assert_allclose(device.scan(walls, Pose()), (1.0, 2.0, 3.0), atol=1e-5)


def test_rep_117():
    device = lidar(range_min_m=0.5, range_max_m=3.0, horizontal=ScanAxis(3, -math.pi / 2, math.pi / 2))
    walls = scene(
        (Box((0.1, 9, 9)), Pose.from_xyz_rpy(2.05, 0, 0)),  # ahead at 2 m: a range
        (Box((9, 0.1, 9)), Pose.from_xyz_rpy(0, 3.15, 0)),  # left at 3.1 m: beyond
        (Box((9, 0.1, 9)), Pose.from_xyz_rpy(0, -0.45, 0)),  # right at 0.4 m: too close
    )
    np.testing.assert_allclose(device.scan(walls, Pose()), (-math.inf, 2.0, math.inf), atol=1e-5)
    assert np.isposinf(device.scan(RayScene(), Pose())).all()


def test_a_lidar_that_leans_sees_the_floor_where_trigonometry_says():
    # 2 m over the floor, nose down by 20 degrees: the beam ahead is 2 / sin(20 deg) long, those aside miss
    # it.
    pitch = math.radians(20.0)
    device = lidar(horizontal=ScanAxis(3, -math.pi / 2, math.pi / 2))
    ranges = device.scan(scene((Plane(), Pose())), Pose.from_xyz_rpy(0, 0, 2, 0, pitch, 0))
    assert ranges[1] == pytest.approx(2.0 / math.sin(pitch), abs=1e-4)
    assert np.isposinf(ranges[[0, 2]]).all()


def test_rays_leave_from_the_lidar_not_from_the_body():
    mount = Pose.from_xyz_rpy(0.2, 0.0, 0.1, 0, 0, math.pi / 2)
    device = lidar(mount, horizontal=ScanAxis(3, -math.pi / 2, math.pi / 2))
    ranges = device.scan(room(), Pose())
    # The lidar looks to the left of the body: right beam ahead (x = 4), middle left (y = 3), left behind (x =
    # -4).
    np.testing.assert_allclose(ranges, (3.8, 3.0, 4.2), atol=1e-5)


def test_noise_has_the_stated_mean_and_deviation_and_a_seed():
    noisy = lidar(noise=Noise(0.1, 0.02), range_resolution_m=0.0)
    still = Pose.from_xyz_rpy(1.0, -0.5, 0.2)
    exact = lidar().scan(room(), still)
    errors = np.array([noisy.scan(room(), still) - exact for _ in range(200)])
    # 216 200 samples: the mean is known to 0.02 / sqrt(n) = 4e-5, the deviation to 3e-5; five of each.
    assert errors.mean() == pytest.approx(0.1, abs=2.2e-4)
    assert errors.std() == pytest.approx(0.02, abs=1.6e-4)
    # Neighbouring beams and successive scans are independent.
    centred = errors - 0.1
    assert abs((centred[:, 1:] * centred[:, :-1]).mean()) < 5 * 0.02**2 / math.sqrt(errors.size)
    assert abs((centred[1:] * centred[:-1]).mean()) < 5 * 0.02**2 / math.sqrt(errors.size)
    twice = [lidar(seed=7, noise=Noise(0.0, 0.02)).scan(room(), still) for _ in range(2)]
    np.testing.assert_array_equal(*twice)
    assert (lidar(seed=8, noise=Noise(0.0, 0.02)).scan(room(), still) != twice[0]).any()


def test_the_noise_of_a_beam_does_not_depend_on_what_others_see():
    still = Pose()
    full, sparse = room(), scene((Box((0.1, 9, 9)), Pose.from_xyz_rpy(4.05, 0, 0)))
    a, b = (lidar(seed=3, noise=Noise(0.0, 0.02)).scan(rays, still) for rays in (full, sparse))
    assert a[540] == pytest.approx(b[540], abs=1e-5)  # Embree rounds by scene


def test_periods_in_whole_microseconds():
    assert lidar().period_us == 25_000
    assert lidar(update_rate_hz=15.0).period_us == 66_667
    assert lidar(update_rate_hz=0.0).period_us == 0


def test_a_sensor_of_several_rows_scans_with_the_most_level_one():
    device = lidar(vertical=ScanAxis(3, -0.4, 0.3), horizontal=ScanAxis(1, 0.0, 0.0))
    wall = scene((Box((0.1, 9, 9)), Pose.from_xyz_rpy(2.05, 0, 0)))
    assert device.scan(wall, Pose())[0] == pytest.approx(2.0 / math.cos(0.05), abs=1e-5)


@pytest.mark.table("key", ["urg", "ust", "utm", "puck", "near_puck", "qt64", "tim", "m8"])
def test_every_shipped_lidar_on_the_iris_sees_the_room_and_not_the_iris(key):
    iris = attach(load_model("model://iris"), load_model(f"model://lidar_{key}"), "lidar_mount")
    (link, ray_sensor) = iris.sensors(RaySensor)[0]
    device = Lidar(ray_sensor, link.pose @ ray_sensor.pose, np.random.default_rng(0))
    world = PhysicsWorld(World("w", ()))
    for number, (x, y) in enumerate(((4, 0), (-4, 0), (0, 4), (0, -4))):
        size = "0.2 8 8" if x else "8 0.2 8"
        world.spawn(_wall(size), f"wall_{number}", Pose.from_xyz_rpy(x, y, 0))
    world.spawn(iris, "iris", Pose(), frozenset(f"rotor_{k}_joint" for k in range(4)))
    ranges = device.scan(world.rays, world.get_state("iris").pose, "iris")
    blind = device.scan(world.rays, world.get_state("iris").pose)
    world.close()
    angles = angles_of(device)
    expected = 3.9 / np.maximum(abs(np.cos(angles)), abs(np.sin(angles)))
    reach = expected < device.range_max - 0.2
    np.testing.assert_allclose(ranges[reach], expected[reach], atol=6 * ray_sensor.noise.stddev)
    assert reach.mean() > 0.7
    assert (blind < 0.1).all()  # when it is not passed over, its own housing is all around


def _wall(size):
    return parse_model(
        '<sdf version="1.6"><model name="wall"><static>true</static><link name="l"><collision name="c">'
        f"<geometry><box><size>{size}</size></box></geometry></collision></link></model></sdf>",
        "t",
        [],
    )


def reference_measured(true, sensor, normals):
    """The rules one after the other, each for all beams, in single precision."""
    ranges = true.copy()
    ranges += normals * np.float32(sensor.noise.stddev)
    ranges += np.float32(sensor.noise.mean)
    if sensor.range_resolution_m > 0.0:
        ranges = np.rint(ranges / np.float32(sensor.range_resolution_m))
        ranges *= np.float32(sensor.range_resolution_m)
    ranges = np.maximum(ranges, np.float32(sensor.range_min_m))
    ranges[ranges > np.float32(sensor.range_max_m)] = np.inf
    ranges[true < np.float32(sensor.range_min_m)] = -np.inf
    return ranges


@pytest.mark.table("resolution_m", [0.0, 0.001, 0.25])
@pytest.mark.table(("mean", "stddev"), [(0.0, 0.0), (0.1, 0.0), (0.0, 0.02), (-0.3, 0.5)])
def test_measured_ranges_are_those_of_the_rules_one_by_one(mean, stddev, resolution_m):
    device = sensor(noise=Noise(mean, stddev), range_resolution_m=resolution_m)
    rng = np.random.default_rng(3)
    true = rng.uniform(0.0, 12.0, 2000).astype(np.float32)
    true[::7], true[::11] = np.inf, np.float32(device.range_min_m)
    normals = np.zeros(true.size, np.float32)
    if stddev > 0.0:
        normals = np.random.default_rng(5).standard_normal(true.size, np.float32)
    expected = reference_measured(true, device, normals)
    np.testing.assert_array_equal(measured(true, device, np.random.default_rng(5)), expected)


def test_it_looks_from_where_body_and_mount_put_it():
    class Asked:
        """Keeps what it is asked for."""

        def cast(self, origins, directions, max_range_m, ignore_model):
            self.origins, self.directions = origins, directions
            return np.full(len(directions), np.inf, np.float32)

    body, mount = (
        Pose.from_xyz_rpy(1, -2, 3, 0.3, -0.2, 2.5),
        Pose.from_xyz_rpy(0.1, 0.02, -0.1, 0.1, 0.4, 3.0),
    )
    asked, device = Asked(), lidar(mount)
    device.scan(asked, body)
    lidar_in_world = body @ mount
    np.testing.assert_array_equal(asked.origins, lidar_in_world.position_m)
    expected = device.directions @ lidar_in_world.rotation.astype(np.float32).T
    np.testing.assert_array_equal(asked.directions, expected)
