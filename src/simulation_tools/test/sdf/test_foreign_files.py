"""Files that others wrote: the text as TinyXML reads it, uris, states, joints and gravity of old versions.

The expected values are Gazebo 11's: TinyXML 2.6's parser, sdformat 9's converters, ``gazebo/physics``.
"""

from __future__ import annotations

import numpy as np
import pytest

from simulation_tools.sdf.elements import Box, Cylinder, Mesh, Sphere
from simulation_tools.sdf.parser import SdfError, load_model, load_world
from simulation_tools.world.shapes.meshes import mesh_of

BOX = "<geometry><box><size>1 2 3</size></box></geometry>"
LINK = f'<link name="l"><collision name="c">{BOX}</collision></link>'
MODEL = f'<model name="m">{LINK}</model>'


@pytest.fixture
def read(tmp_path):
    """Return a function that writes and reads the text of a world file."""

    def loaded(text, version="1.6"):
        path = tmp_path / "w.world"
        whole = text if "<sdf" in text else f'<sdf version="{version}"><world name="w">{text}</world></sdf>'
        path.write_bytes(whole.encode())
        return load_world(path, [tmp_path])

    return loaded


def put_model(folder, body=LINK, version="1.6"):
    folder.mkdir(parents=True)
    (folder / "model.config").write_text(f'<model><sdf version="{version}">model.sdf</sdf></model>')
    (folder / "model.sdf").write_text(f'<sdf version="{version}"><model name="x">{body}</model></sdf>')


@pytest.mark.table(
    "text",
    [
        "<world name='w'><audio>a&nbsp;b</audio>MODEL</world>",  # an entity that nobody declares
        "<world name='w'><light name='a < b > c & d' type='point'/>MODEL</world>",
        "<world name='w'><light name='a'type='point'/>MODEL</world>",
        "<world name='w'><!-- \x0c -->MODEL<audio>\x0b]]></audio></world>",
        "<world name='w'><audio a:b='1'><a:b/></audio>MODEL</world>",
        "<world name='w'><audio><![CDATA[ & <sdf> -- ]]>&nbsp;</audio>MODEL</world >",
    ],
)
@pytest.mark.table(("before", "behind"), [("", ""), ("<other/>\n", "\n<sdf version='1.6'/> rest <a")])
def test_what_tinyxml_takes_is_read(read, text, before, behind):
    world = read(f"{before}<sdf version='1.6'>{text.replace('MODEL', MODEL)}</sdf>{behind}")
    assert [model.name for model in world.models] == ["m"]
    assert world.models[0].links[0].collisions[0].geometry == Box((1.0, 2.0, 3.0))


@pytest.mark.table("bad", ["<a b/>", "<a b='c>", "<a>", "</a>", "<a></b>", "<!-- a"])
def test_what_tinyxml_does_not_take_either_is_refused(read, bad):
    with pytest.raises(SdfError, match=r"w\.world:[12]: The file is not well-formed XML"):
        read(f"<sdf version='1.6'><world name='w'>\n{bad}{MODEL}</world></sdf>")


def test_a_name_keeps_its_entities(read):
    text = MODEL.replace('"m"', '"a&amp;b&deg;&#65;"') + "<audio>&nbsp;</audio>"
    assert read(text).models[0].name == "a&b&deg;A"


@pytest.mark.table(
    ("body", "version", "gravity"),
    [
        ("<physics><gravity>0 0 -1.6</gravity></physics>", "1.4", -1.6),
        ("<physics/><physics><gravity>0 0 -1.6</gravity></physics>", "1.5", -1.6),
        ("<gravity>0 0 -3</gravity>", "1.6", -3.0),
        ("<physics><gravity>0 0 -1.6</gravity></physics>", "1.6", -9.8),  # no element of this version
    ],
)
def test_gravity_stands_in_physics_until_sdf_1_5(read, body, version, gravity):
    world = read(body, version)
    assert world.gravity_m_s2 == (0.0, 0.0, gravity)
    assert bool(world.warnings) == (gravity == -9.8)


def test_a_joint_may_name_the_world_as_its_child(read):
    joint = '<joint name="j" type="fixed"><parent>l</parent><child>world</child></joint>'
    world = read(MODEL.replace("</model>", joint + "</model>"))
    (found,) = world.models[0].joints
    assert (found.parent, found.child, world.warnings) == ("world", "l", ())


def test_a_joint_without_a_child_is_left_out_alone(read):
    joint = '<joint name="j" type="fixed"><parent>l</parent></joint>'
    world = read(MODEL.replace("</model>", joint + "</model>"))
    assert [(model.name, model.joints) for model in world.models] == [("m", ())]
    assert "has no <child>" in world.warnings[0]


def test_a_state_scales_shapes_where_they_stand(read):
    def shape(name, what):
        return f'<collision name="{name}"><pose>1 0 0 0 0 0</pose><geometry>{what}</geometry></collision>'

    shapes = shape("b", "<box><size>1 1 1</size></box>") + shape("s", "<sphere><radius>1</radius></sphere>")
    shapes += shape("c", "<cylinder><radius>1</radius><length>1</length></cylinder>")
    state = "<state><model name='m'><pose>0 0 0 0 0 0</pose><scale>2 3 4</scale></model></state>"
    world = read(f'<model name="m"><link name="l">{shapes}</link></model>{state}')
    found = world.models[0].links[0].collisions
    assert [each.geometry for each in found] == [Box((2.0, 3.0, 4.0)), Sphere(4.0), Cylinder(3.0, 4.0)]
    assert [each.pose.position_m for each in found] == [(1.0, 0.0, 0.0)] * 3
    assert world.warnings == ()


