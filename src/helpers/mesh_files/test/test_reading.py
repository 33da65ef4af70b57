"""Given meshes of other programs, the triangles are theirs, in metres, z up; or one sentence refuses them."""

import json
import struct
import zipfile
from pathlib import Path

import numpy as np
import pytest
import trimesh

from mesh_files.bodies import bodies_of
from mesh_files.errors import MeshFileError
from mesh_files.reading import read_parts
from mesh_files.worlds import is_first, read_triangles

SIZE_M = (6.0, 4.0, 3.0)
"""Of a box that stands on z = 0: x, y, z."""
CORNERS = np.array([(x, y, z) for x in (0.0, 6.0) for y in (0.0, 4.0) for z in (0.0, 3.0)])
BOX = trimesh.Trimesh(CORNERS, trimesh.creation.box().faces, process=False)


def bounds_m(path):
    """Return the lowest and the highest corner of all that is read."""
    corners = read_triangles(path).corners_m.reshape(-1, 3)
    return corners.min(axis=0), corners.max(axis=0)


def check_box(path):
    """The box of the drawing, with its area."""
    low_m, high_m = bounds_m(path)
    np.testing.assert_allclose(low_m, (0.0, 0.0, 0.0), atol=1e-6)
    np.testing.assert_allclose(high_m, SIZE_M, atol=1e-6)
    corners = read_triangles(path).corners_m
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert 0.5 * np.linalg.norm(across, axis=1).sum() == pytest.approx(2.0 * (24.0 + 18.0 + 12.0))


@pytest.mark.table("suffix", [".stl", ".obj", ".ply", ".glb", ".off", ".3mf"])
def test_a_box_of_each_kind(tmp_path, suffix):
    path = tmp_path / f"box{suffix}"
    if suffix == ".3mf":
        path = three_mf(path, "meter", CORNERS)
    else:
        BOX.export(path)
    check_box(path)


THREE_MF = """<?xml version="1.0" encoding="UTF-8"?>
<model unit="{unit}" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"><resources>
<object id="1" type="model">
<mesh><vertices>{vertices}</vertices><triangles>{triangles}</triangles></mesh></object>
<object id="2" type="model">
<components><component objectid="1" transform="{component}"/></components></object>
</resources><build><item objectid="2" transform="{item}"/></build></model>"""


def three_mf(path, unit, corners):
    """Write the box as 3MF, whose component is turned by a quarter about z and whose item is moved back."""
    moved = corners[:, (1, 0, 2)] * (1.0, -1.0, 1.0) + (7.0, 0.0, 0.0)  # y + 7, -x, z
    vertices = "".join(f'<vertex x="{x:.9g}" y="{y:.9g}" z="{z:.9g}"/>' for x, y, z in moved)
    turned, back = "0 1 0 -1 0 0 0 0 1 0 0 0", "1 0 0 0 1 0 0 0 1 0 -7 0"
    triangles = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in BOX.faces)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr(
            "3D/3dmodel.model",
            THREE_MF.format(unit=unit, vertices=vertices, triangles=triangles, component=turned, item=back),
        )
    return path


@pytest.mark.table(("unit", "metres"), [("millimeter", 1e-3), ("inch", 0.0254), ("foot", 0.3048)])
def test_3mf_tells_its_unit(tmp_path, unit, metres):
    check_box(three_mf(tmp_path / "box.3mf", unit, CORNERS / metres))


def collada(path, corners, axis="", metres=1.0):
    """Write the box as COLLADA 1.4."""
    up = f"<up_axis>{axis}</up_axis>" if axis else ""
    places = " ".join(f"{value:.9g}" for value in corners.ravel())
    faces = " ".join(map(str, BOX.faces.ravel()))
    path.write_text(f"""<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
  <asset><unit name="u" meter="{metres}"/>{up}</asset>
  <library_geometries><geometry id="g" name="g"><mesh>
    <source id="p"><float_array id="a" count="24">{places}</float_array>
      <technique_common><accessor source="#a" count="8" stride="3">
        <param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/>
      </accessor></technique_common></source>
    <vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
    <triangles count="12"><input semantic="VERTEX" source="#v" offset="0"/><p>{faces}</p></triangles>
  </mesh></geometry></library_geometries>
  <library_visual_scenes><visual_scene id="s"><node id="n"><instance_geometry url="#g"/></node></visual_scene>
  </library_visual_scenes><scene><instance_visual_scene url="#s"/></scene>
</COLLADA>
""")
    return path


