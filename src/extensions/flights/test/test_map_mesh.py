"""Given a map of voxels whose shape is known, its mesh has that shape, and a survey finds its surface."""

import numpy as np
import pytest
import trimesh

from flights.photographing.map_mesh import (
    FREE,
    OCCUPIED,
    UNKNOWN,
    borders,
    mesh_of_map,
    scene_of,
    smoothed,
    surfaces_of_map,
)
from gridslam import SlamError
from gridslam.volume import FLAT_MISS, Board, CorrectedMap, Pose, VolumeParameters, VoxelMap
from gridslam.volume.octree.files import write_octree
from gridslam.volume.octree.stream import stream_of
from gridslam.volume.path_poses import OdometryHistory
from gridslam.volume.saved.map_time import MapTime
from gridslam.volume.saved.saved_map import state_of, write_volume
from inspection.survey.parameters import SurveyParameters
from inspection.survey.surface.mesh_file import MAPPED_PLATING, MAPPED_STRUCTURE
from inspection.survey.surface.rays import Rays
from inspection.survey.surface.reading import read_surface


def facing(corners, quads):
    """Area vectors of quads."""
    a, b, _, d = (corners[quads[:, k]] for k in range(4))
    return np.cross(b - a, d - a)


def test_borders_of_a_box_face_into_it_and_have_its_area():
    kinds = np.zeros((8, 9, 10), np.int8)
    kinds[1:7, 1:8, 1:9] = OCCUPIED
    kinds[2:6, 2:7, 2:8] = FREE
    kinds[2, 2, 1] = UNKNOWN  # a voxel of the floor was never seen
    corners, quads, of = borders(kinds)
    across = facing(corners, quads)
    assert np.abs(across[of == OCCUPIED]).sum() == 2 * (4 * 5 + 5 * 6 + 4 * 6) - 1
    inwards = np.array((4.0, 4.5, 5.0)) - corners[quads].mean(axis=1)
    assert ((across * inwards).sum(axis=1) > 0).all()
    assert (of == UNKNOWN).sum() == 1


def air_above(height):
    """Borders of voxels (30, 30, 20) that are free above a height (x, y), but for the frame."""
    x, y, z = np.meshgrid(*(np.arange(size) + 0.5 for size in (30, 30, 20)), indexing="ij")
    kinds = np.where(z > height(x, y), FREE, OCCUPIED).astype(np.int8)
    kinds[[0, -1]] = kinds[:, [0, -1]] = kinds[:, :, [0, -1]] = OCCUPIED
    return borders(kinds)


def inner(corners):
    """Which corners are far from the frame."""
    return (np.abs(corners - (15.0, 15.0, 10.0)) < (9.0, 9.0, 8.0)).all(axis=1)


def test_steps_of_a_wall_across_the_voxels_are_smoothed():
    corners, quads, _ = air_above(lambda x, y: 3.0 + 0.37 * x + 0.11 * y)
    smooth = smoothed(corners, quads)
    assert np.abs(smooth - corners).max() <= 0.5
    normal = np.array((-0.37, -0.11, 1.0)) / np.linalg.norm((-0.37, -0.11, 1.0))
    kept = inner(corners)
    whole = quads[kept[quads].all(axis=1)]

    def off(places):
        """Mean sine between the quads and the wall, by area."""
        across = facing(places, whole)
        return np.linalg.norm(np.cross(across, normal), axis=1).sum() / np.linalg.norm(across, axis=1).sum()

    assert off(smooth) < 0.6 * off(corners)
    heights = smooth[kept] @ normal - 3.0 * normal[2]
    assert abs(heights.mean()) < 0.1
    assert heights.std() < 0.5 * (corners[kept] @ normal).std()


