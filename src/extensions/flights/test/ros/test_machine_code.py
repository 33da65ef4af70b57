"""A launch compiles what its flight needs, before it takes off, and says how far it is."""

import io
import signal
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("flights_ros")
from flights.errors import FlightError
from flights_ros.launch import machine_code, request
from flights_ros.launch.machine_code import compile_missing, needed_by

ROOT = Path(__file__).resolve().parents[5]
KERNELS = """
from kernel_cache.compiler import njit

@njit(cache=True)
def doubled(x):
    return 2 * x

@njit(cache=True)
def more(x):
    return doubled(x) + 1

def warm_up():
    more(1)
"""


def parts_of(launch_file, **given):
    (path,) = ROOT.glob(f"src/**/launch/{launch_file}")
    return set(needed_by(request.values_of(path, given)))


@pytest.mark.ros
def test_each_launch_compiles_what_it_flies_with():
    gnss_flight = {machine_code.SIMULATOR, machine_code.THESIS_CEPA}
    assert parts_of("experiment_1.launch", scenario="forest") == gnss_flight
    first_flight = parts_of("experiment_1.launch", scenario="forest", algorithm="dynamic")
    assert first_flight == {machine_code.SIMULATOR, machine_code.DYNAMIC_CEPA}
    assert first_flight == set(machine_code.FIRST_FLIGHT)
    own_avoidance = parts_of("experiment_1.launch", avoidance="my_package my_node")
    assert own_avoidance == {machine_code.SIMULATOR}
    mapping = {*gnss_flight, machine_code.SLAM, machine_code.LOOP_CLOSURE}
    assert parts_of("experiment_4.launch") == mapping
    assert parts_of("experiment_4.launch", gnss="false") == {*mapping, machine_code.ODOMETRY}
    assert parts_of("real.launch") == {machine_code.DYNAMIC_CEPA}
    assert parts_of("real.launch", slam="true", gnss="false", algorithm="improved") == {
        machine_code.THESIS_CEPA,
        machine_code.SLAM,
        machine_code.LOOP_CLOSURE,
        machine_code.ODOMETRY,
    }
    assert parts_of("fly_to_goal.launch", world="w", goal="1 0 2", planner="true") == {
        *(machine_code.SIMULATOR, machine_code.DYNAMIC_CEPA, machine_code.CLOUD_ODOMETRY),
        *(machine_code.SLAM, machine_code.LOOP_CLOSURE, machine_code.VOLUME),
    }
    assert set(machine_code.ALL) >= parts_of("teleop.launch", gnss="false", algorithm="dynamic")


def test_what_is_noted_is_a_digest_of_the_sources_wherever_python_finds_the_package():
    """Or a launch would not see that a kernel has changed, and setup would ask numba again at each call."""
    for part in machine_code.ALL:
        package, module = part.partition(":")[0].split(".", 1)
        assert machine_code._folder(package).joinpath(*module.split(".")).with_suffix(".py").is_file(), part


def test_all_parts_together_are_all_kernels():
    """Or setup would leave one for the flight."""
    script = """
import sys
from flights_ros.launch.compile_parts import _function
from flights_ros.launch.machine_code import ALL
from node_tools.compiling import Kernels, _is_kernel
counted = Kernels(*map(_function, ALL))
packages = {part.partition(".")[0] for part in ALL}
modules = [module for name, module in sys.modules.items() if name.partition(".")[0] in packages]
found = {value for module in modules for value in vars(module).values() if _is_kernel(value)}
print(len(counted), len(found))
"""
    told = subprocess.run([sys.executable, "-c", script], env=libraries(), capture_output=True, text=True)
    counted, found = map(int, told.stdout.split())
    assert counted == found > 200, told.stderr


def libraries(*first):
    folders = [*first, *ROOT.glob("src/**/src"), *ROOT.glob("src/**/ros")]
    return {"PATH": "/usr/bin:/bin", "PYTHONPATH": ":".join(map(str, folders))}


@pytest.fixture
def part(tmp_path, monkeypatch):
    """A part of two kernels, and an environment in which nothing is noted."""
    package = tmp_path / "loops_to_compile"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "warm_up.py").write_text(KERNELS)
    for name, value in libraries(tmp_path).items():
        monkeypatch.setenv(name, value)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(sys, "prefix", str(tmp_path / "environment"))
    (tmp_path / "environment").mkdir()
    return "loops_to_compile.warm_up:warm_up"


def said_by_compiling(part):
    out = io.StringIO()
    compile_missing([part], 0.0, out)
    return out.getvalue()


def test_the_fraction_is_shown_once_and_again_when_the_sources_change(part, tmp_path):
    said = said_by_compiling(part)
    assert "1 of 2\n" in said
    assert "2 of 2\n" in said
    assert said.endswith("all 2 are ready\n")
    assert list(tmp_path.rglob("*.nbc"))
    assert said_by_compiling(part) == ""
    (tmp_path / "loops_to_compile/warm_up.py").write_text(KERNELS.replace("2 * x", "3 * x"))
    assert "2 of 2\n" in said_by_compiling(part)


def test_what_cannot_be_compiled_is_one_sentence_and_is_tried_again(part, tmp_path):
    source = tmp_path / "loops_to_compile/warm_up.py"
    source.write_text(KERNELS.replace("more(1)", "more('a')\n    raise OSError('the disk is full')"))
    for _ in range(2):
        with pytest.raises(FlightError, match=r"loops_to_compile could not be compiled: .+\. `.+` shows all"):
            said_by_compiling(part)


@pytest.fixture
def blocked():
    """A process that blocks signals, as a node does. What it starts inherits that."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, (signal.SIGINT, signal.SIGTERM))
    yield
    signal.pthread_sigmask(signal.SIG_SETMASK, before)


@pytest.mark.usefixtures("blocked")
def test_after_an_interruption_the_next_call_compiles(part, tmp_path, monkeypatch):
    package = tmp_path / "loops_to_compile"
    waiting = "def warm_up():\n    while (Path(__file__).parent / 'held').exists():\n        sleep(0.01)"
    imports = "from pathlib import Path\nfrom time import sleep"
    (package / "warm_up.py").write_text(imports + KERNELS.replace("def warm_up():", waiting))
    (package / "held").touch()  # the compiler cannot be ready before the interruption
    with monkeypatch.context() as patch:
        patch.setattr(machine_code._Compiler, "complaint", lambda self: interrupt())
        with pytest.raises(KeyboardInterrupt):
            said_by_compiling(part)
    (package / "held").unlink()
    assert "all 2 are ready" in said_by_compiling(part)


def interrupt():
    raise KeyboardInterrupt


def test_the_kernels_of_a_package_below_count_too(monkeypatch, tmp_path):
    monkeypatch.setattr(machine_code, "_folder", lambda package: tmp_path / package)
    (tmp_path / "exploration").mkdir()
    before = machine_code._digest(machine_code.PATHS)
    (tmp_path / "exploration/kernels.py").write_text("A = 1")
    assert machine_code._digest(machine_code.PATHS) != before
