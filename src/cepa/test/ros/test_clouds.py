"""Clouds as messages, with points worked out by hand."""

import math
import types
from pathlib import Path

import numpy as np
import pytest
import yaml

pytest.importorskip("cepa_ros.clouds", reason="the workspace is not built, or not sourced")

import rospy
from cepa_ros import clouds
from sensor_msgs.msg import PointCloud2, PointField
from std_msgs.msg import Header

from cepa import MotionError, ParameterError
from cepa.steering.clouds import CloudLimits
from cepa.steering.mount import Mount, PlaneTurn, into_body, out_of_body
from input_checks_ros.lidar_readings import LidarReadings

CAMERA_LIMITS = Path(__file__).resolve().parents[2] / "config/clouds/depth_camera.yaml"
POINTS = np.array([[1.0, 2.0, 3.0], [math.nan, 0.0, 0.0], [-4.0, 5.5, -6.0]], np.float32)
LIMITS = {"elevation_min": -0.3, "elevation_max": 0.3, "range_min": 0.5, "range_max": 100.0}
HALF = math.sqrt(0.5)


def points_of(cloud, readings=None):
    return clouds.points_of(cloud, readings or LidarReadings(print))


def message(order="<", **changes):
    """A cloud with a field of another kind between x, y, z and the next point."""
    rows = np.zeros(len(POINTS), [(name, f"{order}f4") for name in "xyz"] + [("ring", "<u2"), ("gap", "V2")])
    for column, name in enumerate("xyz"):
        rows[name] = POINTS[:, column]
    fields = [PointField(name, 4 * k, PointField.FLOAT32, 1) for k, name in enumerate("xyz")]
    cloud = PointCloud2(height=1, width=len(rows), fields=fields, point_step=16, row_step=16 * len(rows))
    cloud.header.stamp.secs = 1
    cloud.is_bigendian, cloud.data = order == ">", rows.tobytes()
    for name, value in changes.items():
        setattr(cloud, name, value)
    return cloud


@pytest.mark.parametrize("order", ["<", ">"])
def test_points_come_as_they_were_written(order):
    np.testing.assert_array_equal(points_of(message(order)), POINTS)


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("wide", ["xyz", "z"])
def test_points_of_64_bits_are_read(order, wide):
    sizes = {name: 8 if name in wide else 4 for name in "xyz"}
    rows = np.zeros(len(POINTS), [(name, f"{order}f{size}") for name, size in sizes.items()])
    for column, name in enumerate("xyz"):
        rows[name] = POINTS[:, column]
    kind = {4: PointField.FLOAT32, 8: PointField.FLOAT64}
    fields = [PointField(name, rows.dtype.fields[name][1], kind[sizes[name]], 1) for name in "xyz"]
    step = rows.dtype.itemsize
    changes = {"fields": fields, "point_step": step, "row_step": step * len(rows), "data": rows.tobytes()}
    np.testing.assert_array_equal(points_of(message(order, **changes)), POINTS)


def test_a_point_in_the_lidar_itself_is_a_beam_without_return():
    # So the drivers of Ouster and Livox tell it
    cloud = message()
    cloud.data = bytes(16) + cloud.data[16:]
    points = points_of(cloud)
    assert np.isnan(points[0]).all()
    np.testing.assert_array_equal(points[1:], POINTS[1:])


def test_rows_may_be_longer_than_their_points():
    cloud = message()
    cloud.width, cloud.height, cloud.row_step = 1, 3, 20
    cloud.data = b"".join(cloud.data[16 * k : 16 * k + 16] + b"gap." for k in range(3))
    np.testing.assert_array_equal(points_of(cloud), POINTS)


@pytest.mark.parametrize("row_step", [0, 16, 7, 1000])
def test_of_one_row_its_length_does_not_count(row_step):
    # As in PCL. Drivers leave it at 0, at the length of a point, or at that of a longer cloud
    np.testing.assert_array_equal(points_of(message(row_step=row_step)), POINTS)


