"""The judge of voxels, on a closed room whose figures are known in closed form."""

import numpy as np
import pytest
import trimesh

from gridslam.errors import EvaluationError
from gridslam.evaluation.volume.surface import Surface, read_surface
from gridslam.evaluation.volume.visibility import LidarView, Places, in_sight, visible_samples
from gridslam.evaluation.volume.volume_error import volume_error
from gridslam.evaluation.volume.voxels import Voxels

R = 0.1
SIZE_M = np.array([4.0, 3.0, 2.0])


def surface_of(**boxes):
    """Boxes by name: (extents, centre)."""
    meshes = {
        name: trimesh.creation.box(extents, trimesh.transformations.translation_matrix(centre))
        for name, (extents, centre) in boxes.items()
    }
    triangles = [mesh.triangles for mesh in meshes.values()]
    part = np.repeat(np.arange(len(meshes)), [len(each) for each in triangles])
    return Surface(np.concatenate(triangles), tuple(meshes), part)


def room(**more):
    return surface_of(room=(SIZE_M, SIZE_M / 2), **more)


def grid(low, high):
    """Centres of the voxels between two corners, which lie on voxels' borders."""
    axes = [np.arange(a + R / 2, b, R) for a, b in zip(low, high)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)


def shell():
    """Return centres of a perfect map of the room: the first layer inside its walls, and what is within."""
    centres = grid((0, 0, 0), SIZE_M)
    on_wall = (np.minimum(centres, SIZE_M - centres) < R).any(axis=1)
    return centres[on_wall], centres[~on_wall]


def places(*positions):
    return Places(np.array(positions, float), np.tile(np.eye(3), (len(positions), 1, 1)))


def rng():
    return np.random.default_rng(1)


def test_a_perfect_map_is_half_a_voxel_off_and_complete():
    occupied, free = shell()
    error, distances = volume_error(Voxels(occupied, free, R), room(), rng(), places(SIZE_M / 2))
    assert distances.min() == pytest.approx(R / 2, abs=1e-6)
    assert distances.max() < R / 2 + 0.025
    assert error.p95_m == pytest.approx(R / 2, abs=1e-6)
    assert (error.within_a_voxel, error.mapped, error.free_right) == (1.0, 1.0, 1.0)
    assert error.mapped_by_part == {"room": 1.0}


def test_a_shifted_map_is_off_by_its_shift():
    occupied = grid((0, 0, 0), (R, SIZE_M[1], SIZE_M[2]))  # the wall at x = 0
    error, _ = volume_error(Voxels(occupied + np.array([0.25, 0.0, 0.0]), np.empty((0, 3)), R), room(), rng())
    assert error.mean_m < 0.30  # nearer to the floor and the other walls in the corners
    assert error.max_m == pytest.approx(R / 2 + 0.25, abs=0.01)
    assert np.isnan(error.mapped)
    assert np.isnan(error.free_right)


def test_distances_are_those_of_a_slow_search_over_all_triangles():
    surface = room(post=((0.3, 0.2, 2.0), (1.7, 1.1, 1.0)), shelf=((1.0, 0.4, 0.05), (3.0, 2.8, 1.2)))
    points = rng().uniform(-0.2, 4.2, (300, 3))
    samples = surface.samples(0.05, rng(), (-1, -1, -1), (5, 5, 5))
    every = [
        np.linalg.norm(
            trimesh.triangles.closest_point(np.repeat(triangle[None], len(points), axis=0), points) - points,
            axis=1,
        )
        for triangle in surface.triangles_m
    ]
    np.testing.assert_allclose(surface.distances_m(points, samples), np.min(every, axis=0), atol=0.01)


def test_half_of_the_walls_mapped_is_half_of_the_surface():
    """The two halves of a cube of 2 m are alike."""
    cube = surface_of(cube=((2.0, 2.0, 2.0), (1.0, 1.0, 1.0)))
    centres = grid((0, 0, 0), (2, 2, 2))
    on_wall = (np.minimum(centres, 2.0 - centres) < R).any(axis=1)
    left = on_wall & (centres[:, 0] < 1.0)
    voxels = Voxels(centres[left], np.empty((0, 3)), R)
    drawn = [np.random.default_rng(seed) for seed in range(16)]
    shares = [volume_error(voxels, cube, each, places((1, 1, 1)))[0].mapped for each in drawn]
    reach = R / 2  # a surface counts as mapped up to the far side of the neighbouring voxel
    expected = (4 + 8 * (1.0 + 2 * reach)) / 24
    assert np.mean(shares) == pytest.approx(expected, abs=0.01)  # four standard deviations of 16 drawings


