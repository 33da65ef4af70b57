"""Two lidars in one frame are found; one alone never is, also where it turns fast and odometry drifts."""

import numpy as np
import planar_world
import pytest

from gridslam import se2
from gridslam.errors import MountingError
from gridslam.inputs import turns_watch
from gridslam.inputs.turns_watch import TurnsWatch

LIDAR = planar_world.Lidar(4.7, 180, 10.0, 0.01, 10.0)
ROUTE = np.array([(-8.0, -5.0), (0.0, -5.0), (0.0, 3.0), (-6.0, 3.0), (-6.0, 0.0)])
TRUTH = planar_world.along(ROUTE, 0.4, turn_rad=1.0)


@pytest.fixture(scope="module", params=[0, 1])
def log(request):
    walls = planar_world.scattered_boxes(request.param, TRUTH) if request.param else planar_world.hold()
    return walls, planar_world.drive(walls, TRUTH, LIDAR, request.param)


def test_one_lidar_is_never_refused(log, monkeypatch):
    monkeypatch.setattr(turns_watch, "SAME_MIN", 10**6)
    watch = TurnsWatch()
    for scan, base in zip(log[1].scans, log[1].odometry):
        watch.check(scan, base)


@pytest.mark.table("other", [(-0.4, 0.0, np.pi), (0.0, 0.2, np.pi / 2)])
def test_two_in_one_frame_are_refused(log, other):
    walls, drive = log
    scans, rng = list(drive.scans), np.random.default_rng(1)
    for index in range(1, len(scans), 2):
        pose = se2.compose(TRUTH[index], np.array(other))
        scans[index] = planar_world.scan_at(walls, pose, LIDAR, rng, scans[index].stamp_s)

    def watch_all():
        watch = TurnsWatch()
        for scan, base in zip(scans, drive.odometry):
            watch.check(scan, base)

    with pytest.raises(MountingError, match="two lidars send scans in one frame"):
        watch_all()
