"""Mesh files as other programs write them: no triangle is lost or bent, or one sentence refuses the file.

All areas are worked out by hand.
"""

import base64
import json
import struct
import zipfile

import numpy as np
import pytest

from mesh_files.errors import MeshFileError
from mesh_files.polygons import ears, has_inward_corner, triangulated
from mesh_files.reading import read_parts
from mesh_files.worlds import read_triangles

ANGLE = [(2, 0), (2, 1), (1, 1), (1, 2), (0, 2), (0, 0)]
"""Three squares of 1 m2; a fan from its first corner covers 4 m2."""
PAIR = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\n"
"""Two triangles of 0.5 m2."""


def area_m2(path, content):
    """Write a file; return the area of all that is read."""
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    corners = read_triangles(path).corners_m
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return 0.5 * np.linalg.norm(across, axis=1).sum()


def places(points, between="\n", begin=""):
    return "".join(f"{begin}{x} {y} 0{between}" for x, y in points)


PLY = (
    "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
    "element face {}\nproperty list uchar int vertex_indices\nend_header\n"
)
DAE = """<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset>{unit}</asset>
<library_geometries><geometry id="g"><mesh><source id="s">
<float_array id="a" count="18">{places}</float_array>
<technique_common><accessor source="#a" count="6" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#s"/></vertices>
<polylist count="1"><input semantic="VERTEX" source="#v" offset="0"/><vcount>6</vcount>
<p>0 1 2 3 4 5</p></polylist>
</mesh></geometry></library_geometries><library_visual_scenes><visual_scene id="c"><node id="n">
<instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#c"/></scene></COLLADA>"""
CONCAVE = {
    "a.obj": places(ANGLE, begin="v ") + "f 1 2 3 4 5 6\n",
    "b.obj": places(ANGLE, begin="v ") + "vt 0 0\nvn 0 0 1\nf 1/1/1 2/1/1 3/1/1 4/1/1 5/1/1 6/1/1\n",
    "a.off": "OFF\n6 1 0\n" + places(ANGLE) + "6 0 1 2 3 4 5\n",
    "a.ply": PLY.format(6, 1) + places(ANGLE) + "6 0 1 2 3 4 5\n",
    "a.dae": DAE.format(unit="", places=places(ANGLE, " ")),
}


@pytest.mark.table("name", CONCAVE)
def test_a_plate_with_an_inward_corner_covers_no_more_than_it_does(tmp_path, name):
    assert area_m2(tmp_path / name, CONCAVE[name]) == pytest.approx(3.0)


@pytest.mark.table("first", range(4))
def test_an_arrow_of_four_corners_from_each_of_them(first):
    arrow = np.roll(np.array(((0, 0, 0), (4, 0, 0), (1, 1, 0), (0, 4, 0)), float), first, axis=0)
    assert has_inward_corner(arrow[None]).tolist() == [True]
    corners = arrow[np.array(ears(arrow))]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert 0.5 * across[:, 2].sum() == pytest.approx(4.0)  # shoelace
    assert (across[:, 2] > 0.0).all()


def test_a_comb_of_many_teeth_in_a_slanting_plane_and_a_corner_on_a_straight_side():
    teeth = 6
    flat = [(0.0, -1.0), (2.0 * teeth, -1.0)]
    for k in reversed(range(teeth)):  # each tooth is 1 wide and 1 high, on a bar that is 1 high
        flat += [(2 * k + 2.0, 0.0), (2 * k + 1.0, 0.0), (2 * k + 1.0, 1.0), (2.0 * k, 1.0)]
        flat += [(2.0 * k, 0.0)]
    turn = np.linalg.qr(np.array(((1.0, 2.0, 0.5), (0.0, 1.0, 3.0), (2.0, 0.0, 1.0))))[0]
    corners = np.column_stack((np.array(flat), np.zeros(len(flat)))) @ turn.T
    triangles = corners[triangulated(corners, [list(range(len(flat)))])]
    across = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    assert 0.5 * np.linalg.norm(across, axis=1).sum() == pytest.approx(2.0 * teeth + teeth)


