"""Meshes that others made: submeshes, open meshes that move, and shapes whose files cannot be used."""

from __future__ import annotations

import math

import numpy as np
import pytest
import trimesh

from simulation_tools.geometry import Pose
from simulation_tools.sdf.elements import Mesh, World
from simulation_tools.sdf.parser import load_world, parse_model
from simulation_tools.world.bodies import BodyFactory
from simulation_tools.world.engine import WorldError
from simulation_tools.world.mesh_file import write_world_mesh
from simulation_tools.world.shapes import bullet_shapes
from simulation_tools.world.shapes.convex_parts import connected_pieces, convex_parts
from simulation_tools.world.shapes.meshes import mesh_of
from simulation_tools.world.shapes.terrain import MeshError
from simulation_tools.world.shapes.triangle_mesh import TriangleMesh
from simulation_tools.world.world import PhysicsWorld

TRIANGLE = "0 0 0 1 0 0 0 2 0"
GEOMETRY = (
    '<geometry id="{0}" name="{0}"><mesh><source id="{0}p"><float_array id="{0}a" count="9">'
    + TRIANGLE
    + '</float_array><technique_common><accessor source="#{0}a" count="3" stride="3">'
    '<param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/>'
    "</accessor></technique_common></source>"
    '<vertices id="{0}v"><input semantic="POSITION" source="#{0}p"/></vertices><triangles count="1">'
    '<input semantic="VERTEX" source="#{0}v" offset="0"/><p>0 1 2</p></triangles></mesh></geometry>'
)


@pytest.fixture
def two_nodes(tmp_path):
    """A COLLADA file in cm: the node `near` with an inner node at x = 3 and 200 cm, `far` at 600 cm."""
    path = tmp_path / "two.dae"
    path.write_text(
        '<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">'
        '<asset><unit meter="0.01" name="cm"/><up_axis>Z_UP</up_axis></asset><library_geometries>'
        + GEOMETRY.format("A")
        + GEOMETRY.format("B")
        + '</library_geometries><library_visual_scenes><visual_scene id="S">'
        '<node id="n" name="near"><translate>200 0 0</translate><instance_geometry url="#A"/>'
        '<node id="inner"><translate>100 0 0</translate><instance_geometry url="#B"/></node></node>'
        '<node id="f" name="far"><translate>600 0 0</translate><instance_geometry url="#B"/></node>'
        '</visual_scene></library_visual_scenes><scene><instance_visual_scene url="#S"/></scene></COLLADA>'
    )
    return str(path)


def first_corners(mesh):
    return sorted(mesh.vertices[mesh.triangles[:, 0], 0].tolist())


@pytest.mark.parametrize(
    ("submesh", "corners_m"), [("far", [6.0]), ("near", [2.0, 3.0]), ("", [2.0, 3.0, 6.0])]
)
def test_a_submesh_has_the_name_of_its_node(two_nodes, submesh, corners_m):
    # Gazebo's ColladaLoader names a submesh after the nearest node above that has a name.
    assert first_corners(mesh_of(Mesh(two_nodes, "u", submesh=submesh))) == pytest.approx(corners_m)


def test_a_centred_submesh_has_the_middle_of_its_box_in_the_origin(two_nodes):
    vertices = mesh_of(Mesh(two_nodes, "u", submesh="far", centred=True)).vertices
    np.testing.assert_allclose(vertices.min(axis=0), (-0.005, -0.01, 0), atol=1e-12)
    np.testing.assert_allclose(vertices.max(axis=0), (0.005, 0.01, 0), atol=1e-12)


def test_the_submesh_of_an_obj_file_is_its_object_or_group(tmp_path):
    path = tmp_path / "two.obj"
    path.write_text(
        "o first\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\ng second\nv 7 0 0\nv 8 0 0\nv 7 1 0\nf 4 5 6\n"
    )
    assert mesh_of(Mesh(str(path), "u", submesh="second")).vertices[:, 0].min() == 7.0
    assert len(mesh_of(Mesh(str(path), "u")).triangles) == 2


def test_a_submesh_that_is_not_there_is_said(two_nodes):
    with pytest.raises(MeshError, match='no submesh "other"'):
        mesh_of(Mesh(two_nodes, "u", submesh="other"))


