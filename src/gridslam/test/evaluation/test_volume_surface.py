"""Given a mesh in feet, or far from the origin, the evaluation measures the same surface."""

import numpy as np
import pytest
import trimesh

from gridslam.evaluation.volume.surface import read_surface


@pytest.mark.table(("unit", "metres"), [("feet", 0.3048), ("0.5 * meters", 0.5), (None, 1.0)])
def test_a_mesh_that_tells_its_unit_is_in_metres(tmp_path, monkeypatch, unit, metres):
    trimesh.creation.box((6.0, 4.0, 3.0)).export(tmp_path / "box.stl")
    monkeypatch.setattr(trimesh.Scene, "units", property(lambda _: unit))
    found = read_surface(tmp_path / "box.stl").triangles_m.reshape(-1, 3)
    np.testing.assert_allclose(np.ptp(found, axis=0), metres * np.array((6.0, 4.0, 3.0)), rtol=1e-6)


def test_rays_are_exact_far_from_the_origin(tmp_path):
    far_m = np.array((100_000.0, -250_000.0, 30.0))
    box = trimesh.creation.box((6.0, 4.0, 3.0))
    corners = [f"v {x} {y} {z}" for x, y, z in box.vertices + far_m]
    faces = [f"f {a} {b} {c}" for a, b, c in box.faces + 1]
    (tmp_path / "box.obj").write_text("\n".join([*corners, *faces]))
    surface = read_surface(tmp_path / "box.obj")
    ranges_m = surface.ranges_m(far_m + np.array([(0.123, 0.0, 0.0)]), np.array([(1.0, 0.0, 0.0)]))
    assert ranges_m[0] == pytest.approx(2.877, abs=1e-4)
