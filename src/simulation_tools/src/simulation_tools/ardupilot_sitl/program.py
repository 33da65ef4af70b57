"""Starts ArduPilot's program in a working folder of its own, and ends it."""

from __future__ import annotations

import contextlib
import ctypes
import mmap
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Mapping

from simulation_tools.autopilot import AutopilotError
from simulation_tools.geodesy import GeodeticOrigin

ENVIRONMENT = "ARDUPILOT_COPTER"
"""Environment variable with the place of the program."""
NAME = "arducopter"
FRAME_RATE_HZ = 1000
ELF, SCRIPT = b"\x7fELF", b"#!"
"""How a compiled program begins on Linux, and a script."""
OPTION = b"sim-port-out"
"""Each SITL program of ArduPilot knows it, so it stands in the program's text; see `Program.command`."""
LONGEST_LINE_B = 256
"""Linux reads no more of a script's first line."""
_LOG = "ardupilot.log"
_DIE_WITH_PARENT = 1  # PR_SET_PDEATHSIG

RATES_HZ: Mapping[int, float] = {
    1: 2.0,  # SYS_STATUS
    2: 1.0,  # SYSTEM_TIME
    24: 5.0,  # GPS_RAW_INT
    27: 50.0,  # RAW_IMU
    29: 10.0,  # SCALED_PRESSURE
    30: 50.0,  # ATTITUDE
    31: 50.0,  # ATTITUDE_QUATERNION
    32: 50.0,  # LOCAL_POSITION_NED
    33: 10.0,  # GLOBAL_POSITION_INT
    36: 10.0,  # SERVO_OUTPUT_RAW
    74: 10.0,  # VFR_HUD
    147: 1.0,  # BATTERY_STATUS
    193: 2.0,  # EKF_STATUS_REPORT
    242: 0.5,  # HOME_POSITION
    245: 5.0,  # EXTENDED_SYS_STATE
}
"""What it sends to MAVROS, by message id. Without a list it sends heartbeats only."""
CHANNELS = (1, 2)
"""MAVLink channels of MAVROS and the ground station. Channel 0 is the console's."""


@dataclass(frozen=True)
class ProgramParameters:
    """How ArduPilot is started.

    path: of `arducopter`, a program built for the board `sitl`. defaults: files of parameters, the later ones
    count more. settings: further parameters by name. origin: where the world's origin lies on earth.
    simulator_port: of the `JsonLink`. offboard_port, gcs_port: to which it sends MAVLink, to MAVROS and to a
    ground station. Raises AutopilotError if the program or a file is not there.
    """

    path: str
    defaults: tuple[str, ...] = ()
    settings: Mapping[str, float] = field(default_factory=dict)
    origin: GeodeticOrigin = field(default_factory=GeodeticOrigin)
    offboard_port: int = 14540
    gcs_port: int = 14550
    system_id: int = 1

    def __post_init__(self) -> None:
        check_program(self.path)
        for name in self.defaults:
            check_parameter_file(name)


def check_parameter_file(path: str) -> None:
    """Raise AutopilotError, one sentence, if a file of ArduPilot's parameters is not at a path."""
    if not Path(path).is_file():
        raise AutopilotError(f"ArduPilot's file of parameters {path} is not there.")


def check_program(path: str) -> None:
    """Raise AutopilotError, one sentence, if ArduPilot's program is not at a path."""
    how = "simulation_tools/doc/ardupilot.md tells how to get it"
    if not path.strip():
        raise AutopilotError(
            "autopilot:=ardupilot needs the place of ArduPilot's program: give "
            f"ardupilot:=/path/to/arducopter, or set {ENVIRONMENT}; {how}."
        )
    if Path(path).is_dir():
        raise AutopilotError(f"{path} is a folder; give the program, for example {Path(path, NAME)}; {how}.")
    if not Path(path).is_file():
        raise AutopilotError(f"ArduPilot's program {path} is not there; {how}.")
    if not os.access(path, os.X_OK):
        raise AutopilotError(f"ArduPilot's program {path} cannot be executed; {how}.")
    why = _why_not_sitl(Path(path))
    if why:
        raise AutopilotError(f"{path} is not {NAME}, built for the board sitl: {why}; {how}.")


