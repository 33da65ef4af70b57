"""What is told of a launch file's arguments and nodes, on files drawn here."""

from __future__ import annotations

import pytest

from simulation_tools.launch_check.launch_files import LaunchError, check_arguments, nodes_of

DRAWN = """<launch>
  <arg name="lidar" default="ust"/>
  <arg name="seed" default="1"/>
  <arg name="lockstep" default="false"/>
  <arg name="returns" default="$(eval not lockstep)"/>
  <arg name="goal"/>
  <arg name="frame" value="world"/>
  <node pkg="a" type="a" name="first"/>
  <group ns="inner"><node pkg="a" type="a" name="second"/></group>
  <include file="$(find there)/more.launch" ns="other"/>
  <include file="$(find nowhere)/more.launch"/>
  <include file="$(eval 'what')"/>
</launch>"""
DEFAULTS = {"lidar": "ust", "seed": "1", "lockstep": "false", "returns": "True"}
MORE = '<launch><node pkg="a" type="a" name="third" if="false"/></launch>'


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "drawn.launch"
    path.write_text(DRAWN)
    (tmp_path / "more.launch").write_text(MORE)
    return path


def test_arguments_that_the_file_takes_are_taken(file):
    check_arguments(file, {"lidar": "urg", "seed": "7", "lockstep": "True", "goal": "1 2 3"}, DEFAULTS)


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"lidr": "urg"}, "drawn.launch has no argument 'lidr'; did you mean lidar:=?"),
        ({"xyz": "1"}, "drawn.launch has no argument 'xyz'; it takes lidar, seed, lockstep, returns, goal."),
        ({"seed": "abc"}, "'abc' is no seed; give a number, for example seed:=1."),
        ({"lockstep": "1"}, "'1' is no lockstep; give lockstep:=true or lockstep:=false."),
        ({"returns": "yes"}, "'yes' is no returns; give returns:=true or returns:=false."),
        ({"frame": "map"}, "drawn.launch sets its argument frame itself; leave out frame:=map."),
        ({}, "drawn.launch needs goal:=...; roslaunch --ros-args tells what it means."),
    ],
)
def test_what_the_file_does_not_take_is_refused_in_a_sentence(file, given, sentence):
    goal = {"goal": "1 2 3"} if given else {}
    with pytest.raises(LaunchError) as error:
        check_arguments(file, {**given, **goal}, DEFAULTS)
    assert str(error.value) == sentence


def test_a_file_that_is_no_launch_file_is_refused_by_name(tmp_path):
    path = tmp_path / "half.launch"
    path.write_text("<launch>")
    with pytest.raises(LaunchError, match=r"The launch file .*half\.launch cannot be read"):
        check_arguments(path, {}, {})


def test_the_nodes_are_found_in_groups_and_in_what_is_included(file, tmp_path):
    def find(package):
        if package != "there":
            raise LookupError(package)
        return str(tmp_path)

    assert nodes_of(file, find) == {"/first", "/inner/second", "/other/third"}
    assert nodes_of(file, find, "/uav2") == {"/uav2/first", "/uav2/inner/second", "/uav2/other/third"}