@pytest.mark.table(
    ("axis", "order", "signs"),
    [
        ("Z_UP", (0, 1, 2), (1, 1, 1)),
        ("", (0, 1, 2), (1, 1, 1)),
        ("Y_UP", (0, 2, 1), (1, 1, -1)),  # the file's x, y, z are x, z, -y here
        ("X_UP", (2, 0, 1), (1, -1, -1)),  # z, -x, -y
    ],
)
def test_collada_tells_which_axis_is_up_in_feet(tmp_path, axis, order, signs):
    told = CORNERS[:, order] * signs / 0.3048
    check_box(collada(tmp_path / "box.dae", told, axis, 0.3048))


def test_the_simulator_ignores_the_axis_as_gazebo_does(tmp_path):
    path = collada(tmp_path / "box.dae", CORNERS, "Y_UP")
    (part,) = read_parts(path, turns=False)
    np.testing.assert_allclose(np.ptp(part.vertices_m, axis=0), SIZE_M)


@pytest.mark.table("kind", ["glb", "gltf"])
def test_gltf_is_y_up_but_for_trimesh(tmp_path, kind):
    """Blender writes x, z, -y; its nodes are moved and turned."""
    scene = trimesh.Scene()
    moved = trimesh.transformations.translation_matrix((0.0, 0.0, -4.0))
    turned = trimesh.transformations.rotation_matrix(-np.pi / 2, (1.0, 0.0, 0.0))  # z up to y up
    scene.add_geometry(
        BOX.copy().apply_translation((0.0, -4.0, 0.0)), node_name="hull", transform=moved @ turned
    )
    path = tmp_path / f"box.{kind}"
    if kind == "glb":
        held = scene.export(file_type="glb")
        (length,) = struct.unpack_from("<I", held, 12)
        text = json.loads(held[20 : 20 + length])
        rest = held[20 + length :]
        text["asset"]["generator"] = "Khronos glTF Blender I/O v4.2"
        told = json.dumps(text).encode()
        told += b" " * (-len(told) % 4)
        body = struct.pack("<I4s", len(told), b"JSON") + told + rest
        path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body)
    else:
        for name, held in scene.export(file_type="gltf").items():
            if name == "model.gltf":
                text = json.loads(held)
                del text["asset"]["generator"]
                held = json.dumps(text).encode()
            (tmp_path / ("box.gltf" if name == "model.gltf" else name)).write_bytes(held)
    low_m, high_m = bounds_m(path)
    np.testing.assert_allclose(np.ptp((low_m, high_m), axis=0), SIZE_M, atol=1e-6)
    assert low_m[2] == pytest.approx(0.0, abs=1e-6)


def test_obj_counts_from_behind_with_negative_indices(tmp_path):
    lines = []
    for triangle in CORNERS[BOX.faces]:
        lines += [f"v {x} {y} {z}" for x, y, z in triangle] + ["f -3 -2 -1"]
    (tmp_path / "box.obj").write_text("\n".join(lines))
    check_box(tmp_path / "box.obj")


def test_ply_of_the_other_byte_order(tmp_path):
    head = (
        "ply\nformat binary_big_endian 1.0\nelement vertex 8\nproperty double x\nproperty double y\n"
        "property double z\nelement face 12\nproperty list uchar int vertex_indices\nend_header\n"
    )
    faces = b"".join(struct.pack(">B3i", 3, *face) for face in BOX.faces.tolist())
    (tmp_path / "box.ply").write_bytes(head.encode() + CORNERS.astype(">f8").tobytes() + faces)
    check_box(tmp_path / "box.ply")


def with_commas(text):
    """As a program of another country writes numbers."""
    return text.replace(".", ",")


def test_decimal_commas_of_stl_and_obj(tmp_path):
    facets = []
    for triangle in CORNERS[BOX.faces]:
        corners = "\n".join(with_commas(f"vertex {x:.3f} {y:.3f} {z:.3f}") for x, y, z in triangle)
        facets.append(f"facet normal 0,0 0,0 1,0\nouter loop\n{corners}\nendloop\nendfacet")
    (tmp_path / "box.stl").write_text("solid Kasten, 2\n" + "\n".join(facets) + "\nendsolid Kasten, 2\n")
    check_box(tmp_path / "box.stl")
    lines = [with_commas(f"v {x:.3f} {y:.3f} {z:.3f}") for x, y, z in CORNERS]
    lines += ["f {} {} {}".format(*face) for face in (BOX.faces + 1).tolist()]
    (tmp_path / "box.obj").write_text("o Kasten\n" + "\n".join(lines))
    check_box(tmp_path / "box.obj")


