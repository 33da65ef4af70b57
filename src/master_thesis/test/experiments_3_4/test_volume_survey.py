"""From a flight's true path and map of voxels to figures and files, in a room in closed form."""

import numpy as np
import pytest

from gridslam.volume import Board, VolumeParameters, VoxelMap, stream_of, write_octree
from master_thesis.experiments_3_4.slam_summary import headline
from master_thesis.experiments_3_4.volume.survey import lidar_path, survey_volume

HALF_TURN = [0.0, 0.0, 1.0, 0.0]
LEVEL = [0.0, 0.0, 0.0, 1.0]
WORLD = """<sdf version='1.6'><world name='w'><model name='room'><static>true</static>
<link name='l'>{}</link></model>
</world></sdf>"""
WALL = "<collision name='{}'><pose>{} 0 0 0</pose><geometry><box><size>{}</size></box></geometry></collision>"


def test_the_lidar_is_where_the_uav_carries_it():
    truth = np.array([[0.0, 0, 0, 1, *LEVEL], [1.0, 2, 0, 2, *LEVEL], [2.0, 2, 0, 2, *HALF_TURN]])
    mounted = np.array([[t, 0.5, 0.0, 0.1, *LEVEL] for t in (-0.5, 0.5, 2.0, 2.5)])
    path = lidar_path(truth, mounted)
    np.testing.assert_allclose(path[:, :4], [[0.5, 1.5, 0, 1.6], [2.0, 1.5, 0, 2.1]], atol=1e-9)
    np.testing.assert_allclose(path[:, 4:], [LEVEL, HALF_TURN], atol=1e-9)


def test_a_quaternion_and_its_negative_are_one_attitude():
    truth = np.array([[0.0, 0, 0, 1, *LEVEL], [1.0, 0, 0, 1, 0, 0, 0, -1.0]])
    path = lidar_path(truth, np.array([[0.5, 1.0, 0, 0, *LEVEL]]))
    np.testing.assert_allclose(path[0, 1:4], [1.0, 0, 1.0], atol=1e-9)


def test_a_nodding_lidar_leans_with_the_uav():
    """The UAV's nose is 30 degrees up, and the lidar's 30 degrees down."""
    up, down = ([0.0, sign * np.sin(np.radians(15)), 0.0, np.cos(np.radians(15))] for sign in (-1, 1))
    path = lidar_path(np.array([[0.0, 0, 0, 1, *up], [1.0, 0, 0, 1, *up]]), np.array([[0.5, 0, 0, 0, *down]]))
    np.testing.assert_allclose(path[0, 4:], LEVEL, atol=1e-9)


@pytest.fixture
def flown(tmp_path):
    """Two walls, 4 m apart, of which one is mapped; a UAV that hovers between them with a Puck."""
    walls = (WALL.format(name, f"{x} 0 1", "0.1 4 2") for name, x in (("left", -2.05), ("right", 2.05)))
    (tmp_path / "two.world").write_text(WORLD.format("".join(walls)))
    y, z = np.meshgrid(np.arange(-1.95, 2, 0.1), np.arange(0.05, 2, 0.1))
    voxels = VoxelMap(VolumeParameters())
    ends = np.column_stack((np.full(y.size, 2.05), y.ravel(), z.ravel()))
    voxels.insert(voxels.rays((0.05, 0.05, 1.05), ends), Board())
    write_octree(tmp_path / "map.bt", stream_of(voxels, is_binary=True), 0.1)
    return tmp_path


def test_half_of_what_a_puck_saw_is_mapped(flown):
    truth = np.array([[float(t), 0, 0, 0.9, *LEVEL] for t in range(3)])
    mounted = np.array([[t, 0, 0, 0.1, *LEVEL] for t in (0.5, 1.5)])
    volume = survey_volume(flown, flown / "two.world", "puck", truth, mounted)
    assert volume["volume_error_max_m"] == pytest.approx(0.05, abs=1e-6)
    assert volume["visible_surface_mapped_share"] == pytest.approx(0.5, abs=0.05)
    assert volume["free_right_share"] == 1.0
    assert (flown / "volume.png").read_bytes()[:4] == b"\x89PNG"
    assert np.loadtxt(flown / "lidar.tum").shape == (2, 8)


def test_the_headline_tells_of_the_voxels():
    slam = dict.fromkeys(
        (
            "ate_rmse_m",
            "ate_online_rmse_m",
            "map_error_mean_m",
            "map_error_p95_m",
            "odometry_ate_rmse_m",
            "wall_turned_max_rad",
            "closures",
        ),
        0.0,
    )
    run = {"scenario": "hold", "algorithm": "improved", "lidar": "puck", "seed": 1, "reached_goal": True}
    run |= {"collision": False, "failure": None, "flight_time_s": 1.0, "path_length_m": 1.0}
    run |= dict.fromkeys(("min_clearance_m", "cepa_computation_ms", "latency_ms", "real_time_factor"))
    volume = {"volume_error_p95_m": 0.0512, "visible_surface_mapped_share": 0.9876}
    lines = headline({**run, "slam": {**slam, "wall_seen_share": 1.0}, "volume": volume})
    assert "0.051 m" in lines
    assert "98.8 %" in lines
