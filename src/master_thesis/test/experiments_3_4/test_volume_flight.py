"""The map of voxels of a recorded flight, in a closed room of walls of a known place."""

import numpy as np
import pytest

from flights.errors import FlightError
from flights.flight.flight_recording import FlightRecording, LidarGeometry
from gridslam.trajectory import Trajectory
from master_thesis.experiments_3_4.volume.flight import map_and_judge
from simulation_tools.geometry import Pose

HALF_M = np.array([3.0, 2.0, 1.5])
THICK_M = 0.2
WORLD = """<sdf version='1.6'><world name='w'><model name='room'><static>true</static>
<pose>0 0 {} 0 0 0</pose><link name='l'>{}</link></model></world></sdf>"""
WALL = """<collision name='{}'><pose>{} {} {} 0 0 0</pose>
<geometry><box><size>{} {} {}</size></box></geometry></collision>"""
MOUNT = LidarGeometry(-np.pi, 0.1, 0.5, 100.0, (0.0, 0.0, 0.1), (0.0, 0.0, 0.0, 1.0))


@pytest.fixture
def world(tmp_path):
    """A room of 6 x 4 x 3 m, its floor at z = 0, its faces on voxels' borders."""
    walls = []
    for axis in range(3):
        for side in (-1, 1):
            centre, size = np.zeros(3), 2 * (HALF_M + THICK_M)
            centre[axis], size[axis] = side * (HALF_M[axis] + THICK_M / 2), THICK_M
            walls.append(WALL.format(f"{axis}{side}", *centre, *size))
    path = tmp_path / "room.world"
    path.write_text(WORLD.format(HALF_M[2], "".join(walls)))
    return path


TIMES_S = np.arange(0.0, 8.0, 0.2)


def true_poses():
    """To and fro, up and down, leaning: (n, 7)."""
    x, z = 1.2 * np.sin(0.8 * TIMES_S), 1.4 + 0.6 * np.sin(1.5 * TIMES_S)
    lean = 0.6 * np.sin(2.1 * TIMES_S)
    attitudes = [Pose.from_xyz_rpy(0, 0, 0, roll, 0.5 * roll, 0).orientation_xyzw for roll in lean]
    return np.column_stack((x, 0.3 * x, z, attitudes))


def recording(odometry_in_world=(0.0, 0.0, 0.0)):
    """The flight; odometry has begun at a pose (x, y, yaw) in the world and drifts no further."""
    truth, origin = true_poses(), Pose.from_xyz_rpy(*odometry_in_world[:2], 0, 0, 0, odometry_in_world[2])
    back = origin.inverse()
    seen = [back @ Pose(tuple(row[:3]), tuple(row[3:])) for row in truth.tolist()]
    odometry = np.array([(*pose.position_m, *pose.orientation_xyzw) for pose in seen])
    return FlightRecording("room", MOUNT, TIMES_S, np.zeros((len(TIMES_S), 1)), odometry, truth)


def path(off_m=0.0):
    """SLAM's path: x, y and yaw of the true poses, wrong by so much along x."""
    poses = [Pose(tuple(row[:3]), tuple(row[3:])) for row in true_poses().tolist()]
    return Trajectory(
        TIMES_S, np.array([(p.position_m[0] + off_m, p.position_m[1], p.rpy_rad[2]) for p in poses])
    )


def test_a_true_path_gives_a_true_map(world):
    judged = map_and_judge(recording(), world, "puck", path(), seed=1)
    assert 0 < judged.clouds < len(TIMES_S)  # a cloud that adds little is not kept
    assert len(judged.places) == len(TIMES_S)
    assert judged.error.p95_m == pytest.approx(0.05, abs=0.002)
    assert judged.error.mapped > 0.99
    assert judged.error.free_right > 0.99
    assert judged.error.visible_m2 == pytest.approx(2 * 4 * np.dot(HALF_M, np.roll(HALF_M, 1)), rel=0.25)


def test_the_path_corrects_odometry(world):
    """Odometry that began 1 m aside and turned by 40 degrees gives the same map."""
    straight = map_and_judge(recording(), world, "puck", path(), seed=1)
    corrected = map_and_judge(recording((1.0, -0.5, 0.7)), world, "puck", path(), seed=1)
    assert corrected.error.p95_m == pytest.approx(straight.error.p95_m, abs=0.002)
    assert corrected.error.mapped == pytest.approx(straight.error.mapped, abs=0.01)


def test_a_path_that_is_off_shows_in_the_map(world):
    judged = map_and_judge(recording(), world, "puck", path(off_m=0.3), seed=1)
    assert 0.2 < judged.error.p95_m < 0.4  # the walls across x are off, the others slide along themselves


def test_a_planar_lidar_has_no_cloud(world):
    with pytest.raises(FlightError, match="one plane"):
        map_and_judge(recording(), world, "ust", path(), seed=1)
