"""The picture shows the occupied voxels."""

from __future__ import annotations

import numpy as np

from gridslam.volume import Board, VolumeParameters, VoxelMap
from gridslam.volume.picture import occupied_centres, volume_figure


def test_each_view_shows_every_occupied_voxel():
    voxels = VoxelMap(VolumeParameters())
    ends = np.array([(1.05, 0.05, 0.05), (0.05, -2.05, 0.75), (0.35, 0.05, 1.95)])
    voxels.insert(voxels.rays((0.05, 0.05, 0.05), ends), Board())
    centres = occupied_centres(voxels)
    np.testing.assert_allclose(sorted(centres.tolist()), sorted(ends.tolist()), atol=1e-9)
    views = volume_figure(voxels, "three voxels").axes[:3]
    for view, axes in zip(views, ((0, 1), (0, 2), (1, 2))):
        shown = sorted(map(tuple, np.round(view.collections[0].get_offsets(), 6).tolist()))
        assert shown == sorted(map(tuple, np.round(ends[:, axes], 6).tolist()))
