"""What users have around them in a shell: another Python, and a folder of their own."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

from flights.graph.free_ports import free_ports

ROOT = Path(__file__).resolve().parents[2]
SETUP_PATIENCE_S = 400.0

pytestmark = pytest.mark.ros


def sourced(command: str, first_on_path: Path) -> subprocess.CompletedProcess:
    """Run a command as in a new shell with nothing but this folder before the system's, after `source`."""
    environment = {"HOME": os.environ.get("HOME", "/"), "PATH": f"{first_on_path}:/usr/bin:/bin"}
    script = f"source {ROOT}/devel/setup.bash && {command}"
    return subprocess.run(
        ["bash", "-c", script], env=environment, capture_output=True, text=True, timeout=200.0, check=False
    )


def python_in(folder: Path, options: str) -> Path:
    """Make a folder with a python3 that is started with these options."""
    folder.mkdir()
    python = folder / "python3"
    python.write_text(f'#!/bin/sh\nexec /usr/bin/python3 {options} "$@"\n')
    python.chmod(0o755)
    return folder


def test_ros_scripts_run_where_another_python_is_first(tmp_path):
    # Given a python3 that, as pyenv's, knows nothing of ROS
    other = python_in(tmp_path / "other", "-I -S")
    run = sourced("rosrun dynamic_reconfigure dynparam --help", other)
    assert "dynparam set " in run.stdout, run.stdout + run.stderr
    assert "Traceback" not in run.stderr


def test_a_python_that_knows_ros_stays_first(tmp_path):
    own = python_in(tmp_path / "own", "")
    assert sourced("command -v python3", own).stdout.strip() == str(own / "python3")


def test_nodes_of_a_workspace_whose_venv_was_deleted_say_what_to_do(tmp_path):
    """The interpreter that all nodes name in their first line, in a workspace without .venv."""
    script = (
        f'root="{tmp_path}" log_file=/dev/null && cd "$root" && source {ROOT}/scripts/console.sh && '
        f"source {ROOT}/scripts/setup.sh && write_interpreter"
    )
    subprocess.run(["bash", "-ec", script], check=True)
    interpreter = tmp_path / "devel/interpreter/python3"
    node = tmp_path / "node"
    node.write_text(f"#!{interpreter}\nimport sys\nprint(sys.argv[1], sys.executable)\n")
    node.chmod(0o755)
    run = subprocess.run([node, "a b"], capture_output=True, text=True, check=False)
    assert run.returncode == 127
    what = f"There is no interpreter {tmp_path}/.venv/bin/python."
    assert run.stderr == f"{what} Call {tmp_path}/bringup.sh setup, which makes it again.\n"
    # When it is there again
    (tmp_path / ".venv/bin").mkdir(parents=True)
    (tmp_path / ".venv/bin/python").symlink_to("/usr/bin/python3")
    run = subprocess.run([node, "a b"], capture_output=True, text=True, check=False)
    assert run.stdout == f"a b {tmp_path}/.venv/bin/python\n"


def test_nodes_run_on_the_interpreter_that_says_so():
    for node in (ROOT / "devel/lib/cepa/cepa", ROOT / "devel/lib/flights/check_flight"):
        assert node.read_text().splitlines()[0] == f"#!{ROOT}/devel/interpreter/python3"


@pytest.mark.parametrize(("display", "rviz"), [("", []), (":7", ["rviz:=true"])])
def test_bringup_without_arguments_flies_the_forest_with_the_safer_algorithm(tmp_path, display, rviz):
    # Given bringup.sh that prints what it would launch
    (tmp_path / "scripts").symlink_to(ROOT / "scripts")
    lines = (ROOT / "bringup.sh").read_text().splitlines()
    assert lines[-1] == 'main "$@"'
    stub = 'launch() { printf "%s\\n" "$@"; }'
    (tmp_path / "bringup.sh").write_text("\n".join((*lines[:-1], stub, lines[-1], "")))
    run = subprocess.run(
        ["bash", str(tmp_path / "bringup.sh")],
        env={**os.environ, "DISPLAY": display},
        capture_output=True,
        text=True,
        check=True,
    )
    file = "src/master_thesis/launch/experiment_1.launch"
    assert run.stdout.split() == [file, "scenario:=forest", "algorithm:=dynamic", *rviz]


def test_relative_paths_of_arguments_are_the_callers(tmp_path):
    """What an argument's doc calls a file or a folder is one; names of ours stay names."""
    (tmp_path / "mine.world").touch()
    (tmp_path / "forest").mkdir()
    launch = ROOT / "src/extensions/flights/launch"
    expected = {
        (launch / "inspection.launch", "world", "mine.world"): f"{tmp_path}/mine.world",
        (launch / "inspection.launch", "world", "hold_3d"): "hold_3d",
        (launch / "inspection.launch", "model", "iris"): "iris",
        (launch / "inspection.launch", "model", "./iris"): f"{tmp_path}/./iris",
        (launch / "inspection.launch", "results", "out"): f"{tmp_path}/out",
        (ROOT / "src/gridslam/launch/gridslam.launch", "state_file", "state"): f"{tmp_path}/state",
        (ROOT / "src/master_thesis/launch/experiment_1.launch", "scenario", "forest"): "forest",
    }
    absolute = (
        "absolute"
        + (ROOT / "bringup.sh").read_text().partition("\nabsolute")[2].partition("\n}\n")[0]
        + "\n}"
    )
    calls = "; ".join(f"path_of_caller {file} {name} {value}" for file, name, value in expected)
    script = f"caller={tmp_path}; {absolute}\nsource {ROOT}/scripts/launch.sh; {calls}"
    run = subprocess.run(["bash", "-c", script], capture_output=True, text=True, check=True)
    assert run.stdout.split() == list(expected.values())


@pytest.mark.timeout(SETUP_PATIENCE_S + 240.0)
def test_bringup_takes_a_worlds_path_from_the_callers_folder(processes, tmp_path):
    folder = tmp_path / "a folder"
    folder.mkdir()
    (folder / "broken.world").write_text('<?xml version="1.0"?>\n<sdf version="1.6"><world')
    bringup = str(ROOT / "bringup.sh")
    master, offboard, ground = free_ports(3)
    processes.environment["ROS_MASTER_URI"] = f"http://localhost:{master}"
    ports = (f"offboard_port:={offboard}", f"gcs_port:={ground}")
    words = ("fly_to_goal", "world:=broken.world", "goal:=3 0 2", "results:=my results", *ports)
    caller = ("bash", "-c", 'cd "$1" && shift && exec "$@"', "-", str(folder))
    # Sources that changed since the last set-up are built, and their kernels compiled, before anything starts
    refused = processes.run(*caller, bringup, *words, timeout_s=SETUP_PATIENCE_S)
    assert refused.returncode == 1
    assert f"{folder}/broken.world:2: " in refused.stdout
    assert "process[" not in refused.stdout
    assert "Traceback" not in refused.stdout
    assert not (folder / "my results").exists()
    refused = processes.run(*caller, bringup, "experiment_3", "mission:=none.yaml", *ports, timeout_s=200.0)
    assert f"The mission {folder}/none.yaml cannot be read: " in refused.stdout