def _why_not_sitl(program: Path) -> str:
    """Return why a program cannot be ArduPilot's SITL, in words; empty: it may be.

    A script may start ArduPilot, so it is refused only if it cannot run at all. Some files may be executed
    but not read; these pass.
    """
    try:
        with program.open("rb") as file:
            begin = file.read(LONGEST_LINE_B)
            if begin.startswith(ELF):
                with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content:
                    knows_it = content.find(OPTION) >= 0
                return "" if knows_it else f"it does not know the option --{OPTION.decode()}"
    except OSError:
        return ""
    if not begin.startswith(SCRIPT):
        return "it is neither a program nor a script" if begin else "it is empty"
    interpreter = begin.removeprefix(SCRIPT).split(b"\n")[0].split()[:1]
    if not interpreter or not Path(os.fsdecode(interpreter[0])).is_file():
        return "its first line names a program that is not there"
    return ""


class Program:
    """One ArduPilot at a time. It keeps its parameters in its folder, so each start gets a new one."""

    def __init__(self, parameters: ProgramParameters, simulator_port: int) -> None:
        self._parameters = parameters
        self._simulator_port = simulator_port
        self._process: subprocess.Popen | None = None
        self._folder: Path | None = None
        self.started_s = 0.0  # wall time

    @property
    def runs(self) -> bool:
        """Whether it runs."""
        return self._process is not None and self._process.poll() is None

    @property
    def exit_status(self) -> int | None:
        """Its exit status; None while it runs."""
        return None if self._process is None else self._process.poll()

    def start(self) -> None:
        """End what runs, and start anew; raises AutopilotError."""
        self.stop()
        folder = self._folder = Path(tempfile.mkdtemp(prefix="ardupilot_"))
        own = folder / "own.parm"
        own.write_text("".join(f"{name} {value:.9g}\n" for name, value in self._parameters.settings.items()))
        intervals = "".join(f"{number} {round(1e3 / rate)}\n" for number, rate in RATES_HZ.items())
        for channel in CHANNELS:
            (folder / f"message-intervals-chan{channel}.txt").write_text(intervals)
        self.started_s = time.monotonic()
        with (folder / _LOG).open("wb") as log:
            self._process = self._spawn(own, folder, log)

    def _spawn(self, own: Path, folder: Path, log: IO[bytes]) -> subprocess.Popen:
        try:
            return subprocess.Popen(
                self.command(own),
                cwd=folder,
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
                start_new_session=True,
                preexec_fn=_die_with_parent,
            )
        except OSError as error:
            raise AutopilotError(
                f"ArduPilot's program {self._parameters.path} does not start: {error}."
            ) from None

    def command(self, own: Path) -> list[str]:
        """Return its command line. own: the file with `settings`."""
        p = self._parameters
        files = (*(str(Path(name).resolve()) for name in p.defaults), str(own))
        place = p.origin
        return [
            str(Path(p.path).resolve()),
            "--model=JSON",
            "--speedup=1",
            f"--rate={FRAME_RATE_HZ}",
            f"--home={place.latitude_deg:.8f},{place.longitude_deg:.8f},{place.altitude_m:.3f},0",
            f"--defaults={','.join(files)}",
            f"--sim-port-out={self._simulator_port}",
            "--rc-in-port=0",
            f"--sysid={p.system_id}",
            "--serial0=none:",  # the console, whose text is no MAVLink
            f"--serial1=udpclient:127.0.0.1:{p.offboard_port}",
            f"--serial2=udpclient:127.0.0.1:{p.gcs_port}",
        ]

    def last_words(self, lines: int = 3) -> str:
        """Return the end of what it said, in one line."""
        return " / ".join(self._said()[-lines:])

    def unknown_parameters(self) -> list[str]:
        """Return the parameters of our files that this version does not know."""
        marks = [line.split() for line in self._said() if "unknown param" in line.lower()]
        return [word for words in marks for word in words if word.isupper() and "_" in word]

    def _said(self) -> list[str]:
        if self._folder is None:
            return []
        try:
            text = (self._folder / _LOG).read_text(encoding="utf-8", errors="replace")
        except OSError:
            return []
        return [line.strip() for line in text.splitlines() if line.strip()]

    def stop(self) -> None:
        """End it, with all that it has started, and remove its folder.

        ArduPilot obeys SIGTERM only at its next frame of physics, which does not come any more. Its files go
        with the folder, so nothing is lost if it is killed.
        """
        if self._process is not None and self._process.poll() is None:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(self._process.pid, signal.SIGKILL)  # it leads a session of its own
            self._process.wait()
        self._process = None
        if self._folder is not None:
            shutil.rmtree(self._folder, ignore_errors=True)
            self._folder = None


def _die_with_parent() -> None:
    """End this process when the one that started it ends. ArduPilot waits for its physics for ever."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_DIE_WITH_PARENT, signal.SIGKILL)
