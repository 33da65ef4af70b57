"""Measurements 1 and 2: times to build, launch and shut down this workspace (8.3)."""

from __future__ import annotations

import os
import shutil
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Iterator, Sequence

from flights.errors import GraphError
from flights.graph.free_ports import free_ports
from flights.graph.launched_graph import LaunchedGraph
from master_thesis.report.piece import Piece
from master_thesis.report.size import Size

ROOT = Path(__file__).resolve().parents[5]
PATIENCE_S = 90.0
BUILD_PATIENCE_S = 600.0
_DISPLAY_END_S = 5.0
ALTERED_FILE = "src/cepa/cfg"
GENERATED_FROM = (".msg", ".srv", ".action", ".cfg")
_BUILD_COST_S, _LAUNCH_COST_S = 60.0, 12.0

LAUNCHES = ("Gazebo", "Gazebo with PX4", "Gazebo with Rviz", "Experiment 1")
"""The columns of table 8.4, and the whole graph of an experiment."""


def pieces(size: Size) -> list[Piece]:
    """Return the pieces of this size."""
    builds = [
        Piece(
            name=f"measurement_1_{size.builds}_times",
            experiment="measurement_1",
            title="Measurement 1: builds",
            run=make_builds,
            given={"repeats": size.builds},
            cost_s=_BUILD_COST_S * size.builds,
            alone=True,
        )
    ]
    launches = [
        Piece(
            name=f"measurement_2_{what.lower().replace(' ', '_')}_{size.launches}_times",
            experiment="measurement_2",
            title=f"Measurement 2: {what}, start and end",
            run=make_launches,
            given={"what": what, "repeats": size.launches},
            cost_s=_LAUNCH_COST_S * size.launches,
            alone=True,
        )
        for what in LAUNCHES
    ]
    return (builds if size.builds else []) + (launches if size.launches else [])


# -- measurement 1 ------------------------------------------------------------------------------------------


def make_builds(repeats: int) -> dict:
    """Build a copy of the workspace, from nothing and after files were altered; medians in seconds."""
    rounds = []
    for _ in range(repeats):
        with tempfile.TemporaryDirectory(prefix="report_build_") as folder:
            rounds.append(_build_round(Path(folder)))
    medians = {name: statistics.median(found[name] for found in rounds) for name in rounds[0]}
    return {"seconds": medians, "repeats": repeats}


def _build_round(folder: Path) -> dict[str, float]:
    ignored = shutil.ignore_patterns("__pycache__", "*.pyc", ".pytest_cache")
    shutil.copytree(ROOT / "src", folder / "src", symlinks=True, ignore=ignored)
    toplevel = folder / "src/CMakeLists.txt"
    if toplevel.is_symlink() or toplevel.exists():
        toplevel.unlink()  # catkin_make makes this link again
    generated = sorted(p for p in (folder / "src").rglob("*") if p.suffix in GENERATED_FROM)
    one = sorted((folder / ALTERED_FILE).glob("*.cfg"))[0]
    return {
        "from nothing": _catkin_make(folder),
        "nothing altered": _catkin_make(folder),
        "one file": _catkin_make(folder, altered=[one]),
        "many files": _catkin_make(folder, altered=generated),
        "single package": _catkin_make(folder, "--pkg", "cepa", altered=[one]),
        "files altered": float(len(generated)),
    }


def _catkin_make(folder: Path, *arguments: str, altered: Sequence[Path] = ()) -> float:
    """Return the time of a build, s."""
    for path in altered:
        path.write_text(path.read_text(encoding="utf-8") + "\n", encoding="utf-8")
    command = ["catkin_make", "--directory", str(folder), *arguments]
    # Debian 12's catkin reads the first name of the interpreter, Debian 13's the second
    command += [f"-D{name}={sys.executable}" for name in ("PYTHON_EXECUTABLE", "Python_EXECUTABLE")]
    command += [f"-DCATKIN_BLACKLIST_PACKAGES={_left_out()}"]
    began_s = time.monotonic()
    code, said = _run(command)
    if code:
        raise GraphError(f"The build failed; it said:\n{said[-1500:]}")
    return time.monotonic() - began_s


def _run(command: list[str]) -> tuple[int, str]:
    """Return a command's exit code and output. An interruption ends all processes of the command."""
    try:
        running = subprocess.Popen(
            command,
            env=_outside_the_workspace(),
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
        )
    except FileNotFoundError:
        sentence = "There is no catkin_make; call ./bringup.sh, which loads ROS's environment."
        raise GraphError(sentence) from None
    with running:
        try:
            said, _ = running.communicate(timeout=BUILD_PATIENCE_S)
        except BaseException:
            os.killpg(running.pid, signal.SIGKILL)
            raise
    return running.returncode, said


