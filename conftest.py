"""What all tests share: the libraries on the path, the markers, a ROS master of one's own.

Tests may run in several processes (pytest-xdist). A file's tests stay in one process, where they share what
is dear to make; those of the files `APART` share nothing. No test measures wall time, because others run
beside it.
"""

from __future__ import annotations

import contextlib
import gc
import itertools
import os
import shutil
import signal
import socket
import subprocess
import sys
import time
import uuid
from pathlib import Path
from typing import Any, Callable, Iterator, NoReturn

import pytest
from hypothesis import HealthCheck, settings

ROOT = Path(__file__).resolve().parent
# Environment variables by which everything that a test, or any test of a run, has started is found again
TOKEN, RUN_TOKEN = "WORKSPACE_TEST", "WORKSPACE_TEST_RUN"

RUN = pytest.StashKey[str]()

# Libraries are tested where nothing is built, too; a built workspace comes first, it has messages as well.
sys.path += [*sorted(str(path) for path in ROOT.glob("src/**/src")), str(ROOT)]

# Tests run beside each other. More threads in numpy would wait for each other, and they wait by computing.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

EXAMPLES, ALL_EXAMPLES = 20, 50
"""Of each property; where one example is dear, the test itself names fewer."""


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add `--all`: what CI runs."""
    words = f"also the tests marked `long`, and {ALL_EXAMPLES} examples of a property instead of {EXAMPLES}"
    parser.addoption("--all", action="store_true", help=words)


def pytest_configure(config: pytest.Config) -> None:
    """Choose the examples; mark all that this run starts, and let SIGTERM end it as Ctrl-C does."""
    # Nobody's: somebody may fly at the usual master. A test that needs one starts it, and says where.
    os.environ["ROS_MASTER_URI"] = "http://127.0.0.1:1"
    if RUN_TOKEN not in os.environ and config.args_source is pytest.Config.ArgsSource.ARGS:
        config.option.all = True  # who names a file or a test means all of it; workers are told
    # On a busy machine any example of hypothesis may be slow, which is no fault of what is tested.
    # Every run tries the same ones.
    settings.register_profile(
        "any_machine",
        max_examples=ALL_EXAMPLES if config.option.all else EXAMPLES,
        deadline=None,
        derandomize=True,
        suppress_health_check=[HealthCheck.too_slow],
    )
    settings.load_profile("any_machine")
    if RUN_TOKEN not in os.environ:  # else this is a worker of the run
        os.environ[RUN_TOKEN] = config.stash[RUN] = uuid.uuid4().hex
        signal.signal(signal.SIGTERM, interrupt)


def interrupt(*_: object) -> NoReturn:
    """Do what Ctrl-C in a terminal does: it tells the workers, too, which otherwise go on for 5 s."""
    for pid in marked(RUN_TOKEN, os.environ[RUN_TOKEN]):
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, signal.SIGINT)
    raise KeyboardInterrupt


def pytest_unconfigure(config: pytest.Config) -> None:
    """Leave nothing behind, also when the run was interrupted and a worker had no time to clear up."""
    if RUN in config.stash:
        stop_all(lambda: marked(RUN_TOKEN, config.stash[RUN]))


def why_no_ros() -> str | None:
    """Return why tests that need ROS cannot run here, or None."""
    if not shutil.which("roslaunch"):
        return "needs ROS, which is not installed: ./bringup.sh setup"
    if not (ROOT / "devel/setup.bash").exists():
        return "needs the built workspace: ./bringup.sh setup"
    if str(ROOT / "devel") not in os.environ.get("CMAKE_PREFIX_PATH", "").split(":"):
        return "needs the workspace's environment: source devel/setup.bash"
    return None


@pytest.hookimpl(hookwrapper=True)
def pytest_collection() -> Iterator[None]:
    """Collect no garbage while the test files are imported: that took a third of the time."""
    gc.disable()
    yield
    gc.freeze()
    gc.set_threshold(50_000)  # flights make many short-lived tuples
    gc.enable()


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Skip the tests marked `ros` where there is no ROS, and say so; leave the long ones to `--all`."""
    if not config.option.all:
        left_out = [item for item in items if item.get_closest_marker("long")]
        items[:] = [item for item in items if not item.get_closest_marker("long")]
        config.hook.pytest_deselected(items=left_out)
    reason = why_no_ros()
    for item in items:
        if reason and item.get_closest_marker("ros"):
            item.add_marker(pytest.mark.skip(reason=reason))
    if "PYTEST_XDIST_WORKER" in os.environ:
        items.sort(key=turn)


