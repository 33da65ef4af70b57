"""What the launch files of mapping, exploration and inspection tell their nodes."""

from __future__ import annotations

import ast
import math
import os
import re
from pathlib import Path
from xml.etree import ElementTree

import pytest
import yaml

from flights.exploring.places import HOLD, TANK, place_of
from flights.flight.parameters import LED_CEPA
from flights.worlds.scenario import CLOUD_LIDARS
from inspection.camera.survey_camera import SurveyCamera
from simulation_tools.camera.optics import CameraOptics

ROOT = Path(__file__).resolve().parents[2]


def loaded(path, *given):
    """Return roslaunch's configuration of a launch file."""
    from launch_files import load

    return load(path, *given)


@pytest.mark.ros
@pytest.mark.parametrize("number", [3, 4])
@pytest.mark.parametrize(
    ("given", "algorithm"),
    [
        ((), "improved"),
        (("lidar:=ust", "nod:=true"), "dynamic"),
        (("lidar:=ust", "nod:=true", "algorithm:=improved"), "improved"),
    ],
)
def test_a_lidar_that_nods_is_flown_by_the_algorithm_that_remembers(number, given, algorithm):
    config = loaded(ROOT / f"src/master_thesis/launch/experiment_{number}.launch", *given, "gnss:=false")
    assert config.params["/experiment/algorithm"].value == algorithm


OWN_WORLD = ("world:=/a.world", "algorithm:=improved")


@pytest.mark.ros
@pytest.mark.parametrize(
    ("file", "given", "k_previous"),
    [
        *((f"master_thesis/launch/experiment_{number}", (), 0.0) for number in (1, 2, 3, 4)),
        ("master_thesis/launch/experiment_1", ("k_previous:=3",), 3.0),
        ("extensions/flights/launch/fly_to_goal", (*OWN_WORLD, "goal:=3 0 2"), 4.0),
        ("extensions/flights/launch/explore", ("world:=ballast_tank",), 4.0),
        ("extensions/flights/launch/inspection", ("world:=ballast_tank",), 4.0),
        ("extensions/flights/launch/real", ("algorithm:=improved",), 4.0),
        ("extensions/flights/launch/teleop", OWN_WORLD, 4.0),
        ("cepa/launch/cepa", (), 4.0),
        ("cepa/launch/hokuyo_only", (), 4.0),
    ],
)
def test_only_the_thesis_s_experiments_let_improved_change_sides(file, given, k_previous):
    config = loaded(ROOT / f"src/{file}.launch", *given)
    assert config.params["/cepa/k_previous"].value == k_previous


@pytest.mark.ros
@pytest.mark.parametrize(("world", "swaps"), [("hold_3d", 1), ("ballast_tank", 3)])
def test_a_file_of_settings_counts_in_an_exploration(tmp_path, world, swaps):
    path = ROOT / "src/extensions/flights/launch/explore.launch"
    names = ("experiment/swaps", "gazebo/static_models", "gazebo/lockstep_timeout", "gridslam/loop_closure")
    usual = loaded(path, f"world:={world}").params
    assert [usual[f"/{name}"].value for name in names] == [swaps, False, 10.0, True]
    file = tmp_path / "mine.yaml"
    lines = ("experiment: {swaps: 5}", "gazebo: {static_models: true}", "gridslam: {loop_closure: false}")
    file.write_text("\n".join(lines))
    changed = loaded(path, f"world:={world}", f"settings:={file}").params
    assert [changed[f"/{name}"].value for name in names] == [5, True, 10.0, False]
    kept = usual.keys() - {f"/{name}" for name in names}
    assert {name: usual[name].value for name in kept} == {name: changed[name].value for name in kept}


UNUSED = ("imu",)