@pytest.mark.table(
    ("name", "content", "words"),
    [
        ("a.stl", b"", "is empty"),
        ("a.stl", b"x" * 50, "is cut within its header"),
        ("a.stl", b"exported".ljust(80, b"\0") + struct.pack("<I", 9) + bytes(50), "is cut: 9 triangles"),
        ("a.stl", b"solid a\nfacet normal 0 0 1\nouter loop\n", "it has no endsolid"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nl 1 2\n", "no surface"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "a corner that does not exist"),
        ("a.obj", b"v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "none of its triangles has finite corners"),
        ("a.ply", b"ply\nformat ascii 1.0\n", "the PLY is cut or damaged"),
        ("a.glb", b"glTF", "cut within its header"),
        ("a.glb", struct.pack("<4sII", b"glTF", 1, 12), "a GLB of version 1"),
        (
            "a.glb",
            struct.pack("<4sII", b"glTF", 2, 99),
            "the GLB is cut: 99 bytes are told in its header, and 12",
        ),
        ("a.gltf", b'{"asset":', "is no glTF, or it is cut"),
        ("a.gltf", b'{"asset": {"version": "1.0"}}', 'is glTF "1.0"'),
        ("a.dae", b"<COLLADA><asset/></COLLADA>", "no visual scene"),
        (
            "a.dae",
            b'<COLLADA><instance_controller url="#s"/><instance_visual_scene url="#v"/></COLLADA>',
            "hangs on a skeleton",
        ),
        ("a.dae", b"<html></html>", "is a web page, not a mesh"),
        ("a.stl", b"  <!DOCTYPE html><title>404</title>" + b"<p>" * 40, "is a web page, not a mesh"),
        ("a.obj", b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 9\n", "git lfs pull"),
        ("a.3mf", b"PK\x03\x04", "is no whole 3MF"),
        ("a.step", b"ISO-10303-21;", "of a kind that is not read here"),
        ("a.dwg", b"AC1032", "of a kind that is not read here"),
    ],
)
def test_what_cannot_be_read_is_refused_in_a_sentence(tmp_path, name, content, words):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(MeshFileError, match=words) as refused:
        read_triangles(tmp_path / name)
    assert "No module" not in str(refused.value)
    assert "\n" not in str(refused.value)


def test_triangles_without_finite_corners_are_left_out_and_told(tmp_path, caplog):
    (tmp_path / "a.obj").write_text("v nan 0 0\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 2 3 4\nf 1 3 4\n")
    assert len(read_triangles(tmp_path / "a.obj").corners_m) == 1
    assert "left out 2 of 3 triangles" in caplog.text


def test_a_triangle_that_is_there_twice_counts_once_and_this_is_told(tmp_path, caplog):
    # The second one begins at another corner; the last one faces the other way, as the back of a thin plate
    lines = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv -0.0 0 0\nf 1 2 3\nf 2 3 4\nf 1 3 2\n"
    (tmp_path / "a.obj").write_text(lines)
    assert len(read_triangles(tmp_path / "a.obj").corners_m) == 2
    assert "left out 1 of 3 triangles, which are there twice" in caplog.text


def test_which_triangles_are_second_ones_is_what_a_comparison_of_corners_says():
    random = np.random.default_rng(1)
    corners = random.integers(0, 3, (400, 3, 2)).astype(float)
    corners = np.concatenate((corners, np.zeros((400, 3, 1))), axis=2)
    known, right = set(), []
    for each in corners.tolist():
        turns = {tuple(map(tuple, each[k:] + each[:k])) for k in range(3)}
        right.append(not turns & known)
        known |= turns
    assert 100 < sum(right) < 400
    np.testing.assert_array_equal(is_first(corners), right)


def test_a_file_that_is_not_there_and_too_many_triangles(tmp_path):
    with pytest.raises(MeshFileError, match="no such file"):
        read_triangles(Path("nowhere.stl"))
    BOX.export(tmp_path / "box.stl")
    with pytest.raises(MeshFileError, match="12 triangles, more than the 11"):
        read_triangles(tmp_path / "box.stl", most=11)


def test_bodies_are_told_apart_and_closed_ones_are_known():
    """A box 1 km away, as an STL in single precision has it; a sheet that ends in the air; a box of faces."""
    far = CORNERS[BOX.faces] + (1000.0, 1000.0, 0.0)
    sheet = np.array(
        (((20.0, 0, 0), (26.0, 0, 0), (26.0, 4.0, 0)), ((20.0, 0, 0), (26.0, 4.0, 0), (20.0, 4.0, 0)))
    )
    triangles_m = np.concatenate((far.astype(np.float32), sheet, CORNERS[BOX.faces]))
    bodies, is_closed = bodies_of(triangles_m)
    for first, last, closed in ((0, 12, True), (12, 14, False), (14, 26, True)):
        assert len(set(bodies[first:last])) == 1
        assert is_closed[bodies[first]] == closed
    assert len(is_closed) == 3
    # Faces of two things that touch are two bodies, and none of them is closed
    _, apart = bodies_of(CORNERS[BOX.faces], np.arange(12) // 6)
    assert not apart.any()
