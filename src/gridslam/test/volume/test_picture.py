"""The picture shows the occupied voxels, cut open."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.lines import Line2D

from gridslam.volume import Board, VolumeParameters, VoxelMap
from gridslam.volume.drawing.centres import occupied_centres
from gridslam.volume.drawing.picture import explain, shadows, volume_figure


def test_each_view_shows_the_voxels_behind_its_cut():
    voxels = VoxelMap(VolumeParameters())
    ends = np.array([(1.05, 0.05, 0.05), (0.05, -2.05, 0.75), (0.35, 0.05, 1.95)])
    voxels.insert(voxels.rays((0.05, 0.05, 0.05), ends), Board())
    centres = occupied_centres(voxels)
    np.testing.assert_allclose(sorted(centres.tolist()), sorted(ends.tolist()), atol=1e-9)
    views = volume_figure(voxels, "three voxels").axes[:4]
    shown = {axes.get_xlabel()[0] + axes.get_ylabel()[0]: axes for axes in views if axes.images}
    assert set(shown) == {"xy", "xz", "yz"}
    for name, axes in shown.items():
        image = axes.images[0]
        left, right, low, high = image.get_extent()
        rows, columns = np.nonzero(~np.ma.getmaskarray(image.get_array()))
        at = np.column_stack((left + (columns + 0.5) * 0.1, low + (rows + 0.5) * 0.1))
        behind = {"xy": ends[:, 2] <= 1.0, "xz": ends[:, 1] >= -1.0, "yz": ends[:, 0] >= 0.55}[name]
        expected = ends[behind][:, ["xyz".index(letter) for letter in name]]
        np.testing.assert_allclose(sorted(at.tolist()), sorted(expected.tolist()), atol=1e-6)
        assert right - left == pytest.approx(np.ptp(ends[:, "xyz".index(name[0])]) + 0.1)
        assert high > low


def test_what_lies_behind_its_neighbour_has_a_shadow():
    depth = np.array([[1.0, 1.0, 1.25, np.nan], [1.0, 1.0, 1.25, 3.0]])
    dark = shadows(depth)
    np.testing.assert_allclose(dark, [[0, 0, 0.375, 0], [0, 0, 0.375, 0.75]])


def test_a_legend_explains_the_colours_and_takes_more_keys():
    voxels = VoxelMap(VolumeParameters(resolution_m=0.2))
    voxels.insert(voxels.rays((0.1, 0.1, 0.1), np.array([(3.1, 0.1, 0.1)], np.float32)), Board())
    figure = volume_figure(voxels, "one voxel")
    explain(figure, [Line2D([], [], label="path")])
    (legend,) = figure.legends
    told = [text.get_text() for text in legend.get_texts()]
    assert told == ["occupied voxel of 0.2 m", "edge of what is nearer", "free, unknown, or cut away", "path"]