@pytest.mark.table(
    "content",
    [
        b"\xef\xbb\xbf" + PAIR.encode(),
        PAIR.encode("utf-16"),
        b"# Ger\xfcst\n" + PAIR.encode(),
        PAIR.replace("\n", "\r"),
        PAIR.replace("\n", "\r\n"),
        PAIR.replace(" ", "\t"),
        PAIR.replace("v 0 0 0\n", "v 0 0 0 # origin\n").replace("f 1 2 3\n", "f 1 2 3 # floor, 1\n"),
        PAIR.replace("f 1 2 3\n", "f 1 2 \\\n3\n"),
    ],
)
def test_obj_of_any_editor(tmp_path, content):
    assert area_m2(tmp_path / "a.obj", content) == pytest.approx(1.0)


STL = "".join(
    f"facet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  vertex 1 0 0\n  vertex {last}\n endloop\nendfacet\n"
    for last in ("0 1 0", "0 0 1")
)
STL = f"solid a\n{STL}endsolid a\n"


@pytest.mark.table(
    "content",
    [
        b"\xef\xbb\xbf" + STL.encode(),
        STL.encode("utf-16"),
        STL.replace("solid a", "solid Gerüst").encode("latin-1"),
        STL.replace("\n", "\r"),
        STL.replace("\n", " "),
        STL.upper().replace("\n", " "),
    ],
)
def test_text_stl_of_any_editor(tmp_path, content):
    assert area_m2(tmp_path / "a.stl", content) == pytest.approx(1.0)


TRIANGLES = b"".join(struct.pack("<12fH", 0, 0, 1, 0, 0, z, 1, 0, z, 0, 1, z, 0) for z in range(3))


@pytest.mark.table("head", [b"", b"exported", b"solid in Rhino"])
@pytest.mark.table(
    ("number", "behind"),
    [(0xFFFFFFFF, b""), (0, b""), (3, b""), (3, b"some bytes more"), (3, bytes(50)), (3, bytes(5000))],
)
def test_a_binary_stl_of_any_program(tmp_path, head, number, behind):
    """A header may begin with "solid", and a program may not have known the number when it began."""
    content = head.ljust(80, b"\0") + struct.pack("<I", number) + TRIANGLES + behind
    assert area_m2(tmp_path / "a.stl", content) == pytest.approx(1.5)


@pytest.mark.table("length", [83, 84, 100, 154, 233])
def test_a_binary_stl_that_is_cut_is_refused_as_cut(tmp_path, length):
    content = b"exported".ljust(80, b"\0") + struct.pack("<I", 3) + TRIANGLES
    (tmp_path / "a.stl").write_bytes(content[:length])
    with pytest.raises(MeshFileError, match="is cut"):
        read_parts(tmp_path / "a.stl")


def binary_ply(faces, tail=b""):
    """A square and a peak beside it: four corners, and one 1 m above the first."""
    head = PLY.format(5, len(faces)).replace("ascii", "binary_little_endian").encode()
    corners = np.array(((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1)), "<f4").tobytes()
    return head + corners + b"".join(struct.pack(f"<B{len(f)}i", len(f), *f) for f in faces) + tail


@pytest.mark.table(
    ("content", "told_m2"),
    [
        (binary_ply([(0, 1, 2, 3), (0, 1, 4)]), 1.5),
        (binary_ply([(0, 1, 2), (0, 2, 3)], b"\0" * 7), 1.0),
        (PLY.format(4, 1).replace("\n", "\r") + "0 0 0\r1 0 0\r1 1 0\r0 1 0\r4 0 1 2 3\r", 1.0),
        (
            PLY.format(4, 1).replace("face", "tristrips") + "0 0 0\n1 0 0\n0 1 0\n1 1 0\n4 0 1 2 3\n",
            1.0,
        ),
    ],
)
def test_ply_of_mixed_faces_and_with_more_bytes(tmp_path, content, told_m2):
    assert area_m2(tmp_path / "a.ply", content) == pytest.approx(told_m2)


@pytest.mark.table(("unit", "metres"), [("0,01", 0.01), ("1e-2", 0.01), (" 0.3048 ", 0.3048)])
def test_the_number_of_colladas_unit_counts_and_not_its_name(tmp_path, unit, metres):
    content = DAE.format(unit=f'<unit name="meter" meter="{unit}"/>', places=places(ANGLE, " "))
    assert area_m2(tmp_path / "a.dae", content) == pytest.approx(3.0 * metres**2)