def test_a_state_of_a_nested_model_carries_its_links(read):
    """The outer model stands at x = 9 m, the inner one 1 m ahead, its innermost one another metre ahead."""
    innermost = f'<model name="innermost"><pose>1 0 0 0 0 0</pose>{LINK}</model>'
    inner = f'<model name="inner"><pose>1 0 0 0 0 0</pose><link name="k"/>{innermost}</model>'
    outer = f'<model name="m"><pose>9 0 0 0 0 0</pose><link name="a"/>{inner}</model>'
    moved = "<model name='inner'><pose>4 0 0 0 0 1.5707963267948966</pose></model>"
    (model,) = read(f"{outer}<state><model name='m'><pose>9 0 0 0 0 0</pose>{moved}</model></state>").models
    places = {link.name: (model.pose @ link.pose).position_m for link in model.links}
    np.testing.assert_allclose(places["a"], (9, 0, 0), atol=1e-12)
    np.testing.assert_allclose(places["inner::k"], (4, 0, 0), atol=1e-12)
    np.testing.assert_allclose(places["inner::innermost::l"], (4, 1, 0), atol=1e-12)


def test_a_negative_scale_mirrors_a_mesh_and_its_triangles_face_outside(tmp_path):
    import trimesh

    path = tmp_path / "half.stl"
    trimesh.creation.box((1, 1, 1)).apply_translation((0.5, 0, 0)).export(path)
    for scale, volume, least in (((-2.0, 1.0, 1.0), 2.0, -2.0), ((-1.0, -1.0, 1.0), 1.0, -1.0)):
        mesh = mesh_of(Mesh(str(path), "u", scale))
        assert mesh.vertices[:, 0].min() == least
        assert trimesh.Trimesh(mesh.vertices, mesh.triangles).volume == pytest.approx(volume)


def test_a_mirrored_mesh_of_a_world_is_there_and_one_of_no_size_is_left_out(read, tmp_path):
    (tmp_path / "a.stl").write_text("solid")
    body = (
        '<model name="m"><link name="l"><visual name="v"><geometry><mesh><uri>a.stl</uri>'
        "<scale>1 -1 {}</scale></mesh></geometry></visual></link></model>"
    )
    assert read(body.format(2)).models[0].links[0].visuals[0].geometry.scale == (1.0, -1.0, 2.0)
    assert "numbers other than 0" in read(body.format(0)).warnings[0]


@pytest.mark.parametrize("location", ["model://my%20box", "model://my box", "my%20box", "file://my%20box"])
def test_a_blank_in_a_uri_may_be_written_as_20(read, tmp_path, location):
    put_model(tmp_path / "my box")
    assert len(read(f"<include><uri>{location}</uri></include>").models) == 1


def test_percent_signs_lead_nowhere_else(read, tmp_path):
    put_model(tmp_path / "a%20b")
    assert len(read("<include><uri>model://a%20b</uri></include>").models) == 1
    assert read("<include><uri>model://%2e%2e/x</uri></include>").models == ()
    assert read("<include><uri>model://a%00b</uri></include>").models == ()


def test_a_model_of_fuel_names_its_own_files_by_its_name(read, tmp_path, monkeypatch):
    monkeypatch.setenv("IGN_FUEL_CACHE_PATH", str(tmp_path / "cache"))
    home = tmp_path / "cache" / "fuel.ignitionrobotics.org" / "someone" / "models" / "big box"
    mesh = (
        '<link name="l"><visual name="v"><geometry><mesh><uri>model://Big Box/{}</uri></mesh></geometry>'
        "</visual></link>"
    )
    put_model(home / "1", mesh.format("meshes/a.stl"))
    put_model(home / "2", mesh.format("../1/meshes/a.stl"))
    (home / "1" / "meshes").mkdir()
    (home / "1" / "meshes" / "a.stl").write_text("solid")
    base = "https://app.gazebosim.org/Someone/fuel/models/Big%20Box"
    (model,) = read(f"<include><uri>{base}/1</uri></include>").models
    assert model.links[0].visuals[0].geometry.path == str(home / "1" / "meshes" / "a.stl")
    (other,) = (world := read(f"<include><uri>{base}/2</uri></include>")).models
    assert (other.links[0].visuals, "leaves the model folders" in world.warnings[0]) == ((), True)


def test_of_several_versions_of_a_model_the_newest_that_gazebo_11_reads_counts(tmp_path):
    put_model(tmp_path / "m", '<link name="seven"/>', "1.7")
    (tmp_path / "m" / "new.sdf").write_text(
        '<sdf version="1.9"><model name="x"><link name="nine"/></model></sdf>'
    )
    (tmp_path / "m" / "model.config").write_text(
        '<model><sdf version="1.9">new.sdf</sdf><sdf version="1.7">model.sdf</sdf></model>'
    )
    assert load_model(tmp_path / "m", []).links[0].name == "seven"