def test_an_even_wall_stays_and_one_wrong_voxel_gets_flatter():
    corners, quads, _ = air_above(lambda x, y: 8.0 + 0.0 * x)
    smooth = smoothed(corners, quads)
    kept = inner(corners)
    assert np.abs(smooth[kept] - corners[kept]).max() < 0.05
    corners, quads, _ = air_above(lambda x, y: 8.0 + ((x // 1 == 15) & (y // 1 == 15)))
    heights = smoothed(corners, quads)[inner(corners), 2] - 8.0
    assert 0.0 < heights.max() < 0.8


def test_a_thin_bar_stays():
    kinds = np.full((12, 12, 30), FREE, np.int8)
    kinds[[0, -1]] = kinds[:, [0, -1]] = kinds[:, :, [0, -1]] = UNKNOWN
    kinds[5, 6, 1:-1] = OCCUPIED
    corners, quads, of = borders(kinds)
    bar = smoothed(corners, quads)[np.unique(quads[of == OCCUPIED])]
    middle = bar[(bar[:, 2] > 5) & (bar[:, 2] < 25)]
    assert (np.ptp(middle[:, :2], axis=0) > 0.5).all()


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
    assert set(surface.patches.names) == {MAPPED_PLATING, MAPPED_STRUCTURE, "unknown"}
    found_m2 = surface.patches.areas_m2.sum()
    assert 0.85 * walls_m2 < found_m2 < 1.02 * walls_m2  # below the deck some voxels of the walls stay unseen


def web_in_a_room(resolution_m=0.2):
    """Map of a room of 6 x 5 x 4 m, turned by 10 deg, with a web of 5 cm that was seen from x > 3 m only."""
    turn, rng = np.radians(10.0), np.random.default_rng(9)
    rotation = np.array(((np.cos(turn), -np.sin(turn), 0), (np.sin(turn), np.cos(turn), 0), (0, 0, 1.0)))
    room = trimesh.creation.box(bounds=((0, 0, 0), (6, 5, 4)))
    room.invert()
    web = trimesh.creation.box(bounds=((2.95, 4.0, 0), (3.0, 5.0, 4)))
    triangles_m = np.concatenate((room.triangles, web.triangles)) @ rotation.T
    sight = Rays(triangles_m)
    corrected = CorrectedMap(VolumeParameters(resolution_m=resolution_m, miss=FLAT_MISS))
    for number, x in enumerate(np.linspace(3.2, 5.0, 8)):
        directions = rng.normal(size=(6000, 3))
        directions /= np.linalg.norm(directions, axis=1)[:, None]
        here_m = rotation @ (x, rng.uniform(1.0, 3.5), rng.uniform(1.0, 3.0))
        ranges_m = sight.ranges_m(np.tile(here_m, (6000, 1)), directions) + rng.normal(0.0, 0.008, 6000)
        pose = Pose(np.eye(3), here_m)
        corrected.add(
            float(number), (directions * ranges_m[:, None]).astype(np.float32), pose, Pose.identity()
        )
    return corrected, rotation


def surface_in(scene):
    """All that the map knows, as one mesh."""
    parts = [scene.geometry[scene.graph[name][1]] for name in (MAPPED_PLATING, MAPPED_STRUCTURE)]
    return trimesh.util.concatenate(parts)


def test_clouds_give_a_thin_web_its_two_sides_and_even_walls(tmp_path):
    corrected, rotation = web_in_a_room()
    path = tmp_path / "map.bt"
    write_octree(path, stream_of(corrected.voxels, is_binary=True), corrected.parameters.resolution_m)
    by_voxels = surface_in(mesh_of_map(path))
    write_volume(state_of(corrected, OdometryHistory(), MapTime()), path.with_suffix(".state"))
    by_clouds = surface_in(mesh_of_map(path))
    walls = np.concatenate((np.eye(3), -np.eye(3))) @ rotation.T

    def even(mesh):
        """Share of the area that faces as a wall does, within 8 deg."""
        faces = (mesh.face_normals @ walls.T).max(axis=1) > np.cos(np.radians(8.0))
        return mesh.area_faces[faces].sum() / mesh.area

    assert even(by_clouds) > 0.95 > 0.7 > even(by_voxels)
    own = by_clouds.triangles_center @ rotation  # in the room's frame
    for sign in (1.0, -1.0):
        faces = by_clouds.face_normals @ (sign * walls[0]) > 0.99
        on_web = faces & (np.abs(own[:, 0] - 2.975) < 0.06) & (own[:, 1] > 4.0)
        assert by_clouds.area_faces[on_web].sum() == pytest.approx(4.0, rel=0.15)


def test_a_wall_before_the_unknown_has_no_back(tmp_path):
    corrected, rotation = web_in_a_room()
    path = tmp_path / "map.bt"
    write_octree(path, stream_of(corrected.voxels, is_binary=True), corrected.parameters.resolution_m)
    mesh = surface_in(scene_of(surfaces_of_map(path, corrected.nodes)))
    own, facing_m = mesh.triangles_center @ rotation, mesh.face_normals @ rotation
    floor = np.abs(own[:, 2]) < 0.1
    assert mesh.area_faces[floor & (facing_m[:, 2] > 0.9)].sum() > 20.0
    assert mesh.area_faces[floor & (facing_m[:, 2] < -0.9)].sum() < 0.5


def test_clouds_that_are_damaged_are_told(tmp_path):
    corrected, _ = web_in_a_room()
    path = tmp_path / "map.bt"
    write_octree(path, stream_of(corrected.voxels, is_binary=True), corrected.parameters.resolution_m)
    path.with_suffix(".state").write_bytes(b"none")
    with pytest.raises(SlamError, match=r"map\.state"):
        mesh_of_map(path)
