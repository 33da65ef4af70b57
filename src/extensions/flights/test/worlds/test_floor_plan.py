"""The outlines of a world, against shapes whose sizes are known by hand."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from flights.worlds.floor_plan import convex_hull, outlines_of_file

UNIT_CM = '<unit meter="0.01" name="cm"/>'


@pytest.fixture
def outlined(tmp_path):
    """Return a function that writes a world of static models, each of one geometry, and outlines it."""

    def sizes(*geometries):
        models = "".join(
            f'<model name="m{number}"><static>1</static><link name="l"><collision name="c">'
            f"<geometry>{geometry}</geometry></collision></link></model>"
            for number, geometry in enumerate(geometries)
        )
        path = tmp_path / "w.world"
        path.write_text(f'<sdf version="1.6"><world name="w">{models}</world></sdf>')
        return [
            (o.outline_xy.max(axis=0) - o.outline_xy.min(axis=0)).tolist() for o in outlines_of_file(path)
        ]

    return sizes


def mesh(name):
    return f"<mesh><uri>{name}</uri></mesh>"


def test_the_unit_of_a_mesh_counts(outlined, tmp_path):
    # Given a box of 100 x 200 x 100 in a file whose unit is the centimetre
    text = trimesh.creation.box((100, 200, 100)).export(file_type="dae").decode()
    (tmp_path / "cm.dae").write_text(text.replace("<asset>", "<asset>" + UNIT_CM))
    # Then its outline is 1 x 2 m
    ((x_m, y_m),) = outlined(mesh("cm.dae"))
    assert (x_m, y_m) == pytest.approx((1.0, 2.0))


def test_an_open_mesh_has_an_outline_for_each_piece(outlined, tmp_path):
    open_box = trimesh.creation.box((1, 1, 1))
    open_box.update_faces(open_box.face_normals[:, 2] < 0.5)
    far = trimesh.creation.box((2, 3, 1)).apply_translation((9, 0, 0))
    trimesh.util.concatenate([open_box, far]).export(tmp_path / "open.stl")
    assert sorted(outlined(mesh("open.stl"))) == [pytest.approx([1.0, 1.0]), pytest.approx([2.0, 3.0])]


def test_hills_planes_and_what_cannot_be_read_have_none(outlined, tmp_path):
    (tmp_path / "bad.stl").write_bytes(b"nothing")
    hills = "<heightmap><uri>model://hills/materials/hills.png</uri><size>9 9 1</size></heightmap>"
    assert outlined(hills, "<plane/>", mesh("bad.stl"), mesh("none.stl")) == []


def test_the_hull_of_many_points_is_that_of_few():
    around = np.linspace(0.0, 2 * np.pi, 5000, endpoint=False)
    circle = np.column_stack((np.cos(around), np.sin(around)))
    inside = np.random.default_rng(1).uniform(-0.6, 0.6, (5000, 2))
    hull = convex_hull(np.concatenate((inside, circle)))
    assert len(hull) == 5000
    x, y = hull.T
    area = 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))  # positive: counter-clockwise
    assert area == pytest.approx(np.pi, rel=1e-5)


def test_many_points_on_a_line_have_their_ends():
    line = np.column_stack((np.arange(999.0, -1.0, -1.0), 2.0 * np.arange(999.0, -1.0, -1.0)))
    assert sorted(convex_hull(line).tolist()) == [[0.0, 0.0], [999.0, 1998.0]]