@pytest.mark.ros
@pytest.mark.parametrize("given", [(), ("lockstep:=true", "gnss:=false", "lidar:=puck", "record:=true")])
def test_experiment_1_is_a_flight_to_a_goal_in_its_world(given):
    """tests/flights/test_experiment_1.py flies the second in place of the first."""
    flights = ROOT / "src/extensions/flights"
    there = (f"world:={flights}/worlds/forest.world", "goal:=40 0 2", "algorithm:=improved")
    experiment = loaded(ROOT / "src/master_thesis/launch/experiment_1.launch", *given)
    flight = loaded(flights / "launch/fly_to_goal.launch", *there, *given)
    files = (experiment, flight)
    told, told_there = (
        {key: each.value for key, each in file.params.items() if not key.startswith("/pilot_orders/")}
        for file in files
    )
    own = {"experiment/experiment": "experiment_1", "experiment/scenario": "forest", "cepa/k_previous": 0.0}
    own["cepa/imu"] = False  # only `dynamic` heeds it, and the thesis had none
    for name, place in (("world", flights / "worlds/forest.world"), ("results", ROOT / "results")):
        for each in (told, told_there):
            assert os.path.normpath(each.pop(f"/experiment/{name}")) == str(place)
    assert told == {**told_there, **{f"/{key}": value for key, value in own.items()}}
    nodes, nodes_there = (
        [
            (
                each.namespace,
                each.package,
                each.type,
                each.name,
                [m for m in each.remap_args if m[0] not in UNUSED],
            )
            for each in file.nodes
        ]
        for file in files
    )
    nodes_there = [node for node in nodes_there if node[3] != "pilot_orders"]  # whom no experiment needs
    assert nodes == nodes_there


@pytest.mark.ros
@pytest.mark.parametrize(
    ("lidar", "nod", "reach_m"), [("ust", True, 7.0), ("utm", True, 0.0), ("puck", False, 0.0)]
)
def test_a_lidar_of_short_range_stays_near_walls_and_where_it_nods_the_imu_counts(lidar, nod, reach_m):
    """7 m of the UST's 10 m: it still meets some 7 m of the wall to each side."""
    path = ROOT / "src/extensions/flights/launch/explore.launch"
    params = loaded(path, f"lidar:={lidar}", f"nod:={str(nod).lower()}").params
    assert params["/explore/planner/landmark_reach"].value == reach_m
    assert ("/lidar_odometry/acceleration_noise" in params) is nod


@pytest.mark.ros
@pytest.mark.parametrize(
    ("file", "given", "leaders"),
    [
        ("explore", [], {"explore"}),
        ("inspection", [], {"explore", "inspect"}),
        ("inspection", ["explore:=false"], {"inspect"}),
    ],
)
def test_cushions_fit_the_uav_and_lockstep_waits_for_the_map(file, given, leaders):
    path = ROOT / f"src/extensions/flights/launch/{file}.launch"
    for world, radius_m, manhole_m, height_m in (
        ("hold_3d", 0.35, math.inf, math.inf),
        ("hold_3d_cargo", 0.35, math.inf, math.inf),
        ("ballast_tank", 0.2, 0.6, 0.4),
    ):
        config = loaded(path, f"world:={world}", *given)
        params = {key: each.value for key, each in config.params.items()}
        assert {node.name for node in config.nodes} & {"explore", "inspect"} == leaders
        assert params["/cepa/height_min"] == LED_CEPA.height_min == -1000.0  # a hole may lead below the start
        assert params["/cepa/algorithm"] == "dynamic"
        for leader in leaders:
            assert params["/cepa/body_radius"] == params[f"/{leader}/planner/radius"] == radius_m
            clearance_m = radius_m + params[f"/{leader}/planner/margin"]
            assert radius_m <= clearance_m <= params["/cepa/r_lb"] < params["/cepa/r_ub"]
        assert 2.0 * params["/cepa/r_lb"] < manhole_m
        assert params["/cepa/body_below"] + params["/cepa/body_above"] < height_m
        waits_for = set(params["/gazebo/lockstep_participants"].split())
        assert waits_for == {
            f"/{node}/processed" for node in ("experiment", *leaders, "gridslam", "slam_octomap")
        }
    assert loaded(path, "lockstep:=false").params["/gazebo/lockstep_participants"].value == ""
    without = loaded(path, "sensors:=range_finder").params
    assert without["/cepa/height_min"].value == 0.3  # as cepa.yaml has it: nothing else sees the floor