def test_the_elements_of_a_submesh_are_read(tmp_path, two_nodes):
    part = "<submesh><name>far</name><center>true</center></submesh>"
    text = (
        '<sdf version="1.6"><model name="m"><link name="l"><visual name="v"><geometry><mesh>'
        f"<uri>file://{two_nodes}</uri>{part}</mesh></geometry></visual></link></model></sdf>"
    )
    model = parse_model(text, "t", [tmp_path])
    assert model.links[0].visuals[0].geometry == Mesh(
        two_nodes, f"file://{two_nodes}", submesh="far", centred=True
    )
    assert model.warnings == ()
    whole = parse_model(text.replace("far", "__default__"), "t", [tmp_path])
    assert whole.links[0].visuals[0].geometry.submesh == ""


def mesh(solid):
    return TriangleMesh(np.asarray(solid.vertices, float), np.asarray(solid.faces, np.int32))


def gate():
    """A square frame of 4 x 4 m with an opening of 3 x 3 m, one piece."""
    outer, inner = (
        np.array(((-2, -2), (2, -2), (2, 2), (-2, 2.0))),
        0.75 * np.array(((-2, -2), (2, -2), (2, 2), (-2, 2.0))),
    )
    ring = np.array([(x, y, z) for z in (-0.1, 0.1) for x, y in (*outer, *inner)])
    faces = []
    for k in range(4):
        a, b, c, d = k, (k + 1) % 4, 4 + (k + 1) % 4, 4 + k
        faces += [(a, c, b), (a, d, c), (8 + a, 8 + b, 8 + c), (8 + a, 8 + c, 8 + d)]
        faces += [(a, b, 8 + b), (a, 8 + b, 8 + a), (d, 8 + c, c), (d, 8 + d, 8 + c)]
    return TriangleMesh(ring, np.array(faces, np.int32))


def test_what_is_convex_is_one_part_even_if_it_repeats_its_corners_or_is_flat():
    box, ball = trimesh.creation.box((1, 2, 3)), trimesh.creation.icosphere()
    torn = TriangleMesh(box.vertices[box.faces].reshape(-1, 3), np.arange(36, dtype=np.int32).reshape(-1, 3))
    plate = TriangleMesh(
        np.array(((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0.0))), np.array(((0, 1, 2), (0, 2, 3)))
    )
    for shape, corners in ((mesh(box), 8), (torn, 8), (mesh(ball), 642), (plate, 4)):
        (part,), is_filled = convex_parts(shape)
        assert (len(part), is_filled) == (corners, False)


def test_pieces_that_do_not_touch_are_parts_of_their_own():
    far = trimesh.creation.box((1, 1, 1)).apply_translation((5, 0, 0))
    pair = mesh(trimesh.util.concatenate([trimesh.creation.box((1, 1, 1)), far]))
    parts, _ = convex_parts(pair)
    assert sorted(part[:, 0].mean() for part in parts) == pytest.approx([0.0, 5.0])
    assert [len(piece) for piece in connected_pieces(pair)] == [12, 12]


def test_a_concave_piece_becomes_a_slab_behind_each_triangle():
    parts, is_filled = convex_parts(gate())
    assert (len(parts), is_filled) == (32, False)
    for part in parts:  # no part reaches into the opening of 3 x 3 m
        assert not (np.abs(part[:, :2]).max(axis=1) < 1.5 - 1e-9).any()


def test_an_open_box_is_not_filled_up():
    box = trimesh.creation.box((1, 1, 1))
    open_box = TriangleMesh(box.vertices, box.faces[box.face_normals[:, 2] < 0.5].astype(np.int32))
    assert len(convex_parts(open_box)[0]) == 10


@pytest.fixture
def gate_file(tmp_path):
    trimesh.Trimesh(gate().vertices, gate().triangles, process=False).export(tmp_path / "gate.stl")
    return tmp_path / "gate.stl"


def moving(geometry, more=""):
    return parse_model(
        '<sdf version="1.6"><model name="m"><link name="l"><gravity>0</gravity><collision name="c">'
        f"<geometry>{geometry}</geometry></collision>{more}</link></model></sdf>",
        "t",
        ["/tmp"],
    )


