"""Worlds that others wrote for Gazebo 11: loaded as it loads them, without what is bad in them.

The expected values are Gazebo 11's: sdformat 9 converts old versions, TinyXML reads the text, and
``gazebo/physics`` applies ``<state>``.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from simulation_tools.sdf.parser import SdfError, load_model, load_world, parse_model

BOX = "<geometry><box><size>1 1 1</size></box></geometry>"
GOOD = f'<model name="good"><link name="l"><collision name="c">{BOX}</collision></link></model>'
MESH = "<geometry><mesh><uri>model://none/x.dae</uri></mesh></geometry>"


def put_model(folder, name, body, more="", version="1.6"):
    home = folder / name
    home.mkdir(parents=True)
    (home / "model.config").write_text(
        f'<model><name>x</name><sdf version="{version}">model.sdf</sdf></model>'
    )
    (home / "model.sdf").write_text(
        f'<sdf version="{version}"><model name="{name}"{more}>{body}</model></sdf>'
    )
    return home


@pytest.fixture
def world_of(tmp_path):
    """Return a function that writes and reads a world."""

    def read(body, version="1.6", static=False, file="w.world"):
        path = tmp_path / file
        path.write_text(f'<sdf version="{version}"><world name="w">\n{body}\n</world></sdf>')
        return load_world(path, [tmp_path], static)

    return read


@pytest.mark.parametrize(
    ("bad", "saying"),
    [
        ("<include><uri>model://none</uri></include>", 'there is no model "none"'),
        ("<include><name>x</name></include>", "has no <uri>"),
        ("<include><uri>model://broken</uri></include>", "<mass> must be positive"),
        ('<model name="m"/>', "has no <link>"),
        ('<model name="m"><link name="l"><pose>1 2</pose></link></model>', "6 finite numbers"),
        ('<model name="m"><pose>a b c d e f</pose><link name="l"/></model>', "6 finite numbers"),
        ('<actor name="a"><script><trajectory id="0"/></script></actor>', "needs a <waypoint>"),
        (
            '<model name="m"><link name="l"><inertial><mass>0</mass></inertial></link></model>',
            "<mass> must be positive",
        ),
    ],
)
def test_one_bad_model_is_left_out_and_named_first(world_of, tmp_path, bad, saying):
    put_model(tmp_path, "broken", '<link name="l"><inertial><mass>-1</mass></inertial></link>')
    world = world_of(f"<population/>{bad}{GOOD}")
    assert [model.name for model in world.models] == ["good"]
    assert "is left out: " in world.warnings[0]
    assert saying in world.warnings[0]
    assert "w.world:2" in world.warnings[0]


@pytest.mark.table(
    ("bad", "saying"),
    [
        ("<gravity>x</gravity>", "<gravity> is left out: "),
        ("<wind><linear_velocity>1 2</linear_velocity></wind>", "<linear_velocity> is left out: "),
        ('<physics type="ode"><max_step_size>x</max_step_size></physics>', "<max_step_size> is left out: "),
        ('<frame name="f"><pose>x</pose></frame>', '<frame name="f"> is left out: '),
        ("<frame/>", '<frame> has no attribute "name"'),
        ('<light type="point"/>', '<light> has no attribute "name"'),
        ('<light name="s"/>', '<light> has no attribute "type"'),
        ('<light name="s" type="point"><pose>x</pose></light>', '<light name="s"> is left out: '),
        ('<light name="s" type="point"><diffuse>x</diffuse></light>', "3 finite numbers"),
        ('<plugin name="q"/>', '<plugin> has no attribute "filename"'),
        ('<plugin filename="a.so"/>', '<plugin> has no attribute "name"'),
        ('<state><model name="good"><pose>x</pose></model></state>', 'The state of the model "good" is left'),
        ('<state><model name="good"><link name="l"><pose>x</pose></link></model></state>', "is left out: "),
        ("<state><model><pose>1 0 0 0 0 0</pose></model></state>", '<model> has no attribute "name"'),
    ],
)
def test_a_bad_part_of_a_world_is_left_out_and_the_models_stand(world_of, bad, saying):
    world = world_of(f"{GOOD}{bad}")
    assert [model.name for model in world.models] == ["good"]
    assert all(model.links and model.pose.position_m == (0.0, 0.0, 0.0) for model in world.models)
    assert (world.gravity_m_s2, world.wind_m_s) == ((0.0, 0.0, -9.8), (0.0, 0.0, 0.0))
    assert saying in world.warnings[0]
    assert "w.world:2" in world.warnings[0]


def test_a_bad_plugin_of_a_model_is_left_out_alone(world_of):
    world = world_of(GOOD.replace("<link", '<plugin name="p"/><plugin name="q" filename="q.so"/><link'))
    assert [plugin.name for plugin in world.models[0].plugins] == ["q"]
    assert '<plugin name="p"> is left out: ' in world.warnings[0]


def test_a_model_file_that_is_asked_for_as_a_world_is_named_as_such(tmp_path):
    (tmp_path / "m.sdf").write_text(f'<sdf version="1.6">{GOOD}</sdf>')
    with pytest.raises(SdfError, match="holds a <model>, but no <world>"):
        load_world(tmp_path / "m.sdf", [])


@pytest.mark.table(
    ("part", "saying"),
    [
        (f'<collision name="d">{MESH}</collision>', 'no model "none"'),
        (f'<visual name="d">{MESH}</visual>', 'no model "none"'),
        ('<sensor name="s" type="ray"><ray/></sensor>', "has no <scan>"),
        ('<sensor name="s"/>', 'no attribute "type"'),
    ],
)
def test_a_bad_part_of_a_model_is_left_out_alone(world_of, part, saying):
    world = world_of(GOOD.replace("</link>", part + "</link>"))
    (link,) = world.models[0].links
    assert (len(link.collisions), link.visuals, link.sensors) == (1, (), ())
    assert saying in world.warnings[0]


def test_a_bad_include_or_joint_inside_a_model_is_left_out_alone(world_of):
    body = (
        '<model name="m"><link name="a"/><link name="b"/><include><uri>model://none</uri></include>'
        '<joint name="j" type="fixed"><parent>a</parent><child>none::l</child></joint>'
        '<joint name="k" type="fixed"><parent>a</parent><child>b</child></joint></model>'
    )
    world = world_of(body)
    assert [joint.name for joint in world.models[0].joints] == ["k"]
    assert len(world.warnings) == 2


@pytest.mark.table("part", [f'<link name="l"><visual name="v">{MESH}</visual></link>', "<static>1</static>"])
def test_a_model_that_is_asked_for_by_itself_is_refused(tmp_path, part):
    put_model(tmp_path, "bad", part)
    with pytest.raises(SdfError):
        load_model("model://bad", [tmp_path])


@pytest.mark.table("version", ["1.3", "1.4", "1.7", "1.8", "1.9", "1.10", "1.12"])
def test_every_version_that_gazebo_11_reads_and_newer_ones(world_of, version):
    assert len(world_of(GOOD, version).models) == 1


def test_the_root_is_called_gazebo_before_sdf_1_3(tmp_path):
    path = tmp_path / "w.world"
    path.write_text(f'<gazebo version="1.2"><world name="w">{GOOD}</world></gazebo>')
    assert len(load_world(path, []).models) == 1


def test_version_1_10_is_newer_than_1_9(tmp_path):
    home = put_model(tmp_path, "m", '<link name="new"/>')
    (home / "old.sdf").write_text('<sdf version="1.9"><model name="m"><link name="old"/></model></sdf>')
    (home / "model.config").write_text(
        '<model><sdf version="1.9">old.sdf</sdf><sdf version="1.10">model.sdf</sdf></model>'
    )
    assert load_model(home, []).links[0].name == "new"


@pytest.mark.table(("version", "axis"), [("1.4", (0, -1, 0)), ("1.3", (0, -1, 0)), ("1.5", (1, 0, 0))])
def test_before_sdf_1_5_an_axis_is_in_the_frame_of_the_model(version, axis):
    # sdformat's 1_4.convert sets use_parent_model_frame to true. The child is turned to the left.
    text = (
        f'<sdf version="{version}"><model name="m"><link name="a"/>'
        '<link name="b"><pose>0 0 0 0 0 1.5707963267948966</pose></link>'
        '<joint name="j" type="revolute"><parent>a</parent><child>b</child>'
        "<axis><xyz>1 0 0</xyz></axis></joint></model></sdf>"
    )
    np.testing.assert_allclose(parse_model(text, "t", []).joints[0].axis, axis, atol=1e-12)


@pytest.mark.table(
    "text",
    [
        '\n<?xml version="1.0"?>\n<sdf>',
        "<!-- a -- b ---->\n<sdf>",
        "<!-- <!DOCTYPE x> -->\n<sdf>",
        '<?xml version="1.0"?>\n<!-- \xe4 -->\n<sdf>',
        '<sdf><x:y xmlns="a"/>',
        "<sdf><author>A & B</author>",
        '<sdf><author a=1 b=x/><author c = y d="e=f g">h=i</author>',
    ],
)
def test_xml_that_tinyxml_takes(tmp_path, text):
    path = tmp_path / "w.world"
    whole = text.replace("<sdf>", '<sdf version="1.6">') + f'<world name="w">{GOOD}</world></sdf>\n'
    path.write_bytes((whole + "what follows").encode("latin-1"))
    assert len(load_world(path, []).models) == 1


def test_a_line_is_the_files_own_whatever_had_to_be_mended(tmp_path):
    path = tmp_path / "w.world"
    path.write_text(
        '\n<?xml version="1.0"?>\n<!-- a -- \n b -->\n<sdf version="1.6"><world name="w">\n'
        '<model name="m"/></world></sdf>'
    )
    assert f"{path}:6: " in load_world(path, []).warnings[0]


INERT = (
    '<link name="l"><inertial><mass>0</mass><inertia><ixx>0</ixx><iyy>-1</iyy><izz>0</izz></inertia>'
    f'</inertial><collision name="c">{BOX}</collision></link>'
)


def test_a_static_model_has_no_use_for_inertia_wherever_static_is_said(world_of, tmp_path):
    put_model(tmp_path, "still", "<static>1</static>" + INERT)
    put_model(tmp_path, "mover", INERT)
    world = world_of(
        "<include><uri>model://still</uri></include>"
        "<include><uri>model://mover</uri><static>true</static></include>"
        f'<model name="outer"><static>1</static><model name="inner">{INERT}</model></model>'
    )
    assert [model.name for model in world.models] == ["still", "mover", "outer"]
    assert world.warnings == ()
    assert len(world_of("<include><uri>model://mover</uri></include>", static=True).models) == 1


@pytest.mark.table("kind", ["prismatic", "ball", "universal", "revolute2", "screw", "gearbox"])
def test_a_joint_that_does_not_move_here_is_held_and_a_static_one_does_not_matter(world_of, kind):
    axis = "<axis><xyz>0 0 1</xyz></axis>"
    joint = f'<joint name="j" type="{kind}"><parent>a</parent><child>b</child>{axis}</joint>'
    links = '<link name="a"/><link name="b"/>'
    still = world_of(f'<model name="m"><static>1</static>{links}{joint}</model>')
    assert (len(still.models), still.warnings) == (1, ())
    moving = world_of(f'<model name="m">{links}{joint}</model>')
    assert moving.models[0].joints[0].kind == "fixed"
    assert f'The joint "j" of type {kind} is held' in moving.warnings[0]


def test_two_models_of_one_name_are_both_there(world_of, tmp_path):
    put_model(tmp_path, "tree", '<link name="l"/>')
    world = world_of(
        "<include><uri>model://tree</uri></include>" * 3 + '<model name="tree_0"><link name="l"/></model>'
    )
    assert [model.name for model in world.models] == ["tree", "tree_0", "tree_1", "tree_0_0"]
    assert 'Two models are called "tree"; the second one is "tree_0" here' in world.warnings[0]


def test_an_empty_or_a_second_element_is_as_in_gazebo(world_of):
    # Gazebo takes the default of an empty element, and the first of two.
    world = world_of(
        '<model name="m"><static></static><static>1</static><link name="l"><gravity/></link></model>'
        '<light name="s" type="directional"><direction></direction></light>'
    )
    assert (world.models[0].static, world.models[0].links[0].gravity) == (False, True)
    assert "<world/model/static>" in world.warnings[0]


def test_a_plugin_of_a_nested_model_means_that_models_links_and_joints(tmp_path):
    plugin = (
        '<plugin name="p" filename="libgazebo_motor_model.so"><linkName>a</linkName><jointName>j</jointName>'
        "<commandSubTopic>a</commandSubTopic></plugin>"
    )
    joint = '<joint name="j" type="fixed"><parent>a</parent><child>b</child></joint>'
    put_model(tmp_path, "inner", f'<link name="a"/><link name="b"/>{joint}{plugin}')
    text = '<sdf version="1.6"><model name="o"><include><uri>model://inner</uri></include></model></sdf>'
    (found,) = parse_model(text, "t", [tmp_path]).plugins
    assert found.parameters == {"linkName": "inner::a", "jointName": "inner::j", "commandSubTopic": "a"}


def test_the_warning_names_what_changes_the_world_before_what_only_looks(world_of):
    model = (
        '<model name="m"><link name="l"/><plugin name="p" filename="libdance.so"><x>1</x></plugin></model>'
    )
    (warning,) = world_of(f"{model}<population/>").warnings
    assert warning.index("<world/population>") < warning.index("<world/model/plugin>")


def state(body, more=""):
    return f'<state world_name="w"><sim_time>1 0</sim_time>{body}{more}</state>'


def test_a_state_says_where_the_models_are(world_of):
    world = world_of(
        '<model name="m"><pose>1 0 0 0 0 0</pose><link name="l"/></model>'
        '<model name="n"><pose>0 7 0 0 0 0</pose><link name="l"/></model>'
        + state('<model name="m"><pose>5 0 2 0 0 1.5707963267948966</pose><scale>1 1 1</scale></model>')
    )
    assert [model.pose.position_m for model in world.models] == [(5.0, 0.0, 2.0), (0.0, 7.0, 0.0)]
    assert world.models[0].pose.rpy_rad[2] == pytest.approx(math.pi / 2)
    assert world.warnings == ()


def test_the_links_of_a_state_are_in_the_world_frame(world_of):
    # The model stands at x = 5 m and looks to the left, so the link 1 m to the left is 1 m ahead of it.
    body = (
        '<model name="m"><link name="a"/><link name="b"><pose>0 0 9 0 0 0</pose></link>'
        '<model name="in"><pose>0 0 1 0 0 0</pose><link name="c"/></model></model>'
    )
    placed = (
        '<model name="m"><pose>5 0 0 0 0 1.5707963267948966</pose>'
        '<link name="a"><pose>5 0 0 0 0 1.5707963267948966</pose><velocity>0 0 0 0 0 0</velocity></link>'
        '<link name="b"><pose>5 1 0 0 0 1.5707963267948966</pose></link>'
        '<model name="in"><pose>5 0 4 0 0 1.57</pose><link name="c">'
        "<pose>5 2 0 0 0 1.5707963267948966</pose></link>"
        "</model></model>"
    )
    (model,) = world_of(body + state(placed)).models
    np.testing.assert_allclose(model.link("b").pose.position_m, (1, 0, 0), atol=1e-12)
    np.testing.assert_allclose(model.link("in::c").pose.position_m, (2, 0, 0), atol=1e-12)
    assert model.link("a").pose.position_m == (0.0, 0.0, 0.0)


def test_a_state_inserts_and_deletes_models_and_the_rest_of_it_is_named(world_of):
    gone = '<model name="gone"><link name="l"/></model>'
    more = (
        '<insertions><model name="new"><link name="l"/></model></insertions>'
        "<deletions><name>gone</name></deletions>"
    )
    placed = '<model name="good"><pose>1 0 0 0 0 0</pose><scale>1 1 1</scale><link name="l">'
    placed += "<pose>1 0 0 0 0 0</pose><velocity>3 0 0 0 0 0</velocity></link></model>"
    world = world_of(GOOD + gone + state(placed, more))
    assert [model.name for model in world.models] == ["good", "new"]
    assert "<world/state/model/link/velocity>" in world.warnings[0]


def test_a_hinge_begins_at_zero_and_this_is_said(world_of):
    body = (
        '<model name="m"><link name="a"/><link name="b"/><joint name="j" type="revolute"><parent>a</parent>'
        "<child>b</child><axis><xyz>0 0 1</xyz></axis></joint></model>"
    )
    placed = '<model name="m"><pose>0 0 0 0 0 0</pose><link name="b"><pose>0 0 0 0 0 1</pose></link></model>'
    world = world_of(body + state(placed))
    assert world.models[0].link("b").pose.rpy_rad == (0.0, 0.0, 0.0)
    assert 'The joints of the model "m" begin at zero' in world.warnings[0]


def test_attributes_of_newer_versions_that_would_change_the_model_are_said(world_of, tmp_path):
    put_model(tmp_path, "inner", '<link name="l"/>')
    world = world_of(
        '<model name="m"><link name="l"/><include merge="true"><uri>model://inner</uri></include></model>',
        version="1.9",
    )
    assert "merge" in world.warnings[0]


def test_what_is_left_out_for_one_reason_is_one_sentence(world_of):
    lost = "<include><uri>model://none</uri></include>\n"
    world = world_of(
        lost * 3 + f'<model name="holder">{lost}</model>' + GOOD + state('<model name="none"><pose/></model>')
    )
    assert [model.name for model in world.models] == ["good"]
    (sentence,) = world.warnings  # nothing more, also not of the <state> of what is not there
    assert "w.world:2: " in sentence
    assert sentence.endswith(" The same counts for 3 more.")


def test_a_bad_friction_does_not_take_the_shape_away(world_of):
    surface = "<surface><friction><ode><mu>-1</mu><mu2>-1</mu2></ode></friction></surface>"
    world = world_of(GOOD.replace("</collision>", surface + "</collision>"))
    (collision,) = world.models[0].links[0].collisions
    assert collision.surface.friction == 1.0
    assert "<mu> must be zero or positive, not -1; 1 counts" in world.warnings[0]


@pytest.mark.parametrize("moments", ["<ixx>0</ixx><iyy>0</iyy><izz>0</izz>", "<ixx>1</ixx><ixy>9</ixy>"])
def test_moments_that_no_body_can_have_are_replaced_and_this_is_said(world_of, tmp_path, moments):
    body = f'<link name="l"><inertial><mass>2</mass><inertia>{moments}</inertia></inertial></link>'
    (found,) = world_of(f'<model name="m">{body}</model>').models
    # A ball: 2/5 m r^2 = 0.4 * 2 kg * 0.01 m2
    assert found.links[0].inertial.moments_kg_m2 == pytest.approx((0.008, 0.008, 0.008, 0, 0, 0))
    assert "a ball with a radius of 0.1 m" in world_of(f'<model name="m">{body}</model>').warnings[0]
    put_model(tmp_path, "alone", body)
    with pytest.raises(SdfError):
        load_model("model://alone", [tmp_path])


@pytest.mark.table(
    "head",
    ["<!DOCTYPE sdf>", "<!-- x -->\n<!doctype gazebo SYSTEM 'sdf.dtd'>", "<!DOCTYPE sdf PUBLIC 'a' 'b'>"],
)
def test_a_document_type_without_declarations_is_passed_over(tmp_path, head):
    path = tmp_path / "w.world"
    path.write_text(f'<?xml version="1.0"?>\n{head}\n<sdf version="1.6"><world name="w">{GOOD}</world></sdf>')
    assert len(load_world(path, []).models) == 1


def test_a_document_type_inside_another_one_is_still_refused():
    text = '<!DOC<!DOCTYPE a>TYPE x [<!ENTITY b "c">]><sdf version="1.6"><model name="&b;"/></sdf>'
    with pytest.raises(SdfError):
        parse_model(text, "t", [])


def test_two_links_of_one_name_are_both_there(world_of):
    # Gazebo's Model::LoadLinks makes both. A joint means the first one.
    links = GOOD.split(">", 1)[1].removesuffix("</model>")
    joint = '<joint name="j" type="fixed"><parent>world</parent><child>l</child></joint>'
    world = world_of(
        f'<model name="m">{links * 2}<link name="l_0"><pose>3 0 0 0 0 0</pose></link>{joint}</model>'
    )
    assert [link.name for link in world.models[0].links] == ["l", "l_0", "l_1"]
    assert world.models[0].link("l_0").pose.position_m == (3.0, 0.0, 0.0)
    assert [len(link.collisions) for link in world.models[0].links] == [1, 0, 1]
    assert 'Two links are called "l"; the second one is "l_1" here' in world.warnings[0]


@pytest.mark.parametrize(
    "nested", ['<model name="in"><link name="l"/></model>', "<include><uri>model://in</uri></include>"]
)
def test_two_nested_models_of_one_name_are_both_there(world_of, tmp_path, nested):
    put_model(tmp_path, "in", '<link name="l"/>')
    world = world_of(f'<model name="m"><link name="l"/>{nested * 2}</model>')
    assert [link.name for link in world.models[0].links] == ["l", "in::l", "in_0::l"]
    assert 'Two models are called "in"' in world.warnings[0]


@pytest.mark.table(
    ("body", "tag"),
    [
        ('<joint name="j" type="fixed"><parent>world</parent><child>l</child></joint>', "joint"),
        ('<frame name="j"/>', "frame"),
    ],
)
def test_the_second_joint_or_frame_of_a_name_is_left_out_alone(world_of, body, tag):
    (found,) = world_of(GOOD.replace("</model>", body * 2 + "</model>")).models
    assert len(found.joints) == (tag == "joint")
    world = world_of(GOOD.replace("</model>", body * 2 + "</model>"))
    assert f'A second <{tag}> is called "j"' in world.warnings[0]


def test_the_second_sensor_or_frame_of_the_world_is_left_out_and_the_first_counts(world_of):
    imu = '<link name="k"><sensor name="s" type="imu"/><sensor name="s" type="imu"/></link>'
    frames = '<frame name="f"><pose>1 0 0 0 0 0</pose></frame><frame name="f"/>'
    world = world_of(f'<model name="m"><pose relative_to="f"/>{imu}</model>{frames}', version="1.9")
    assert world.models[0].pose.position_m == (1.0, 0.0, 0.0)
    assert len(world.models[0].links[0].sensors) == 1
    assert len(world.warnings) == 2


def test_a_script_of_a_material_that_is_not_known_is_named(world_of):
    visual = f'<visual name="v">{BOX}<material><script><name>NAME</name></script></material></visual>'
    body = GOOD.replace("</link>", visual + "</link>")
    assert world_of(body.replace("NAME", "Gazebo/Red")).warnings == ()
    (warning,) = world_of(body.replace("NAME", "Pier/Rusty")).warnings
    assert "visual/material/script/name>" in warning