@pytest.mark.table("signs", ["-1 1 1", "1 -1 1", "-1 -1 1", "1 1 1"])
def test_a_mirrored_node_keeps_its_outside(tmp_path, signs):
    content = DAE.format(unit="", places=places(ANGLE, " "))
    content = content.replace('<node id="n">', f'<node id="n"><scale>{signs}</scale>')
    (tmp_path / "a.dae").write_text(content)
    (part,) = read_parts(tmp_path / "a.dae")
    corners = part.vertices_m[part.triangles]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert 0.5 * across[:, 2].sum() == pytest.approx(3.0)  # its upper side stays above


def gltf(accessor=(), mode=4, extension=None):
    corners = np.array(((0, 0, 0), (1, 0, 0), (0, 1, 0)), "<f4")
    data = base64.b64encode(corners.tobytes()).decode()
    document = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "mode": mode}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", **dict(accessor)}],
        "bufferViews": [{"buffer": 0, "byteLength": corners.nbytes}],
        "buffers": [{"byteLength": corners.nbytes, "uri": f"data:application/octet-stream;base64,{data}"}],
    }
    return json.dumps({**document, **({"extensionsUsed": [extension]} if extension else {})})


@pytest.mark.table(
    ("name", "content", "words"),
    [
        ("a.gltf", gltf({"normalized": True}), "normalized"),
        ("a.gltf", gltf({"sparse": {}}), "sparse"),
        ("a.gltf", gltf(mode=6), "fans"),
        ("a.gltf", gltf(mode="fan"), "mode in entry 1 of primitives in entry 1 of meshes is 'fan'"),
        ("a.gltf", gltf().replace('"accessors": [', '"accessors": [], "a": ['), "no accessor 0"),
        ("a.gltf", gltf().replace('"primitives": [', '"primitives": ["a", '), "entry 1 of primitives"),
        ("a.gltf", gltf({"type": "SCALAR"}), "three numbers"),
        ("a.gltf", "[" * 100_000, "cut"),
        ("a.gltf", gltf(extension="KHR_draco_mesh_compression"), "compressed"),
        ("a.obj", PAIR.replace("f 1 2 3", "f 0 1 2"), "counts from 1"),
        ("a.obj", PAIR.replace("f 1 2 3", "f 1/1 0/1 2/1"), "counts from 1"),
        ("a.dae", DAE.format(unit='<unit meter="0"/>', places=places(ANGLE, " ")), "no length"),
        ("a.ply", binary_ply([(0, 1, 2), (0, 2, 3)])[:-1], "cut"),
        ("a.ply", binary_ply([(0, 1, 9)]), "does not exist"),
        ("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n", "cut"),
        ("a.fbx", "Kaydara FBX Binary", "kind that is not read"),
    ],
)
def test_what_would_be_read_wrong_is_refused(tmp_path, name, content, words):
    (tmp_path / name).write_bytes(content.encode() if isinstance(content, str) else content)
    with pytest.raises(MeshFileError, match=words):
        read_parts(tmp_path / name)


def test_a_plain_gltf_is_read(tmp_path):
    assert area_m2(tmp_path / "a.gltf", gltf()) == pytest.approx(0.5)


@pytest.mark.table("in_component", [True, False])
def test_3mf_whose_objects_stand_in_a_model_of_their_own(tmp_path, in_component):
    space = (
        'xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02" '
        'xmlns:p="http://schemas.microsoft.com/3dmanufacturing/production/2015/06"'
    )
    mesh = "".join(f'<vertex x="{x}" y="{y}" z="0"/>' for x, y in ((0, 0), (2, 0), (0, 2)))
    mesh = f'<mesh><vertices>{mesh}</vertices><triangles><triangle v1="0" v2="1" v3="2"/></triangles></mesh>'
    item = 'p:path="/3D/o.model" objectid="7" transform="2 0 0 0 2 0 0 0 2 0 0 0"'
    objects = f'<object id="1"><components><component {item}/></components></object>' if in_component else ""
    built = 'objectid="1"' if in_component else item
    files = {
        "_rels/.rels": '<Relationships xmlns="r"><Relationship Target="/3D/3dmodel.model" Type="x/3dmodel"/>'
        "</Relationships>",
        "3D/o.model": f'<model unit="meter" {space}><resources><object id="7">{mesh}</object></resources>'
        "<build/></model>",
        "3D/3dmodel.model": f'<model unit="meter" {space}><resources>{objects}</resources>'
        f"<build><item {built}/></build></model>",
    }
    with zipfile.ZipFile(tmp_path / "a.3mf", "w") as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    assert area_m2(tmp_path / "a.3mf", (tmp_path / "a.3mf").read_bytes()) == pytest.approx(8.0)
