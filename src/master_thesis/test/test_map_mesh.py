"""Given a map of voxels whose shape is known, its mesh has that shape, and a survey finds its surface."""

import numpy as np

from gridslam.volume import Board, VolumeParameters, VoxelMap
from gridslam.volume.octree.files import write_octree
from gridslam.volume.octree.stream import stream_of
from inspection_tools.survey.parameters import SurveyParameters
from inspection_tools.survey.surface.reading import read_surface
from master_thesis.photographing.map_mesh import FREE, OCCUPIED, UNKNOWN, borders, mesh_of_map


def test_borders_of_a_box_face_into_it_and_have_its_area():
    kinds = np.zeros((8, 9, 10), np.int8)
    kinds[1:7, 1:8, 1:9] = OCCUPIED
    kinds[2:6, 2:7, 2:8] = FREE
    kinds[2, 2, 1] = UNKNOWN  # a voxel of the floor was never seen
    quads = np.concatenate(list(borders(kinds, OCCUPIED)))
    across = np.cross(quads[:, 1] - quads[:, 0], quads[:, 3] - quads[:, 0])
    assert np.abs(across).sum() == 2 * (4 * 5 + 5 * 6 + 4 * 6) - 1
    inwards = np.array((4.0, 4.5, 5.0)) - quads.mean(axis=1)
    assert ((across * inwards).sum(axis=1) > 0).all()
    assert len(np.concatenate(list(borders(kinds, UNKNOWN)))) == 1


def test_a_survey_finds_the_surface_of_a_map_and_leaves_the_unknown_out(tmp_path):
    resolution_m, size_m = 0.1, np.array((4.0, 3.0, 2.4))
    axes = [np.arange(resolution_m / 2, side, resolution_m) for side in size_m]
    centres = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    shell = centres[(np.minimum(centres, size_m - centres) < resolution_m).any(axis=1)]
    shell = shell[shell[:, 2] < 2.3]  # the deck was never seen
    voxels = VoxelMap(VolumeParameters(resolution_m=resolution_m))
    voxels.insert(voxels.rays(size_m / 2 + 0.01, shell), Board())
    write_octree(tmp_path / "map.bt", stream_of(voxels, is_binary=True), resolution_m)
    (tmp_path / "map.glb").write_bytes(mesh_of_map(tmp_path / "map.bt").export(file_type="glb"))
    surface = read_surface(tmp_path / "map.glb", SurveyParameters())
    inner = size_m - 2 * resolution_m
    walls_m2 = 2 * (inner[0] + inner[1]) * 2.2 + inner[0] * inner[1]
    assert set(surface.patches.names) == {"surface", "unknown"}
    found_m2 = surface.patches.areas_m2.sum()
    assert 0.85 * walls_m2 < found_m2 < 1.02 * walls_m2  # below the deck some voxels of the walls stay unseen
