"""Maps of voxels of clouds in a hold, along paths that tests give."""

from __future__ import annotations

import numpy as np
from room_clouds import puck_directions, ranges_in_hold

from gridslam.volume import Board, Box, CorrectedMap, NodeSpacing, Pose, VolumeParameters

EVERY = NodeSpacing(period_s=1e-9)
PARAMETERS = VolumeParameters(resolution_m=0.4)
DIRECTIONS = puck_directions(40)


def cloud_at(x, y, z, yaw, seed=0):
    """A cloud in the sensor's frame, and the sensor's pose."""
    pose = Pose(Pose.level(0.0, 0.0, yaw).rotation, np.array((x, y, z)))
    beams = DIRECTIONS @ pose.rotation.T
    return DIRECTIONS * ranges_in_hold(pose.translation, beams, seed=seed)[:, None], pose


def flown(path, spacing=EVERY, base=None):
    corrected = CorrectedMap(PARAMETERS, spacing, base)
    for number, place in enumerate(path):
        points, pose = cloud_at(*place, seed=number)
        corrected.add(float(number), points, pose, Pose.identity())
    return corrected


def fresh(corrected):
    """The map of the same clouds at the poses that they have now."""
    voxels = CorrectedMap(PARAMETERS, base=corrected.base).voxels
    for node in corrected.nodes:
        pose = node.sensor_in_map
        voxels.insert(voxels.rays(pose.translation, pose.of_points(node.cloud.points())), Board())
    return voxels


def union(*maps):
    boxes = [each.box() for each in maps]
    return Box(np.min([box.low for box in boxes], axis=0), np.max([box.high for box in boxes], axis=0))


def assert_equal(one, other):
    box = union(one, other)
    np.testing.assert_array_equal(one.values(box), other.values(box))