@pytest.mark.ros
@pytest.mark.parametrize(
    ("volume", "mappers"), [("false", {"gridslam"}), ("true", {"gridslam", "slam_octomap"})]
)
def test_lockstep_of_a_mapping_flight_waits_for_every_map(volume, mappers):
    path = ROOT / "src/master_thesis/launch/experiment_4.launch"
    config = loaded(path, "lockstep:=true", "lidar:=puck", f"volume:={volume}")
    waits_for = set(config.params["/gazebo/lockstep_participants"].value.split())
    assert waits_for == {f"/{node}/processed" for node in ("experiment", "mission", *mappers)}


@pytest.mark.ros
def test_an_inspection_explores_unless_it_gets_a_plan_or_a_drawing():
    path = ROOT / "src/extensions/flights/launch/inspection.launch"
    world = str(ROOT / "src/extensions/flights/worlds/hold_3d.world")
    for given, explores, planned, read_at_start in (
        (None, True, "", ""),
        ("explore:=false", False, world, world),
        ("plan:=/plan.yaml", False, world, world),
        ("drawing:=/maps/hold.stl", False, "/maps/hold.stl", "/maps/hold.stl"),
        ("drawing:=/maps/map.bt", False, "/maps/map.bt", ""),
    ):
        params = {key: each.value for key, each in loaded(path, *([given] if given else [])).params.items()}
        assert params["/experiment/explore"] is explores
        assert params["/inspect/use_drawing"] is not explores
        assert os.path.normpath(params["/experiment/drawing"]) == os.path.normpath(planned)
        assert params["/inspect/drawing"] == read_at_start


@pytest.mark.ros
def test_exploration_and_photographs_of_an_inspection_have_their_own_times():
    path = ROOT / "src/extensions/flights/launch/inspection.launch"
    params = loaded(path, "explore_time:=61", "photograph_time:=62").params
    assert [params[f"/{node}/time_max"].value for node in ("explore", "inspect")] == [61.0, 62.0]


@pytest.mark.ros
def test_the_settings_of_an_inspection_say_the_defaults(tmp_path):
    """A line that is left out counts as its default, and one that is there counts."""
    path = ROOT / "src/extensions/flights/launch/inspection.launch"
    little = tmp_path / "little.yaml"
    little.write_text("camera: {lamp: 5000.0}\nexperiment: {draft: false}\n")
    shipped, without = (
        {key: each.value for key, each in loaded(path, *words).params.items()}
        for words in ([], [f"settings:={little}"])
    )
    assert (shipped["/camera/lamp"], without.pop("/camera/lamp")) == (24000.0, 5000.0)
    assert (shipped["/experiment/draft"], without.pop("/experiment/draft")) == (True, False)
    assert {key: shipped[key] for key in without} == without
    optics, survey = CameraOptics(), SurveyCamera()
    lens = {"width": optics.width, "height": optics.height, "field_of_view": optics.field_of_view_deg}
    camera = {**lens, "exposure": optics.exposure_s}
    assert (survey.width, survey.height, survey.field_of_view) == tuple(lens.values())
    left_out = {f"/{node}/{name}": value for node in ("camera", "camera_mavlink", "experiment")
                for name, value in camera.items()}  # fmt: skip
    left_out |= {"/experiment/search": 20.0, "/camera/lamp": 24000.0, "/experiment/draft": True}
    assert {key: value for key, value in shipped.items() if key not in without} == left_out


