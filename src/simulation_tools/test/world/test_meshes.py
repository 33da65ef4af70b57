"""Meshes of primitives: closed, outward, and as close to the true surface as they claim."""

from __future__ import annotations

import math

import numpy as np
import pytest
import trimesh

from simulation_tools.sdf.elements import Box, Cylinder, Mesh, Plane, Sphere
from simulation_tools.world.shapes.meshes import SAGITTA_M, mesh_of
from simulation_tools.world.shapes.terrain import MeshError


def as_trimesh(mesh):
    return trimesh.Trimesh(mesh.vertices, mesh.triangles, process=False)


@pytest.mark.table(
    ("geometry", "volume", "lost"),
    [
        (Box((1.0, 2.0, 3.0)), 6.0, 0.0),
        # Under a surface of area A that lies at most SAGITTA_M deeper, at most A x SAGITTA_M is lost.
        (Cylinder(0.2, 6.0), math.pi * 0.04 * 6.0, 2 * math.pi * 0.2 * 6.0 * SAGITTA_M),
        (Cylinder(5.0, 1.0), math.pi * 25.0, 2 * math.pi * 5.0 * SAGITTA_M),
        (Cylinder(0.0005, 1.0), math.pi * 0.0005**2, 1e-6),
        (Sphere(0.5), 4 / 3 * math.pi * 0.125, 4 * math.pi * 0.25 * SAGITTA_M),
        (Sphere(3.0), 36 * math.pi, 36 * math.pi * SAGITTA_M),
    ],
)
def test_a_solid_is_closed_points_outward_and_has_its_volume(geometry, volume, lost):
    mesh = as_trimesh(mesh_of(geometry))
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert volume - lost - 1e-9 <= mesh.volume <= volume + 1e-9


@pytest.mark.table("radius", [0.05, 0.3, 2.0, 20.0])
def test_facets_lie_within_the_tolerance_under_the_true_surface(radius):
    sphere = mesh_of(Sphere(radius))
    depth = radius - np.linalg.norm(sphere.vertices[sphere.triangles].mean(axis=1), axis=1)
    assert depth.min() >= -1e-9
    assert depth.max() <= SAGITTA_M
    cylinder = mesh_of(Cylinder(radius, 1.0))
    ring = cylinder.vertices[cylinder.vertices[:, 2] > 0][:-1, :2]
    middles = 0.5 * (ring + np.roll(ring, 1, axis=0))
    assert radius - np.linalg.norm(middles, axis=1).min() <= SAGITTA_M


def test_a_plane_faces_along_its_normal():
    normal = np.array((1.0, 2.0, 2.0)) / 3.0
    mesh = as_trimesh(mesh_of(Plane(tuple(normal))))
    np.testing.assert_allclose(mesh.face_normals, [normal, normal], atol=1e-9)
    assert mesh.area > 1e6


@pytest.mark.table("suffix", ["stl", "obj", "dae"])
def test_a_mesh_file_of_each_kind_is_read_and_scaled(tmp_path, suffix):
    path = tmp_path / f"box.{suffix}"
    trimesh.creation.box((1.0, 2.0, 3.0)).export(path)
    mesh = mesh_of(Mesh(str(path), "x", (1.0, 1.0, 2.0)))
    np.testing.assert_allclose(np.ptp(mesh.vertices, axis=0), (1.0, 2.0, 6.0), atol=1e-6)


def test_a_collada_files_unit_counts_but_not_its_up_axis_as_in_gazebo(tmp_path):
    path = tmp_path / "box.dae"
    trimesh.creation.box((100.0, 200.0, 300.0)).export(path)
    text = path.read_text()
    assert "<up_axis>Y_UP</up_axis>" in text
    unit = '<unit name="centimeter" meter="0.01"/>'
    path.write_text(text.replace("<up_axis>", unit + "<up_axis>"))
    mesh = mesh_of(Mesh(str(path), "x"))
    np.testing.assert_allclose(np.ptp(mesh.vertices, axis=0), (1.0, 2.0, 3.0), atol=1e-6)


def test_a_mesh_beyond_any_world_is_refused(tmp_path):
    path = tmp_path / "box.stl"
    trimesh.creation.box((1.0, 2.0, 3.0)).export(path)
    with pytest.raises(MeshError, match="larger than 1e"):
        mesh_of(Mesh(str(path), "x", (1e6, 1e6, 1e6)))


@pytest.mark.table("content", [b"", b"solid x\nendsolid x\n", b"\x00" * 84, b"not a mesh at all"])
@pytest.mark.table("suffix", ["stl", "obj", "dae"])
def test_a_broken_mesh_file_gives_one_sentence(tmp_path, suffix, content):
    path = tmp_path / f"broken.{suffix}"
    path.write_bytes(content)
    with pytest.raises(MeshError) as caught:
        mesh_of(Mesh(str(path), "x"))
    assert str(caught.value).startswith(f"{path}: The mesh ")
    assert "\n" not in str(caught.value)
