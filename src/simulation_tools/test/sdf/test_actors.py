"""Actors in SDF, as a user of Gazebo writes them; and what is said of those that are wrong."""

from __future__ import annotations

import pytest

from simulation_tools.sdf.elements import Cylinder
from simulation_tools.sdf.parser import SdfError, load_world, parse_model

BOX = "<geometry><box><size>1 1 1</size></box></geometry>"
LINK = f'<link name="l"><collision name="c">{BOX}</collision><visual name="v">{BOX}</visual></link>'


def waypoint(time, pose="0 0 0 0 0 0"):
    return f"<waypoint><time>{time}</time><pose>{pose}</pose></waypoint>"


def actor(script, body=LINK):
    text = f'<sdf version="1.6"><actor name="walker">{body}<script>{script}</script></actor></sdf>'
    return parse_model(text, "text", [])


def trajectory(*waypoints, attributes='id="0" type="walk"'):
    return f"<trajectory {attributes}>{''.join(waypoints)}</trajectory>"


def test_an_actor_is_read_as_gazebo_reads_it():
    walk = trajectory(waypoint(0, "1 2 0.5 0 0 0"), waypoint(4, "5 2 0.5 0 0 0"))
    rest = trajectory(waypoint(2), attributes='id="3" type="stand" tension="0.6"')
    found = actor(rest + walk + "<loop>false</loop><delay_start>1.5</delay_start>")
    assert found.static  # nothing pushes it
    assert found.warnings == ()
    assert found.script is not None
    assert [t.duration_s for t in found.script.trajectories] == [4.0, 2.0]  # in the order of their ids
    assert [t.tension for t in found.script.trajectories] == [0.0, 0.6]
    assert found.script.trajectories[0].waypoints[1].pose.position_m == (5.0, 2.0, 0.5)
    assert (found.script.loop, found.script.delay_s, found.script.starts) == (False, 1.5, True)
    usual = actor(walk).script
    assert (usual.loop, usual.delay_s, usual.starts) == (True, 0.0, True)


def test_a_cylinder_stands_for_the_skin_of_a_person():
    skin = "<skin><filename>walk.dae</filename></skin><animation name='walking'><filename>walk.dae</filename>"
    person = actor(trajectory(waypoint(1)), skin + "<interpolate_x>true</interpolate_x></animation>")
    assert person.warnings == ()
    assert person.links[0].collisions[0].geometry == Cylinder(0.3, 1.8)


def test_a_world_holds_actors(tmp_path):
    world = tmp_path / "a.world"
    world.write_text(
        f'<sdf version="1.6"><world name="w"><actor name="a"><pose>1 0 0 0 0 0</pose>{LINK}<script>'
        f"{trajectory(waypoint(1))}</script></actor></world></sdf>"
    )
    (found,) = load_world(world, []).models
    assert found.name == "a"
    assert found.pose.position_m == (1.0, 0.0, 0.0)


def test_an_actor_without_a_trajectory_stands():
    found = actor("", "<pose>1 0 0 0 0 0</pose>" + LINK)
    assert (found.script, found.static, found.pose.position_m) == (None, True, (1.0, 0.0, 0.0))


@pytest.mark.table(
    ("script", "saying"),
    [
        (trajectory(), "needs a <waypoint> at a time above 0 s"),
        (trajectory(waypoint(0)), "needs a <waypoint> at a time above 0 s"),
        (trajectory(waypoint(2), waypoint(1)), "times of the waypoints must increase, but 1 s follows 2 s"),
        (trajectory(waypoint(1), waypoint(1)), "must increase"),
        (trajectory(waypoint(-1)), "<time> must be zero or positive"),
        (trajectory(waypoint("soon")), 'must hold a finite number, not "soon"'),
        (trajectory("<waypoint><time>1</time></waypoint>"), "has no <pose>"),
        (trajectory("<waypoint><pose>0 0 0 0 0 0</pose></waypoint>"), "has no <time>"),
        (trajectory(waypoint(1, "0 0")), "6 finite numbers"),
        (trajectory(waypoint(1), attributes='id="a"'), 'attribute "id" must be a whole number'),
        (trajectory(waypoint(1), attributes='id="nan"'), 'attribute "id" must be a whole number'),
        (trajectory(waypoint(1), attributes='id="0" tension="2"'), '"tension" must be from 0 to 1, not "2"'),
        (trajectory(waypoint(1)) * 2, "second <trajectory> has the id 0"),
        (trajectory(waypoint(1)) + "<delay_start>-1</delay_start>", "<delay_start> must be zero or positive"),
    ],
)
def test_a_bad_script_is_refused_in_one_sentence(script, saying):
    with pytest.raises(SdfError) as error:
        actor(script)
    assert saying in str(error.value)
    assert str(error.value).startswith("text:1: ")
    assert str(error.value).count(". ") == 0


def test_an_actor_needs_a_script():
    with pytest.raises(SdfError, match='<actor name="a"> has no <script>'):
        parse_model(f'<sdf version="1.6"><actor name="a">{LINK}</actor></sdf>', "text", [])