def test_a_row_step_that_is_too_short_is_that_of_the_points():
    cloud = message(height=3, width=1, row_step=0)
    np.testing.assert_array_equal(points_of(cloud), POINTS)


def test_bytes_behind_the_last_point_do_not_count():
    cloud = message()
    cloud.data += bytes(40)
    np.testing.assert_array_equal(points_of(cloud), POINTS)


@pytest.mark.parametrize(
    "changes",
    [
        {"fields": []},
        {"data": b"short"},
        {"height": 2, "row_step": 7},
        {"height": 2**31},
        {"point_step": 8},
        {"point_step": 0},
    ],
)
def test_clouds_that_make_no_sense_are_refused(changes):
    with pytest.raises(MotionError, match="The cloud"):
        points_of(message(**changes))


def test_a_camera_that_looks_ahead_and_a_lidar_that_is_turned():
    # The axes of a camera are right, down and ahead; it sits 0.1 m ahead of the body's middle
    camera = Mount(PlaneTurn(0.0), (0.1, 0.0, 0.0), (-0.5, 0.5, -0.5, 0.5))
    in_body = into_body(np.array([[1.0, -0.5, 3.0]]), camera)
    np.testing.assert_allclose(in_body, [[3.1, -1.0, 0.5]], atol=1e-12)
    lidar = Mount(PlaneTurn(math.pi / 2), (0.0, 0.0, 0.2), (0.0, 0.0, HALF, HALF))
    np.testing.assert_allclose(out_of_body(in_body, lidar), [[-1.0, -3.1, 0.3]], atol=1e-12)


def test_the_limits_are_read_and_checked():
    cloud = CloudLimits.of(LIMITS).cloud(POINTS)
    assert (cloud.elevation_rad, cloud.range_min_m, cloud.range_max_m) == ((-0.3, 0.3), 0.5, 100.0)
    assert cloud.azimuth_rad == (-math.pi, math.pi)
    for wrong in ("puck", {**LIMITS, "range_min": "near"}, {"range_min": 1.0}, {**LIMITS, "range_max": 0.1}):
        with pytest.raises(ParameterError):
            CloudLimits.of(wrong)


def test_the_simulators_depth_camera_gives_a_cloud_as_cepa_takes_it():
    payload_output = pytest.importorskip("simulation_tools_ros.gazebo.payload_output")
    # A camera of 320 x 240 pixels and 70 degrees, as the simulator's: the axis goes between the middle pixels
    camera = types.SimpleNamespace(focal_px=160.0 / math.tan(math.radians(35.0)), centre_px=(159.5, 119.5))
    depths = np.full((240, 320), np.inf, np.float32)
    depths[119:121, 159:161] = 4.0
    depths[120, 319] = 2.0
    header = Header(stamp=rospy.Time(1))
    in_optical = points_of(payload_output.depth_cloud_message(header, depths, camera))
    mount = Mount(PlaneTurn(0.0), (0.16, 0.0, -0.03), (-0.5, 0.5, -0.5, 0.5))
    in_body = into_body(in_optical, mount)
    seen = in_body[np.isfinite(in_body).all(axis=1)]
    assert len(seen) == 5
    np.testing.assert_allclose(seen[:2], [[4.16, y, -0.03 + 0.0087] for y in (0.0087, -0.0087)], atol=1e-3)
    right = seen[np.argmin(seen[:, 1])]
    np.testing.assert_allclose(right, [2.16, -2.0 * math.tan(math.radians(35.0)), -0.03], atol=0.01)
    limits = CloudLimits.of(yaml.safe_load(CAMERA_LIMITS.read_text()))
    assert not limits.cloud(seen).looks_all_around
    low, high = limits.azimuth_rad
    assert low <= math.atan2(right[1], right[0] - 0.16) + 1e-3
    assert high == -low