def _left_out() -> str:
    """Return the packages that bringup.sh did not build, because upstream's are installed."""
    try:
        lines = (ROOT / "build/CMakeCache.txt").read_text(encoding="utf-8").splitlines()
    except OSError:
        return ""
    return next((line.split("=", 1)[1] for line in lines if line.startswith("CATKIN_BLACKLIST_PACKAGES")), "")


def _outside_the_workspace() -> dict[str, str]:
    """Return the environment without the workspace's own set-up."""
    devel = str(ROOT / "devel")
    environment = {key: value for key, value in os.environ.items() if key != "CATKIN_TEST_RESULTS_DIR"}
    for name in ("CMAKE_PREFIX_PATH", "PYTHONPATH", "PKG_CONFIG_PATH", "LD_LIBRARY_PATH", "ROS_PACKAGE_PATH"):
        parts = [part for part in environment.pop(name, "").split(os.pathsep) if part]
        kept = [part for part in parts if not part.startswith((devel, str(ROOT / "src")))]
        if kept:
            environment[name] = os.pathsep.join(kept)
    return environment


# -- measurement 2 ------------------------------------------------------------------------------------------


def make_launches(what: str, repeats: int) -> dict:
    """Launch until ready, then press Ctrl-C; medians in seconds."""
    rounds = [_launch(what) for _ in range(repeats)]
    return {
        "what": what,
        "startup_s": statistics.median(startup_s for startup_s, _ in rounds),
        "shutdown_s": statistics.median(shutdown_s for _, shutdown_s in rounds),
        "repeats": repeats,
    }


_READY = {
    "Gazebo": ("first_scan",),
    "Gazebo with PX4": ("first_scan", "flight_controller"),
    "Gazebo with Rviz": ("first_scan", "rviz"),
    "Experiment 1": ("first_scan_through",),
}
"""The events after which all nodes are ready."""


def _launch(what: str) -> tuple[float, float]:
    """Return the seconds to start and to end."""
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="report_launch_")))
        display = stack.enter_context(_display()) if "Rviz" in what else None
        graph = LaunchedGraph(folder, *_arguments(what, folder), events=_READY[what], display=display)
        stack.callback(graph.close)
        startup_s = max(graph.wait_for(event, PATIENCE_S) for event in _READY[what])
        return startup_s, graph.interrupt()


def _arguments(what: str, folder: Path) -> list[str]:
    ports = [f"{name}:={port}" for name, port in zip(("offboard_port", "gcs_port"), free_ports(2))]
    if what == "Experiment 1":
        return ["master_thesis", "experiment_1.launch", "headless:=true", f"results:={folder}", *ports]
    if what == "Gazebo with PX4":
        return ["simulation_tools", "sitl.launch", *ports]
    if what == "Gazebo":
        return ["simulation_tools", "sitl.launch", "mavros:=none", *ports]
    file = folder / "gazebo_and_rviz.launch"
    file.write_text(_GAZEBO_AND_RVIZ, encoding="utf-8")
    return [str(file), *ports]


_GAZEBO_AND_RVIZ = """<launch>
  <arg name="offboard_port"/>
  <arg name="gcs_port"/>
  <include file="$(find simulation_tools)/launch/sitl.launch" pass_all_args="true">
    <arg name="mavros" value="none"/>
  </include>
  <node pkg="rviz" type="rviz" name="rviz" args="-d $(find flights)/rviz/experiment.rviz"/>
</launch>
"""


@contextmanager
def _display() -> Iterator[str]:
    """Yield the name of an X server without a screen."""
    command = ["Xvfb", "-displayfd", "1", "-screen", "0", "1280x800x24", "-nolisten", "tcp"]
    try:
        server = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    except FileNotFoundError:
        raise GraphError("There is no Xvfb for RViz's window; install the package xvfb.") from None
    assert server.stdout is not None
    try:
        number = server.stdout.readline().strip()
        if not number:
            raise GraphError("Xvfb did not start.")
        yield f":{number}"
    finally:
        server.terminate()
        try:
            server.wait(_DISPLAY_END_S)
        except subprocess.TimeoutExpired:  # the caller blocks signals, and the server inherited that
            server.kill()
            server.wait()
        server.stdout.close()
