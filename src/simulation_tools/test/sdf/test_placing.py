"""Where models of newer SDF stand: in frames around them, by a frame of their own, turned in degrees.

Expected values by hand, after the specification of SDF 1.7 (semantics of poses), 1.8 (placement_frame) and
1.9 (degrees, quaternions).
"""

from __future__ import annotations

import math

import pytest

from simulation_tools.sdf.parser import SdfError, load_model, load_world

LINK = '<link name="l"/>'
ARM, TIP = "<pose>0 0 1 0 0 0</pose>", "<pose>2 0 0 0 0 0</pose>"
PART = f'{LINK}<link name="arm">{ARM}</link><frame name="tip">{TIP}</frame>'
QUARTER = str(math.pi / 2)


@pytest.fixture
def world_of(tmp_path):
    """Return a function that reads a world; models `part` and `old` are on the path."""
    for name, config in (("part", "model.config"), ("old", "manifest.xml")):
        home = tmp_path / name
        home.mkdir()
        (home / config).write_text('<model><name>x</name><sdf version="1.6">model.sdf</sdf></model>')
        (home / "model.sdf").write_text(f'<sdf version="1.8"><model name="{name}">{PART}</model></sdf>')

    def read(body, version="1.9", head=""):
        path = tmp_path / "w.world"
        path.write_text(f'<sdf version="{version}"{head}><world name="w">\n{body}\n</world></sdf>')
        return load_world(path, [tmp_path])

    return read


def placed(world, name):
    (model,) = [model for model in world.models if model.name == name]
    return model.pose.position_m


def model(name, pose="", more="", body=LINK):
    return f'<model name="{name}"{more}>{pose}{body}</model>'


def included(more, uri="model://part"):
    return f"<include><uri>{uri}</uri>{more}</include>"


TURNED = f"<pose>5 1 0 0 0 {QUARTER}</pose>"

FRAME = f'<frame name="f">{TURNED}</frame>'


@pytest.mark.table(
    ("body", "right"),
    [
        # ahead of a model that looks along y is farther along y
        (model("a", TURNED) + model("b", '<pose relative_to="a">2 0 0 0 0 0</pose>'), (5, 3, 0)),
        (model("b", '<pose relative_to="a">2 0 0 0 0 0</pose>') + model("a", TURNED), (5, 3, 0)),
        (FRAME + model("b", '<pose relative_to="f">2 0 0 0 0 0</pose>'), (5, 3, 0)),
        (
            model("a", TURNED) + '<frame name="f" attached_to="a"><pose>1 0 0 0 0 0</pose></frame>'
            + model("b", '<pose relative_to="f">1 0 0 0 0 0</pose>'), (5, 3, 0),
        ),
        (
            model("a", TURNED, body=LINK + '<link name="k"><pose>1 0 0 0 0 0</pose></link>')
            + model("b", '<pose relative_to="a::k">1 0 0 0 0 0</pose>'), (5, 3, 0),
        ),
        (FRAME + included('<name>b</name><pose relative_to="f">2 0 0 0 0 0</pose>'), (5, 3, 0)),
        (
            included(f"<name>a</name>{TURNED}") + model("b", '<pose relative_to="a::arm">2 0 0 0 0 0</pose>'),
            (5, 3, 1),
        ),
        (model("b", '<pose frame="world">1 2 3 0 0 0</pose>'), (1, 2, 3)),
    ],
)  # fmt: skip
def test_a_model_stands_in_the_frame_that_its_pose_names(world_of, body, right):
    world = world_of(body)
    assert placed(world, "b") == pytest.approx(right)
    assert world.warnings == ()


@pytest.mark.table(
    ("frame", "saying"),
    [
        ("nowhere", 'There is no frame "nowhere" in this world'),
        ("b", 'The frame "b" is defined through itself'),
    ],
)
def test_a_frame_that_leads_nowhere_leaves_its_model_out(world_of, frame, saying):
    world = world_of(model("b", f'<pose relative_to="{frame}">0 0 0 0 0 0</pose>') + model("good"))
    assert [each.name for each in world.models] == ["good"]
    assert saying in world.warnings[0]


