"""Compiles the numba kernels that a launch needs, before it takes off, and shows how far it is.

usage: python -m flights_ros.launch.machine_code [--first-flight] [--every SECONDS]

Without --first-flight it compiles all kernels. numba keeps the machine code, so each kernel is compiled once.
Exit code 1: it failed, and the output says why. An interrupted call goes on from there at the next one.
"""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import json
import os
import subprocess
import sys
import threading
import time
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path
from typing import Iterable, Mapping, Sequence, TextIO

from flights.errors import FlightError
from flights.worlds.scenario import CLOUD_LIDARS

SIMULATOR = "simulation_tools.warm_up:warm_up"
THESIS_CEPA, DYNAMIC_CEPA = "cepa.warm_up:warm_up", "cepa.warm_up:warm_up_dynamic"
SLAM = "gridslam.warm_up:warm_up"
LOOP_CLOSURE = "gridslam.loop_closure.warm_up:warm_up_loop_closure"
ODOMETRY = "gridslam.odometry.warm_up:warm_up_odometry"
CLOUD_ODOMETRY = "gridslam.cloud_odometry.warm_up:warm_up_cloud_odometry"
VOLUME = "gridslam.volume.warm_up:warm_up_volume"
EXPLORATION = "exploration.warm_up:warm_up_exploration"
PATHS = "inspection.warm_up:warm_up"
ALL = (
    SIMULATOR,
    THESIS_CEPA,
    DYNAMIC_CEPA,
    SLAM,
    LOOP_CLOSURE,
    ODOMETRY,
    CLOUD_ODOMETRY,
    VOLUME,
    EXPLORATION,
    PATHS,
)
"""The parts that are compiled one by one: module and function that runs through all kernels of the part."""
FIRST_FLIGHT = (SIMULATOR, DYNAMIC_CEPA)
"""Those of `bringup.sh` without arguments."""
NO = ("false", "0")
PACKAGES = Path(__file__).resolve().parents[5]
"""The workspace's folder of packages."""
GROUPS = ("", "helpers", "extensions")
"""Folders in it that hold packages."""
USED = {"inspection": ("exploration",)}
"""Packages whose kernels those of another package call, or run with them."""
EVERY_S = 10.0
"""Between two lines, where no terminal shows them."""


def needed_by(asked: Mapping[str, str]) -> tuple[str, ...]:
    """Return the parts that a flight needs, by the arguments of its launch file."""
    parts = [SIMULATOR] if "world" in asked or "scenario" in asked else []
    if asked.get("avoidance", "cepa") == "cepa":
        parts.append(DYNAMIC_CEPA if asked.get("algorithm") == "dynamic" else THESIS_CEPA)
    is_planned = asked.get("planner", "false").lower() not in NO
    if is_planned or ("slam_config" in asked and asked.get("slam", "true").lower() not in NO):
        parts += [SLAM, LOOP_CLOSURE]
    if asked.get("gnss", "true").lower() in NO:
        parts.append(CLOUD_ODOMETRY if asked.get("lidar") in CLOUD_LIDARS else ODOMETRY)
    if is_planned or asked.get("volume", "false").lower() not in NO:
        parts.append(VOLUME)
    return tuple(parts)


def compile_missing(parts: Iterable[str], every_s: float = EVERY_S, out: TextIO | None = None) -> None:
    """Compile the parts that are not compiled yet, those of each package in a process of its own.

    Raises:
        FlightError: a part cannot be compiled.
    """
    missing = {part: digest for part in parts if not _is_noted(part, digest := _digest(part))}
    if not missing:
        return
    packages: dict[str, list[str]] = {}
    for part in missing:
        packages.setdefault(_package(part), []).append(part)
    progress = _Progress(len(packages), every_s, out or sys.stderr)
    compilers = [_Compiler(of_one, progress) for of_one in packages.values()]
    try:
        complaints = [compiler.complaint() for compiler in compilers]
    finally:
        for compiler in compilers:
            compiler.stop()
    for complaint in filter(None, complaints):
        raise FlightError(complaint)
    for part, digest in missing.items():
        _note(part, digest)
    progress.end()