# -- tables -------------------------------------------------------------------------------------------------


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Make one test of a function with `@pytest.mark.table(names, rows)`, whatever the number of its rows."""
    for table in metafunc.definition.iter_markers("table"):
        names = table.args[0]
        one_row = [None] if isinstance(names, str) and "," not in names else [(None,) * len(names_in(names))]
        metafunc.parametrize(names, one_row, ids=[pytest.HIDDEN_PARAM])


@pytest.hookimpl(tryfirst=True)
def pytest_pyfunc_call(pyfuncitem: pytest.Function) -> bool | None:
    """Call a test with each row of its tables (`parametrize`, which makes a test of each row, costs more).

    Rows share the fixtures, but each has its own folder `tmp_path` and its own `monkeypatch`.
    """
    tables = [(names_in(each.args[0]), each.args[1]) for each in pyfuncitem.iter_markers("table")]
    if not tables:
        return None
    fixtures = {name: pyfuncitem.funcargs[name] for name in pyfuncitem._fixtureinfo.argnames}
    failed = []
    for number, rows in enumerate(itertools.product(*(rows for _, rows in tables))):
        given = dict(fixtures)
        for (names, _), row in zip(tables, rows):
            given.update(zip(names, cells_of(row, len(names))))
        if "tmp_path" in given:
            given["tmp_path"] = given["tmp_path"] / f"row_{number}"
            given["tmp_path"].mkdir()
        try:
            pyfuncitem.obj(**given)
        except (Exception, pytest.fail.Exception) as error:
            error.add_note(f"in row {number} of the table: {rows!r}")
            failed.append(error)
        finally:
            if "monkeypatch" in given:
                given["monkeypatch"].undo()
    if failed:
        failed[0].add_note("\n".join(note for error in failed[1:] for note in error.__notes__))
        raise failed[0]
    return True


def cells_of(row: Any, count: int) -> tuple[Any, ...]:
    """Return the cells of a table's row, also where it is a `pytest.param`. A mark needs `parametrize`."""
    if isinstance(row, type(pytest.param())):
        assert not row.marks, "a row of a table has no marks of its own; use parametrize"
        return tuple(row.values)
    return tuple(row) if count > 1 else (row,)


def names_in(names: str | list[str] | tuple[str, ...]) -> list[str]:
    """Return the names of a table's columns."""
    return [each.strip() for each in names.split(",") if each.strip()] if isinstance(names, str) else [*names]


# -- several tests at a time --------------------------------------------------------------------------------


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers(config: pytest.Config) -> int:
    """Say what `-n auto` is on two cores: tests with ROS wait half of their time, the others hardly ever."""
    return 2 if config.option.markexpr == "not ros" else 4


# The dearest come first, so that no process still runs one when the others are done.
FIRST = (
    "tests/flights/test_flights.py",
    "tests/flights/test_experiment_1.py",
    "src/master_thesis/test/report/test_report.py",
    "tests/flights/",
    "tests/test_rostests.py",
    "src/extensions/flights/test/exploring/",
    "tests/",
)
# Files whose tests share nothing, but are dear: each test may run in another process.
APART = ("tests/flights/test_flights.py", "tests/flights/test_node_as_loop.py", "tests/test_rostests.py")


def turn(item: pytest.Item) -> int:
    """Return when a test's turn comes: the dear ones, then those of the whole workspace, then the rest."""
    return next((i for i, begin in enumerate(FIRST) if item.nodeid.startswith(begin)), len(FIRST))


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Let the processes share the tests of the files `APART`. As one file, the rostests alone took 8 min."""
    if config.getoption("dist") != "loadfile":
        return None
    from xdist.scheduler import LoadFileScheduling

    class Scheduling(LoadFileScheduling):
        def _split_scope(self, nodeid: str) -> str:
            return nodeid if nodeid.startswith(APART) else super()._split_scope(nodeid)

    return Scheduling(config, log)


# -- what tests start ---------------------------------------------------------------------------------------


ASKING = (signal.SIGINT, signal.SIGTERM)
"""Signals that ask a process to end."""


@pytest.fixture(autouse=True)
def signals_pass() -> Iterator[None]:
    """Fail a test that leaves signals blocked, and unblock them: whatever starts later would inherit that."""
    yield
    blocked = signal.pthread_sigmask(signal.SIG_UNBLOCK, ASKING).intersection(ASKING)
    assert not blocked, f"This test left {blocked} blocked in its process."


def heed_interrupts() -> None:
    """Let SIGINT count again: tests run in a shell's background would inherit that it is ignored."""
    signal.pthread_sigmask(signal.SIG_UNBLOCK, ASKING)
    signal.signal(signal.SIGINT, signal.SIG_DFL)