@pytest.mark.ros
def test_an_inspection_explores_as_explore_launch_does_but_for_the_speed_and_cepa_in_tanks():
    folder, other = ROOT / "src/extensions/flights/launch", ["/explore/speed", "/explore/ahead"]
    for world in ("hold_3d", "hold_3d_cargo", "ballast_tank"):
        left_out = [*other, "/explore/climbs_first"] if world == "ballast_tank" else other
        explored, inspected = (
            {
                key: each.value
                for key, each in loaded(folder / f"{file}.launch", f"world:={world}").params.items()
                if key.startswith("/explore/") and key not in left_out
            }
            for file in ("explore", "inspection")
        )
        assert inspected == explored


@pytest.mark.ros
@pytest.mark.parametrize("world", [HOLD, TANK])
def test_flights_without_ros_explore_as_the_launch_file_does(world):
    config = loaded(ROOT / "src/extensions/flights/launch/explore.launch", f"world:={world}")
    given = {key: each.value for key, each in config.params.items()}
    place = place_of(world, 1)
    asked, explorer = place.asked(600.0), place.explorer
    assert given["/position_controller/max_speed"] == explorer.speed
    assert given["/cepa/algorithm"] == given["/experiment/algorithm"] == place.uav.algorithm == "dynamic"
    for name in ("arrived", "ahead", "climbs_first", "steep"):
        assert given[f"/explore/{name}"] == getattr(asked, name), name
    assert given["/explore/view_choice"] == explorer.view_choice
    for name in (
        "elevation_min",
        "elevation_max",
        "reach",
        "cell",
        "spacing",
        "worth_min",
        "speed",
    ):
        assert given[f"/explore/{name}"] == pytest.approx(getattr(explorer, name), abs=1e-3), name


@pytest.mark.ros
@pytest.mark.parametrize("lidar", CLOUD_LIDARS)
def test_explorer_and_cepa_know_where_a_lidar_s_beams_look(lidar):
    model = ElementTree.parse(ROOT / f"src/simulation_tools/models/lidar_{lidar}/model.sdf").getroot()
    (ray,) = model.iterfind(".//sensor[@name='cloud']/ray")
    beams = [float(ray.findtext(f"scan/vertical/{end}_angle")) for end in ("min", "max")]
    config = loaded(ROOT / "src/extensions/flights/launch/explore.launch", f"lidar:={lidar}")
    params = {key: each.value for key, each in config.params.items()}
    assert [params[f"/explore/elevation_{end}"] for end in ("min", "max")] == pytest.approx(beams, abs=1e-3)
    limits = yaml.safe_load((ROOT / f"src/cepa/config/clouds/{lidar}.yaml").read_text())
    assert [limits["elevation_min"], limits["elevation_max"]] == pytest.approx(beams, abs=1e-3)
    ranges = [float(ray.findtext(f"range/{end}")) for end in ("min", "max")]
    assert [limits["range_min"], limits["range_max"]] == ranges


def test_launch_files_know_which_lidars_have_clouds():
    models = (ROOT / "src/simulation_tools/models").glob("lidar_*/model.sdf")
    with_cloud = {file.parent.name.removeprefix("lidar_") for file in models if '"cloud"' in file.read_text()}
    assert with_cloud == set(CLOUD_LIDARS)
    texts = [file.read_text() for file in ROOT.glob("src/**/launch/**/*.launch")]
    lists = [found for text in texts for found in re.findall(r"lidar in (\(.*?\))", text)]
    assert len(lists) >= 5
    assert {ast.literal_eval(each) for each in lists} == {CLOUD_LIDARS}


def test_the_simulator_knows_who_writes_down_why_a_run_failed():
    """An error that comes at once, such as a program that is no ArduPilot, waits for this node."""
    roots = [ElementTree.parse(path).getroot() for path in ROOT.glob("src/**/launch/**/*.launch")]
    drivers = [root for root in roots if root.find("node[@name='experiment']") is not None]
    assert len(drivers) >= 4
    for root in drivers:
        told = root.find("param[@name='gazebo/heard_by']")
        assert told is not None
        assert told.get("value") == "experiment"
