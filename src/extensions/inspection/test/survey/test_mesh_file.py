"""Given meshes of other programs, the surface is theirs: its unit, its triangles, and its place."""

import struct
import tracemalloc

import numpy as np
import pytest
import trimesh

from flight_basics.errors import SurveyError
from inspection.camera.photograph_pose import PhotographPose
from inspection.findings.command import main as findings
from inspection.findings.placing import MeshSurface
from inspection.report.command import main as report
from inspection.survey import SurveyCamera, SurveyParameters
from inspection.survey.command import main as survey
from inspection.survey.coverage import coverage_of_file
from inspection.survey.surface.mesh_file import Mesh, read_mesh
from inspection.survey.surface.of_mesh import room_of_mesh
from inspection.survey.surface.samples import normals_of, samples_within
from inspection.survey.surface_record import read_surface_record, write_surface_record
from inspection.survey.views.candidates import View

FAR_M = np.array((100_000.0, -250_000.0, 30.0))


def area_m2(path):
    return normals_of(read_mesh(path).triangles_m)[1].sum()


COLLADA = """<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
  <asset>{unit}<up_axis>Z_UP</up_axis></asset>
  <library_geometries><geometry id="g" name="g"><mesh>
    <source id="p"><float_array id="a" count="12">{values}</float_array>
      <technique_common><accessor source="#a" count="4" stride="3">
        <param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/>
      </accessor></technique_common></source>
    <vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
    <triangles count="2"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2 0 2 3</p></triangles>
  </mesh></geometry></library_geometries>
  <library_visual_scenes><visual_scene id="s"><node id="n"><instance_geometry url="#g"/></node></visual_scene>
  </library_visual_scenes><scene><instance_visual_scene url="#s"/></scene>
</COLLADA>
"""


@pytest.mark.parametrize("metres", [1.0, 0.3048, 0.0254, 0.01, 0.5])
def test_collada_tells_its_unit(tmp_path, metres):
    """A plate of 6 x 4 m."""
    corners = np.array(((0, 0, 0), (6, 0, 0), (6, 4, 0), (0, 4, 0))) / metres
    unit = f'<unit name="u" meter="{metres}"/>' if metres != 1.0 else ""
    values = " ".join(f"{v:.9g}" for v in corners.ravel())
    (tmp_path / "plate.dae").write_text(COLLADA.format(unit=unit, values=values))
    assert area_m2(tmp_path / "plate.dae") == pytest.approx(24.0, rel=1e-5)


def test_an_unknown_unit_is_refused(tmp_path, monkeypatch):
    trimesh.creation.box().export(tmp_path / "box.stl")
    monkeypatch.setattr(trimesh.Scene, "units", property(lambda _: "furlong per week"))
    with pytest.raises(SurveyError, match="furlong per week"):
        read_mesh(tmp_path / "box.stl")


TRIANGLES = ((0, 0, 0, 6, 0, 0, 6, 4, 0), (0, 0, 0, 6, 4, 0, 0, 4, 0))
BODY = b"".join(struct.pack("<12fH", 0, 0, 1, *corners, 0) for corners in TRIANGLES)


@pytest.mark.parametrize("head", [b"exported", b"solid in Rhino"])
@pytest.mark.parametrize(
    ("told", "behind"), [(2, b""), (2, b"some bytes more"), (2, bytes(50)), (2, bytes(5000)), (0, b"")]
)
def test_bytes_behind_the_triangles_of_an_stl_do_no_harm(tmp_path, head, told, behind):
    """A header may begin with "solid", and a program may not have known the number when it began."""
    path = tmp_path / "plate.stl"
    path.write_bytes(head.ljust(80, b"\0") + struct.pack("<I", told) + BODY + behind)
    assert area_m2(path) == pytest.approx(24.0)


@pytest.mark.parametrize("length", [83, 84, 100, 154, 183])
def test_an_stl_that_is_cut_is_refused_as_cut(tmp_path, length):
    path = tmp_path / "plate.stl"
    path.write_bytes((b"exported".ljust(80, b"\0") + struct.pack("<I", 2) + BODY)[:length])
    with pytest.raises(SurveyError, match="is cut") as refused:
        read_mesh(path)
    assert "Module" not in str(refused.value)


FACET = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 6 0 0\nvertex 6 4 0\nendloop\nendfacet\n"


@pytest.mark.parametrize("encoding", ["utf-8", "latin-1"])
def test_an_stl_of_the_text_form_is_read_and_a_cut_one_is_refused(tmp_path, encoding):
    path = tmp_path / "plate.stl"
    path.write_bytes(f"solid Gerüst\n{FACET}endsolid Gerüst\n".encode(encoding))
    assert area_m2(path) == pytest.approx(12.0)
    path.write_bytes(f"solid Gerüst\n{FACET}{FACET[:50]}".encode(encoding))
    with pytest.raises(SurveyError, match="is cut"):
        read_mesh(path)


@pytest.mark.parametrize("name", ["a.obj", "a.ply", "a.glb", "a.dae", "a.stl"])
def test_what_is_no_mesh_is_refused_without_a_python_module(tmp_path, name):
    (tmp_path / name).write_bytes(bytes(range(256)) * 4)
    with pytest.raises(SurveyError) as refused:
        read_mesh(tmp_path / name)
    assert "No module" not in str(refused.value)


def test_an_obj_with_umlauts_of_another_code_page_is_read(tmp_path):
    path = room_file(tmp_path / "room.obj", np.zeros(3))
    path.write_bytes("# Gerüst\no Gerüst\n".encode("latin-1") + path.read_bytes())
    assert area_m2(path) == pytest.approx(108.0)