def test_a_gate_that_moves_is_open_for_bodies_as_for_rays(gate_file, build):
    world = build(gravity=(0.0, 0.0, 0.0))
    world.spawn(parse_gate(gate_file), "gate", Pose())
    ball = moving("<sphere><radius>0.5</radius></sphere>")
    world.spawn(ball, "ball", Pose.from_xyz_rpy(0, 0, 0))
    assert world.clearance("ball", None, 5.0) == pytest.approx(1.0, abs=2e-3)
    in_the_bar = Pose.from_xyz_rpy(1.75, 0, 0)
    assert world.clearance("ball", in_the_bar, 5.0) < 0.0
    world.step()
    assert world.contacts("ball") == []


def parse_gate(path):
    text = (
        '<sdf version="1.6"><model name="gate"><link name="l"><collision name="c"><geometry><mesh>'
        f"<uri>file://{path}</uri></mesh></geometry></collision></link></model></sdf>"
    )
    return parse_model(text, "t", [path.parent])


def test_the_clearance_to_a_mesh_of_100_000_triangles_is_right(tmp_path, build):
    """All of its triangles are within the greatest distance. PyBullet must not be asked for all of them."""
    trimesh.creation.icosphere(6, 2.0).export(tmp_path / "cave.stl")
    text = (
        '<sdf version="1.6"><model name="cave"><static>true</static><link name="l"><collision name="c">'
        f"<geometry><mesh><uri>file://{tmp_path}/cave.stl</uri></mesh></geometry></collision></link></model></sdf>"
    )
    world = build(parse_model(text, "t", [str(tmp_path)]))
    world.spawn(moving("<sphere><radius>0.2</radius></sphere>"), "ball", Pose())
    for at_m in ((0.5, 0.0, 0.0), (0.0, -0.9, 1.2), (4.4, 0.0, 0.0)):
        nearest_m = abs(2.0 - math.hypot(*at_m)) - 0.2
        assert world.clearance("ball", Pose(at_m), 5.0) == pytest.approx(nearest_m, abs=2e-3)
        assert world.clearance("ball", Pose(at_m), nearest_m - 0.01) == math.inf


def test_a_concave_mesh_with_too_many_triangles_is_filled_up_and_this_is_said(gate_file, monkeypatch):
    monkeypatch.setattr(bullet_shapes, "MAX_SLABS", 31)
    world = PhysicsWorld(World("w", (parse_gate(gate_file),)))
    try:
        (remark,) = world.remarks
        assert remark.startswith(f"{gate_file}: The mesh belongs to a model that moves")
    finally:
        world.close()


def test_a_part_that_moves_may_have_any_number_of_shapes(build):
    size = "<box><size>0.5 0.5 0.5</size></box>"
    shapes = "".join(
        f'<collision name="c{k}"><pose>{k} 0 0 0 0 0</pose><geometry>{size}</geometry></collision>'
        for k in range(1, 40)
    )
    world = build(gravity=(0.0, 0.0, 0.0))
    world.spawn(moving(size, shapes), "row", Pose())
    world.spawn(moving("<sphere><radius>0.1</radius></sphere>"), "ball", Pose())
    for x in (1.0, 14.0, 15.0, 39.0):  # physics takes the last ones from a file
        place = Pose.from_xyz_rpy(x, 0, 1)
        assert world.clearance("ball", place, 5.0) == pytest.approx(1.0 - 0.25 - 0.1, abs=2e-3)
        beside = Pose.from_xyz_rpy(x + 0.5, 0, 0)
        assert world.clearance("ball", beside, 5.0) == pytest.approx(0.25 - 0.1, abs=2e-3)


@pytest.fixture
def half_good(tmp_path):
    """A world of a model with a good and a bad shape, and of a plane that is not static."""
    (tmp_path / "bad.stl").write_bytes(b"nothing")
    good = '<collision name="g"><geometry><box><size>1 1 1</size></box></geometry></collision>'
    bad = "<geometry><mesh><uri>bad.stl</uri></mesh></geometry>"
    path = tmp_path / "w.world"
    path.write_text(
        '<sdf version="1.6"><world name="w"><model name="half"><static>1</static><link name="l">'
        f'{good}<collision name="b">{bad}</collision><visual name="v">{bad}</visual></link></model>'
        '<model name="falling"><link name="l"><collision name="c"><geometry><plane/></geometry></collision>'
        "</link></model></world></sdf>"
    )
    return path


