"""Given meshes of other programs, the surface is theirs: its unit, its triangles, and its place."""

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
from inspection.survey.surface.of_mesh import room_of_mesh, sides_in_air
from inspection.survey.surface.samples import normals_of, samples_within
from inspection.survey.surface_record import read_surface_record, write_surface_record
from inspection.survey.views.candidates import View

FAR_M = np.array((100_000.0, -250_000.0, 30.0))


def test_an_unknown_unit_is_refused(tmp_path, monkeypatch):
    trimesh.creation.box().export(tmp_path / "box.stl")
    monkeypatch.setattr(trimesh.Scene, "units", property(lambda _: "furlong per week"))
    with pytest.raises(SurveyError, match="furlong per week"):
        read_mesh(tmp_path / "box.stl")


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


@pytest.mark.parametrize("half_m", [500.0, 50.0])
def test_a_wide_ground_takes_the_memory_of_the_room_on_it(half_m):
    """All of the ground would be 625 or 6 million samples, and 1.6 GB."""
    corners = half_m * np.array(((-1.0, -1.0, 0.0), (1.0, -1.0, 0.0), (1.0, 1.0, 0.0), (-1.0, 1.0, 0.0)))
    ground = corners[[(0, 1, 2), (0, 2, 3)]]
    room = trimesh.creation.box((8.0, 6.0, 3.0))
    room.apply_translation((30.0, 40.0, 1.5))
    mesh = Mesh(np.concatenate((ground, room.triangles)), ("ground", "room"), np.array([0] * 2 + [1] * 12))
    tracemalloc.start()
    found, samples, near = room_of_mesh(mesh, SurveyParameters(), np.array((30.0, 40.0, 1.5)))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 300e6
    sides = sides_in_air(mesh, found, samples, near)
    walls_m2 = 2.0 * (8.0 * 6.0 + 8.0 * 3.0 + 6.0 * 3.0)  # and the ground under its floor
    assert sides.areas_m2.sum() == pytest.approx(walls_m2 + 8.0 * 6.0, rel=0.02)
    assert found.at(found.air, np.array([(30.0, 40.0, 1.5)])) == 1


@pytest.mark.table(("factor", "why"), [(1000.0, "too much for voxels"), (0.001, "less than two voxels")])
def test_a_mesh_in_millimetres_or_kilometres_is_refused(factor, why):
    room = trimesh.creation.box((6.0, 4.0, 3.0))
    mesh = Mesh(factor * np.array(room.triangles), ("room",), np.zeros(12, int))
    with pytest.raises(SurveyError, match=f"{why}.*check that its unit is the metre"):
        room_of_mesh(mesh, SurveyParameters())


@pytest.mark.table("seed", range(3))
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


@pytest.mark.table(
    ("command", "words"),
    [(survey, ["plan"]), (survey, ["coverage"]), (findings, []), (report, [])],
)
def test_the_help_tells_the_axis_that_the_reader_turns(command, words, capsys):
    """glTF 2.0, 3.4: y is up."""
    with pytest.raises(SystemExit):
        command([*words, "--help"])
    assert "glTF or GLB (m, y up)" in " ".join(capsys.readouterr().out.split())