@pytest.mark.table(
    "inner",
    [
        model("i", '<pose relative_to="k">2 0 0 0 0 0</pose>'),
        included('<name>i</name><pose relative_to="k">2 0 0 0 0 0</pose>'),
        model("h", '<pose relative_to="k">1 0 0 0 0 0</pose>')
        + model("i", '<pose relative_to="h::l">1 0 0 0 0 0</pose>'),
    ],
)
@pytest.mark.table("frame", ["link", "frame"])
def test_a_nested_model_stands_in_a_frame_of_the_outer_one(world_of, inner, frame):
    world = world_of(
        model("o", "<pose>0 0 7 0 0 0</pose>", body=f'{LINK}<{frame} name="k">{TURNED}</{frame}>{inner}')
    )
    assert world.models[0].link("i::l").pose.position_m == pytest.approx((5, 3, 0))
    assert world.warnings == ()


def test_two_nested_models_of_one_name_keep_their_own_places(world_of):
    twice = included("<pose>1 0 0 0 0 0</pose>") + included("<pose>2 0 0 0 0 0</pose>")
    places = {link.pose.position_m for link in world_of(model("o", body=twice)).models[0].links}
    assert {(1, 0, 0), (2, 0, 0), (1, 0, 1), (2, 0, 1)} == places


@pytest.mark.table(
    "body",
    [
        included("<name>b</name><placement_frame>tip</placement_frame>" + TURNED),
        model("b", TURNED, ' placement_frame="tip"', PART),
    ],
)
def test_the_placement_frame_comes_to_the_pose(world_of, body):
    """Its tip is 2 m ahead of it, and it looks along y: it stands 2 m before the tip's place, (5, 1)."""
    world = world_of(body)
    assert placed(world, "b") == pytest.approx((5, -1, 0))
    assert world.warnings == ()


@pytest.mark.table(
    "pose",
    [
        '<pose degrees="true">1 2 3 0 0 90</pose>',
        '<pose degrees="1">1 2 3 0 0 90</pose>',
        f'<pose degrees="false">1 2 3 0 0 {QUARTER}</pose>',
        '<pose rotation_format="euler_rpy" degrees="true">1 2 3 0 0 90</pose>',
        '<pose rotation_format="quat_xyzw">1 2 3 0 0 2 2</pose>',
    ],
)
def test_a_turn_in_degrees_or_as_a_quaternion_is_obeyed(world_of, pose):
    (turned,) = world_of(model("b", pose)).models
    assert turned.pose.position_m == (1, 2, 3)
    assert turned.pose.rpy_rad == pytest.approx((0, 0, math.pi / 2))


@pytest.mark.table("numbers", ["1 2 3 0 0 0", "1 2 3 0 0 0 0", "1 2 3 0 0 nan 1"])
def test_a_bad_quaternion_leaves_its_model_out(world_of, numbers):
    world = world_of(model("b", f'<pose rotation_format="quat_xyzw">{numbers}</pose>') + model("good"))
    assert [each.name for each in world.models] == ["good"]


def test_a_folder_with_the_old_manifest_is_a_model(world_of, tmp_path):
    assert placed(world_of(included("<pose>1 2 3 0 0 0</pose>", "model://old")), "old") == (1, 2, 3)


def test_elements_in_a_default_namespace_are_those_of_sdf(world_of):
    """TinyXML knows no namespaces."""
    world = world_of(model("b"), head=' xmlns="http://sdformat.org/schemas/root.xsd"')
    assert [each.name for each in world.models] == ["b"]


def test_a_model_by_itself_has_no_frame_around_it(tmp_path):
    path = tmp_path / "m.sdf"
    path.write_text('<sdf version="1.7">' + model("b", '<pose relative_to="f">0 0 0 0 0 0</pose>') + "</sdf>")
    with pytest.raises(SdfError, match='There is no frame "f"'):
        load_model(path)