class Processes:
    """Starts commands in one environment; `stop` ends them and all that they started, in any group."""

    def __init__(self, environment: dict[str, str]) -> None:
        self._token = uuid.uuid4().hex
        # Unbuffered: a test that waits for a node's words must not wait for a full buffer.
        self.environment = {**os.environ, "PYTHONUNBUFFERED": "1", **environment, TOKEN: self._token}

    def start(self, *command: str, **options) -> subprocess.Popen:
        """Start a command; options are Popen's."""
        return subprocess.Popen(
            command, env=self.environment, start_new_session=True, preexec_fn=heed_interrupts, **options
        )

    def start_node(self, package: str, node: str, *words: str, **options) -> subprocess.Popen:
        """Start a node without rosrun, which takes 0.4 s of CPU time to find the program."""
        return self.start(str(ROOT / "devel/lib" / package / node), *words, **options)

    def run(self, *command: str, timeout_s: float) -> subprocess.CompletedProcess:
        """Run a command to its end; returns its code, and all that it said as `stdout`.

        Raises:
            subprocess.TimeoutExpired: it took longer; `output` then holds what it said until then.
        """
        child = self.start(
            *command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace"
        )
        try:
            said, _ = child.communicate(timeout=timeout_s)
        except subprocess.TimeoutExpired as error:
            self.stop()
            error.output, _ = child.communicate()
            raise
        return subprocess.CompletedProcess(command, child.returncode, said)

    def stop(self) -> None:
        """End everything that was started here, and what that has started."""
        stop_all(lambda: marked(TOKEN, self._token))


def stop_all(find: Callable[[], list[int]]) -> None:
    """End the processes that `find` returns: asked with SIGINT, then SIGTERM, then killed."""
    for number, patience_s in ((signal.SIGINT, 5.0), (signal.SIGTERM, 2.0), (signal.SIGKILL, 2.0)):
        for pid in find():
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, number)
        end = time.monotonic() + patience_s
        while find() and time.monotonic() < end:
            time.sleep(0.05)


def marked(variable: str, value: str) -> list[int]:
    """Return the processes, but this one, that have this value of a variable in their environment."""
    mark = f"{variable}={value}".encode()
    found = []
    for path in Path("/proc").glob("[0-9]*"):
        try:
            ours = mark in (path / "environ").read_bytes().split(b"\0")
            zombie = (path / "stat").read_text().rpartition(")")[2].split()[0] == "Z"
        except OSError:
            continue
        if ours and not zombie and int(path.name) != os.getpid():
            found.append(int(path.name))
    return found


@pytest.fixture
def processes(tmp_path):
    """Start commands that leave nothing behind: no process, and no file outside the test's own folder."""
    started = Processes({"ROS_HOME": str(tmp_path / "ros"), "ROS_LOG_DIR": str(tmp_path / "ros/log")})
    yield started
    started.stop()


@pytest.fixture(scope="module")
def processes_of_module(tmp_path_factory):
    """Like `processes`, for what several tests of one file look at."""
    folder = tmp_path_factory.mktemp("ros")
    started = Processes({"ROS_HOME": str(folder), "ROS_LOG_DIR": str(folder / "log")})
    yield started
    started.stop()


@pytest.fixture
def ros_master(processes):
    """Like `processes`, with a ROS master of their own, which `environment` leads to."""
    return start_master(processes)


@pytest.fixture(scope="module")
def master_of_module(processes_of_module):
    """Like `ros_master`, for what several tests of one file look at."""
    return start_master(processes_of_module)


def start_master(processes: Processes) -> Processes:
    """Start a ROS master on a free port, lead `processes` to it, and wait until it answers."""
    from flights.graph.free_ports import free_ports

    (port,) = free_ports(1)
    processes.environment["ROS_MASTER_URI"] = f"http://localhost:{port}"
    master = processes.start("rosmaster", "--core", "-p", str(port), stdout=subprocess.DEVNULL)
    end = time.monotonic() + 60.0
    while time.monotonic() < end:
        with socket.socket() as sock:
            if sock.connect_ex(("127.0.0.1", port)) == 0:
                return processes
        assert master.poll() is None, "rosmaster ended"
        time.sleep(0.05)
    raise TimeoutError("rosmaster did not answer within 60 s")
