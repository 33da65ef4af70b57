"""Every shell snippet of the pages runs as pasted from where its page says.

Bash runs all blocks, in a copy of the workspace made of links. It only writes down the programs in
`snippets.CALLED`. Then `calls` checks each of these calls:
- roslaunch, and bringup.sh with a launch file: roslaunch's own loader loads the file with these arguments;
  every argument, node and file exists. rosinstall names the packages that a reader builds from source.
- rosrun: the program exists, and our own commands know the options given.
- dynparam, rostopic, rosbag: parameter and value, type and message, subcommand and options exist.
- bringup.sh setup, test, bench and report take long and are not run; files that they name must exist.
Blocks with one of `snippets.ELSEWHERE` (apt-get, catkin_make, ...) need root, the network or foreign sources.
Bash only parses them; their lines that call ROS are checked as above.
"""

from __future__ import annotations

import re
import subprocess

import pytest
import snippets
from snippets import ROOT, Snippet, fenced, pages, shell_snippets, workspace

pytestmark = pytest.mark.ros

PAGES = pages()


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A workspace to paste into, with what a reader would have made before: results, a map, a recording."""
    folder = tmp_path_factory.mktemp("pasted")
    made, home = workspace(folder), folder / "home"
    before = {
        made / "results/experiment_1/now/flight.bag": "",
        made / "results/campaigns/cepa_tuning_tuning/cepa_tuned.yaml": "",
        made / "flight.bag": "",
        made / "mission.yaml": fenced("src/inspection_tools/doc/reference.md", "yaml")[0],
        made / "src/my_avoidance/nodes/potential_field": "#!/usr/bin/env python3\n",
        home / "tutorial/yard.world": (ROOT / "my.world").read_text(),
        home / "tutorial/models/lidar_mine/model.sdf": "",
        home / "tutorial/limits.yaml": fenced("src/extensions/flights/doc/tutorial.md", "yaml")[0],
        home / "tutorial/tank.world": fenced("src/extensions/flights/doc/own_tank.md", "xml")[0],
        made / "limits.yaml": fenced("src/extensions/exploration/doc/path_planner.md", "yaml")[0],
    }
    for path, content in before.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(content)
    return made, home


def of_pages(found) -> list:
    return [pytest.param(one, id=f"{one.page}-{one.number}") for page in PAGES for one in found(page)]


def test_there_are_snippets_on_the_pages():
    """Empty lists would make the tests below pass without looking at anything."""
    assert {"README.md", "src/cepa/README.md", "src/extensions/flights/doc/tutorial.md"} <= set(PAGES)
    assert sum(len(shell_snippets(page)) for page in PAGES) > 20


@pytest.mark.parametrize(
    "text",
    [
        "roslaunch master_thesis experiment_1.launch lidr:=urg",
        "roslaunch flights fly_to_goal.launch world:=$PWD/no.world goal:='1 2 3'",
        "roslaunch master_thesis experiment_9.launch",
        "rosrun master_thesis docto",
        "rosrun doctor doctor --alive",
        "rosrun doctor doctor [--alive]",
        "rosrun dynamic_reconfigure dynparam set /cepa r_up 1.5",
        "rosrun dynamic_reconfigure dynparam set /cepa r_ub 1e9",
        "rostopic pub -1 /a geometry_msgs/Pose '{position: {q: 1.0}}'",
        "rosbag play --clok some.bag",
        "./bringup.sh experiment_1.launch scenaro:=forest",
        "./bringup.sh bensh",
        "cd no_such_folder",
        "roslaunch master_thesis 'experiment_1.launch",
        "sudo make 'install",
    ],
)
def test_a_snippet_that_is_wrong_is_noticed(text, place):
    """The checks can fail: each of these has one fault."""
    with pytest.raises(AssertionError):
        check(Snippet("none", 0, text), place)


@pytest.mark.parametrize("snippet", of_pages(shell_snippets))
def test_a_shell_snippet_runs_as_pasted(snippet, place):
    check(snippet, place)


def check(snippet: Snippet, place) -> None:
    """Let bash run a snippet, and look at every call of it."""
    from calls import HELPFUL, knows_options, look_at

    made, home = place
    for text in snippet.runnable:
        for call in snippets.run(text, made, home):
            look_at(call)
    for line in snippet.text.splitlines():  # what stands in [brackets] is an option too
        words = line.split()
        if words[:1] == ["rosrun"] and tuple(words[1:3]) in HELPFUL:
            knows_options(tuple(words[1:]), re.findall(r"(?<=\[)--[\w-]+", line))


# -- for real -----------------------------------------------------------------------------------------------


def test_the_doctor_of_the_page_runs():
    """`rosrun doctor doctor`: this installation. 1: it found something; 2: it could not look."""
    done = subprocess.run(
        ["rosrun", "doctor", "doctor"], capture_output=True, text=True, timeout=120, cwd=ROOT
    )
    assert done.returncode in (0, 1), done.stdout + done.stderr
    assert "Traceback" not in done.stderr
    assert "Examined" in done.stdout


@pytest.mark.flight
def test_the_world_of_the_page_is_flown_to_its_goal():
    """The README's fly_to_goal.launch with my.world, here without ROS."""
    from flights.flight.closed_loop import ClosedLoop
    from flights.flight.parameters import ClosedLoopParameters
    from simulation_tools.geometry import Pose
    from simulation_tools.simulation import SimulationParameters

    assert 'world:=$PWD/my.world start:="0 0 0 1.57" goal:="3 20 2"' in (ROOT / "README.md").read_text()
    start = Pose.from_xyz_rpy(0.0, 0.0, 0.0, yaw=1.57)
    flown = SimulationParameters(str(ROOT / "my.world"), spawn_pose=start)
    with ClosedLoop(ClosedLoopParameters(flown, goal_xyz_m=(3.0, 20.0, 2.0))) as loop:
        outcome = loop.run()
        aside = max(row[1] for row in loop.log.truth.rows)
    assert outcome.success, outcome.failure
    assert aside > 3.3, "there is nothing to fly around"