def room_file(path, offset_m):
    """A room of 6 x 4 x 3 m as OBJ, with millimetres."""
    box = trimesh.creation.box((6.0, 4.0, 3.0))
    corners = [f"v {x:.3f} {y:.3f} {z:.3f}" for x, y, z in box.vertices + offset_m]
    faces = [f"f {a} {b} {c}" for a, b, c in box.faces + 1]
    path.write_text("\n".join([*corners, *faces]) + "\n")
    return path


def test_a_drawing_far_from_the_origin_loses_nothing(tmp_path):
    camera, asked = (
        SurveyCamera(width=648, height=486),
        SurveyParameters(resolution=8.0, spacing=1.0, voxel=0.2),
    )
    found = []
    for offset_m in (np.zeros(3), FAR_M):
        mesh = room_file(tmp_path / "room.obj", offset_m)
        taken = [PhotographPose.of_view(View((offset_m[0] + 1.0, *offset_m[1:]), 0.0, 0.0))]
        coverage = coverage_of_file(mesh, taken, camera, asked, offset_m)
        found.append((coverage.points.areas_m2.sum(), coverage.reachable_m2, coverage.shown_m2))
        write_surface_record(tmp_path / "record.npz", coverage.record())
        back = read_surface_record(tmp_path / "record.npz")
        np.testing.assert_allclose(back.points_m, coverage.record().points_m, rtol=0.0, atol=1e-5)
    assert found[0][0] == pytest.approx(108.0, rel=0.01)
    assert found[1] == pytest.approx(found[0], rel=1e-3)


def test_what_a_photograph_shows_far_from_the_origin_is_placed_to_a_millimetre():
    wall = np.array([[(3.0, -9.0, -9.0), (3.0, 9.0, -9.0), (3.0, 0.0, 9.0)]]) + FAR_M
    rays = np.array(((1.0, 0.0, 0.0), (0.8, 0.6, 0.0)))
    points_m, _ = MeshSurface(wall).hits(FAR_M, rays)
    np.testing.assert_allclose(points_m - FAR_M, ((3.0, 0.0, 0.0), (3.0, 2.25, 0.0)), atol=1e-4)


def test_a_ground_of_a_kilometre_takes_the_memory_of_the_room_on_it():
    """All of it would be 625 million samples."""
    corners = 500.0 * np.array(((-1.0, -1.0, 0.0), (1.0, -1.0, 0.0), (1.0, 1.0, 0.0), (-1.0, 1.0, 0.0)))
    ground = corners[[(0, 1, 2), (0, 2, 3)]]
    room = trimesh.creation.box((8.0, 6.0, 3.0))
    room.apply_translation((30.0, 40.0, 1.5))
    mesh = Mesh(np.concatenate((ground, room.triangles)), ("ground", "room"), np.array([0] * 2 + [1] * 12))
    tracemalloc.start()
    found, samples, near = room_of_mesh(mesh, SurveyParameters(), np.array((30.0, 40.0, 1.5)))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 300e6
    on_ground = samples.areas_m2[mesh.part[near][samples.triangles] == 0].sum()
    box_m2 = (8.0 + 2 * 0.6) * (6.0 + 2 * 0.6)  # with EDGE_M at each side
    assert on_ground == pytest.approx(box_m2, rel=0.05)
    assert found.at(found.air, np.array([(30.0, 40.0, 1.5)])) == 1


@pytest.mark.parametrize(
    ("factor", "why"), [(1000.0, "too much for voxels"), (0.001, "less than two voxels")]
)
def test_a_mesh_in_millimetres_or_kilometres_is_refused(factor, why):
    room = trimesh.creation.box((6.0, 4.0, 3.0))
    mesh = Mesh(factor * np.array(room.triangles), ("room",), np.zeros(12, int))
    with pytest.raises(SurveyError, match=f"{why}.*check that its unit is the metre"):
        room_of_mesh(mesh, SurveyParameters())


@pytest.mark.parametrize("seed", range(3))
def test_triangles_that_are_cut_keep_their_area_in_the_box(seed):
    """By a slow reference: many random points on the triangle, and the share of them in the box."""
    rng = np.random.default_rng(seed)
    triangle = rng.uniform(-60.0, 60.0, (1, 3, 3)) * (1.0, 1.0, 0.1)
    low_m, high_m = np.full(3, -8.0), np.full(3, 8.0)
    samples = samples_within(triangle, 0.1, low_m, high_m)
    inside = ((samples.points_m >= low_m) & (samples.points_m <= high_m)).all(axis=1)
    weights = np.sort(rng.random((2_000_000, 2)), axis=1)
    weights = np.column_stack((weights[:, 0], np.diff(weights, axis=1), 1.0 - weights[:, 1]))
    drawn = weights @ triangle[0]
    share = ((drawn >= low_m) & (drawn <= high_m)).all(axis=1).mean()
    assert samples.areas_m2[inside].sum() == pytest.approx(
        share * normals_of(triangle)[1][0], rel=0.02, abs=0.2
    )
    assert (samples.triangles == 0).all()


@pytest.mark.parametrize(
    ("command", "words"),
    [(survey, ["plan"]), (survey, ["coverage"]), (findings, []), (report, [])],
    ids=["plan", "coverage", "findings", "report"],
)
def test_the_help_tells_the_axis_that_the_reader_turns(command, words, capsys):
    """glTF 2.0, 3.4: y is up."""
    with pytest.raises(SystemExit):
        command([*words, "--help"])
    assert "glTF or GLB (m, y up)" in " ".join(capsys.readouterr().out.split())