def test_what_a_level_lidar_cannot_see_is_not_asked_for():
    """Beams of +-15 degrees from the middle of the cube: the walls' middle bands only."""
    cube = surface_of(cube=((2.0, 2.0, 2.0), (0.0, 0.0, 0.0)))
    samples = cube.samples(0.02, rng(), (-2, -2, -2), (2, 2, 2))
    seen = visible_samples(cube, samples, places((0, 0, 0)), LidarView((-15.0, 15.0)), rng())
    x, y, z = samples.points_m.T
    expected = np.abs(z) <= np.tan(np.radians(15.0)) * np.hypot(x, y)
    assert (seen == expected).mean() > 0.999
    assert 0.1 < seen.mean() < 0.3


def test_a_leaning_lidar_sees_the_floor():
    cube = surface_of(cube=((2.0, 2.0, 2.0), (0.0, 0.0, 0.0)))
    samples = cube.samples(0.05, rng(), (-2, -2, -2), (2, 2, 2))
    nose_down = trimesh.transformations.rotation_matrix(np.radians(60), (0, 1, 0))[:3, :3]
    leaning = Places(np.zeros((1, 3)), nose_down[None])
    floor = samples.points_m[:, 2] < -0.999
    view = LidarView((-15.0, 15.0))
    assert not visible_samples(cube, samples, places((0, 0, 0)), view, rng())[floor].any()
    assert visible_samples(cube, samples, leaning, view, rng())[floor].any()


def test_a_wall_hides_what_is_behind_it_until_a_second_place_sees_there():
    surface = room(wall=((0.1, 3.0, 2.0), (2.0, 1.5, 1.0)))
    behind = np.array([[3.0, 1.5, 1.0], [0.5, 1.5, 1.0]])
    assert in_sight(surface, behind, places((1.0, 1.5, 1.0)), rng()).tolist() == [False, True]
    assert in_sight(surface, behind, places((1.0, 1.5, 1.0), (3.5, 1.0, 1.0)), rng()).all()


def test_voxels_told_free_inside_a_solid_are_wrong():
    surface = room(block=((1.0, 1.0, 1.0), (3.5, 2.5, 0.5)))
    free = np.concatenate([grid((1, 1, 1), (2, 2, 2)), grid((3.1, 2.1, 0.1), (4, 3, 0.9))])
    around = places((0.5, 0.5, 1.5), (3.5, 0.5, 1.8), (0.5, 2.5, 1.8))
    error, _ = volume_error(Voxels(shell()[0], free, R), surface, rng(), around)
    assert error.free_right == pytest.approx(1000 / len(free), abs=1e-9)


def test_what_cannot_be_judged_gets_a_sentence(tmp_path):
    with pytest.raises(EvaluationError, match="no occupied voxel"):
        volume_error(Voxels(np.empty((0, 3)), np.empty((0, 3)), R), room(), rng())
    with pytest.raises(EvaluationError, match="same frame"):
        volume_error(Voxels(np.array([[90.0, 0, 0]]), np.empty((0, 3)), R), room(), rng())
    with pytest.raises(EvaluationError, match="no such file"):
        read_surface(tmp_path / "none.stl")
    (tmp_path / "bad.stl").write_text("solid nothing")
    with pytest.raises(EvaluationError, match=r"bad\.stl"):
        read_surface(tmp_path / "bad.stl")
    with pytest.raises(EvaluationError, match="LOW < HIGH"):
        LidarView((15.0, -15.0))


def test_a_mesh_file_keeps_the_names_of_its_things(tmp_path):
    scene = trimesh.Scene()
    for name, size in (("hull", 2.0), ("ladder", 0.5)):
        scene.add_geometry(trimesh.creation.box((size,) * 3), node_name=name, geom_name=name)
    scene.export(str(tmp_path / "ship.glb"))
    surface = read_surface(tmp_path / "ship.glb")
    assert sorted(surface.names) == ["hull", "ladder"]
    assert len(surface.triangles_m) == 24


def test_a_world_that_simulation_tools_refuses_is_told_with_its_reason(tmp_path):
    pytest.importorskip("simulation_tools", reason="worlds are read by simulation_tools")
    (tmp_path / "bad.world").write_text("<sdf version='1.6'><world name='w'><model></world></sdf>")
    with pytest.raises(EvaluationError, match=r"bad\.world"):
        read_surface(tmp_path / "bad.world")


def test_a_world_of_sdf_is_read_with_its_models_as_things(tmp_path):
    pytest.importorskip("simulation_tools", reason="worlds are read by simulation_tools")
    (tmp_path / "one.world").write_text(
        "<sdf version='1.6'><world name='w'><model name='crate'><static>true</static>"
        "<pose>1 2 0.5 0 0 0</pose><link name='l'><collision name='c'>"
        "<geometry><box><size>1 1 1</size></box></geometry></collision></link></model></world></sdf>"
    )
    surface = read_surface(tmp_path / "one.world")
    assert surface.names == ("crate",)
    corners = surface.triangles_m.reshape(-1, 3)
    np.testing.assert_allclose([corners.min(axis=0), corners.max(axis=0)], [[0.5, 1.5, 0], [1.5, 2.5, 1]])