class _Progress:
    """Shows how many kernels are compiled: one line that is rewritten, or a line now and then."""

    def __init__(self, processes: int, every_s: float, out: TextIO) -> None:
        self._processes, self._every_s, self._out = processes, every_s, out
        self._lock = threading.Lock()
        self._counts: dict[int, tuple[int, int]] = {}
        self._shown_s = time.monotonic() - every_s
        self._is_needed = False  # numba may have kept all of it

    def tell(self, process: int, ready: int, total: int) -> None:
        """Note the count of a process, and show all."""
        with self._lock:
            self._counts[process] = ready, total
            self._is_needed |= 0 < ready < total
            now_s = time.monotonic()
            if len(self._counts) < self._processes:
                return  # the total is not known yet
            if self._out.isatty():
                self._out.write(f"\r\033[K  {self._words()}")
            elif self._is_needed and now_s >= self._shown_s + self._every_s:
                self._shown_s = now_s
                self._out.write(f"{self._words()}\n")
            self._out.flush()

    def end(self) -> None:
        """Say that all are ready, if numba had anything to compile."""
        if self._out.isatty():
            self._out.write("\r\033[K")
        if self._is_needed:
            print(f"compiling the inner loops: all {self._sums()[1]} are ready", file=self._out, flush=True)

    def _words(self) -> str:
        ready, total = self._sums()
        return f"compiling the inner loops, before their first flight only: {ready} of {total}"

    def _sums(self) -> tuple[int, int]:
        ready, total = zip(*self._counts.values())
        return sum(ready), sum(total)


class _Compiler:
    """A process that compiles parts of one package, and tells its progress in lines of JSON."""

    def __init__(self, parts: Sequence[str], progress: _Progress) -> None:
        self._parts = parts
        command = [sys.executable, "-m", "flights_ros.launch.compile_parts", *parts]
        self._child = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self._said: list[str] = []
        self._readers = [
            threading.Thread(target=self._read_counts, args=(progress,), daemon=True),
            threading.Thread(target=self._read_words, daemon=True),
        ]
        for reader in self._readers:
            reader.start()

    def complaint(self) -> str:
        """Wait for the end; return what went wrong, or nothing."""
        code = self._child.wait()
        for reader in self._readers:
            reader.join()
        if code == 0:
            return ""
        last = self._said[-1].strip() if self._said else f"code {code}"
        return (
            f"The inner loops of {_package(self._parts[0])} could not be compiled: {last}. "
            f"`{sys.executable} -m {self._parts[0].partition(':')[0]}` shows all of it."
        )

    def stop(self) -> None:
        """End the process, if it still runs.

        It is killed: it inherits what its parent blocks or ignores, and a node blocks SIGTERM. numba writes
        its machine code aside, so nothing is left half.
        """
        self._child.kill()
        self._child.wait()

    def _read_counts(self, progress: _Progress) -> None:
        assert self._child.stdout is not None
        for line in self._child.stdout:
            progress.tell(self._child.pid, *json.loads(line))

    def _read_words(self) -> None:
        assert self._child.stderr is not None
        self._said.extend(line for line in self._child.stderr if line.strip())


# What is compiled already is noted in .venv, because asking numba would take a second at each launch. The
# digest is that of the sources before they were compiled.


def _is_noted(part: str, digest: str) -> bool:
    with contextlib.suppress(OSError):
        return _mark(part).read_text(encoding="ascii") == digest
    return False


def _note(part: str, digest: str) -> None:
    if sys.prefix == sys.base_prefix:
        return  # the system's Python
    mark = _mark(part)
    with contextlib.suppress(OSError):  # somebody else's environment; then the next launch asks numba again
        mark.parent.mkdir(exist_ok=True)
        new = mark.with_name(f"{mark.name}.{os.getpid()}")
        new.write_text(digest, encoding="ascii")
        new.replace(mark)


def _mark(part: str) -> Path:
    return Path(sys.prefix) / ".kernels" / part.replace(":", ".")


def _digest(part: str) -> str:
    """Return a digest of all that decides whether numba still uses the machine code that it kept."""
    digest = hashlib.sha256()
    for known in (sys.version, metadata.version("numba"), os.environ.get("NUMBA_CACHE_DIR", "")):
        digest.update(known.encode() + b"\0")
    for package in (_package(part), *USED.get(_package(part), ()), "kernel_cache"):
        folder = _folder(package)
        digest.update(str(folder).encode() + b"\0")
        for path in sorted(folder.rglob("*.py")):
            digest.update(path.name.encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()


def _folder(package: str) -> Path:
    """Return the folder of a package's sources; catkin's devel space holds an `__init__.py` alone."""
    for group in GROUPS:
        beside = PACKAGES / group / package / "src" / package
        if beside.is_dir():
            return beside
    spec = find_spec(package)
    if spec is None or spec.origin is None:
        raise FlightError(f"Python finds no package {package}; call `source devel/setup.bash`.")
    return Path(spec.origin).parent


def _package(part: str) -> str:
    return part.partition(".")[0]


def main(words: Sequence[str]) -> int:
    """Compile; return an exit code."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--first-flight", action="store_true", help="only what bringup.sh alone flies")
    parser.add_argument("--every", type=float, default=EVERY_S, metavar="SECONDS", help="between two lines")
    given = parser.parse_args(words)
    try:
        compile_missing(FIRST_FLIGHT if given.first_flight else ALL, given.every, sys.stdout)
    except FlightError as error:
        print(error, file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("Interrupted. The next call goes on from here.", file=sys.stderr)
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