def test_what_cannot_be_built_is_left_out_and_said(half_good, monkeypatch):
    def refuse(factory, name, *_):
        if name == "falling":
            raise WorldError("PyBullet refused.")
        return create(factory, name, *_)

    create = BodyFactory.create
    monkeypatch.setattr(BodyFactory, "create", refuse)
    world = PhysicsWorld(load_world(half_good, []), drawn=True)
    try:
        assert world.model_names() == ["half"]
        shape, fixed, model = world.remarks
        assert shape.startswith('A shape of the model "half" is left out: ')
        assert fixed.startswith('The model "falling" stays where it is')
        assert model == 'The model "falling" is left out: PyBullet refused.'
        ray = np.array(((1.0, 0, 0),))
        assert world.rays.cast(np.array((-3.0, 0, 0)), ray, 9.0)[0] == pytest.approx(2.5)
    finally:
        world.close()


PLANE = '<collision name="ground"><geometry><plane/></geometry></collision>'
BOX = '<collision name="box"><geometry><box><size>0.2 0.2 0.2</size></box></geometry></collision>'


@pytest.fixture
def forgotten(tmp_path):
    """A function that loads a world with a ball at 3 m, over a model at 2 m that is not static."""

    def loaded(shapes):
        path = tmp_path / "w.world"
        ball = BOX.replace("box><size>0.2 0.2 0.2</size></box", "sphere><radius>0.1</radius></sphere")
        path.write_text(
            '<sdf version="1.6"><world name="w">'
            f'<model name="ball"><pose>0 0 3 0 0 0</pose><link name="l">{ball}</link></model>'
            f'<model name="stage"><pose>9 0 2 0 0 0</pose><link name="l">{shapes}</link></model>'
            "</world></sdf>"
        )
        return PhysicsWorld(load_world(path, []))

    return loaded


def test_a_plane_of_a_model_that_is_not_static_stays_where_it_is_and_that_is_said(forgotten):
    """In Gazebo, too: a plane has no body."""
    world = forgotten(PLANE)
    try:
        (said,) = world.remarks
        assert said.startswith('The model "stage" stays where it is')
        assert "a plane does not move" in said
        for _ in range(1000):
            world.step()
        assert world.get_state("stage").pose.position_m == (9.0, 0.0, 2.0)
        assert world.get_state("ball").pose.position_m[2] == pytest.approx(2.1, abs=2e-3)
    finally:
        world.close()


def test_a_model_that_moves_and_has_a_plane_moves_without_it_and_that_is_said(forgotten):
    world = forgotten(PLANE + BOX)
    try:
        (said,) = world.remarks
        assert 'the plane "ground" cannot move' in said
        for _ in range(100):
            world.step()
        time_s = 100 * world.settings.time_step_s
        fallen_m = 0.5 * 9.81 * time_s**2
        height_m = world.get_state("stage").pose.position_m[2]
        assert height_m == pytest.approx(2.0 - fallen_m, abs=0.03 * fallen_m)
    finally:
        world.close()


def test_a_mesh_of_such_a_world_has_the_rest(half_good, tmp_path):
    assert write_world_mesh(half_good, tmp_path / "w.glb") == ["half", "falling"]


def test_the_limit_of_triangles_is_that_of_a_part(gate_file, monkeypatch):
    """Of two gates on one link, the second one is beyond the limit."""
    monkeypatch.setattr(bullet_shapes, "MAX_SLABS", 40)
    text = (
        '<sdf version="1.6"><model name="gates"><link name="l">'
        + "".join(
            f'<collision name="c{k}"><pose>0 0 {k} 0 0 0</pose><geometry><mesh><uri>file://{gate_file}</uri></mesh>'
            "</geometry></collision>"
            for k in range(2)
        )
        + "</link></model></sdf>"
    )
    world = PhysicsWorld(World("w", (parse_model(text, "t", [gate_file.parent]),), (0.0, 0.0, 0.0)))
    try:
        world.spawn(moving("<sphere><radius>0.1</radius></sphere>"), "ball", Pose.from_xyz_rpy(0, 0, 9))
        assert len(world.remarks) == 1
        assert world.clearance("ball", Pose(), 5.0) > 0.0
        assert world.clearance("ball", Pose.from_xyz_rpy(0, 0, 1), 5.0) < 0.0
    finally:
        world.close()
