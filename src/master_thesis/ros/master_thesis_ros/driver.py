"""How an experiment's driver runs; Ctrl-C ends it at once in every phase, and what was flown is reported."""

from __future__ import annotations

import contextlib
import logging
import os
import signal
import sys
import time
from contextlib import contextmanager
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import Callable, Protocol

import rospy

from master_thesis.errors import MasterThesisError
from master_thesis.flight.bag_recorder import BagRecorder
from master_thesis.flight.description import RunDescription
from master_thesis.flight.monitor import Monitor
from master_thesis.flight.wall_metrics import WallMetrics
from master_thesis.results import run_folder as results
from master_thesis.worlds import scenario
from master_thesis_ros.flight_node import INTERRUPTED
from master_thesis_ros.parameters import all_parameters, text
from simulation_tools.errors import SimulationToolsError
from simulation_tools_ros.launch_check import command_line

INSISTS_S = 0.5
LAUNCH_ENDS_S = 10.0


def run(name: str, fly: Callable[[], int]) -> None:
    """Run a driver as a node of this name, and end the process with what `fly` returns.

    Call it in the main thread. Errors of the libraries are one sentence and exit code 1.
    """
    code = _guarded(name, fly)
    _on_signals(lambda number, frame: os._exit(code))
    sys.stdout.flush()
    if code == 0:
        end_launch()
    rospy.signal_shutdown("the run is over")
    logging.shutdown()
    os._exit(code)  # rospy's threads may hang the interpreter's own end, and half a second is saved


def _guarded(name: str, fly: Callable[[], int]) -> int:
    try:
        _on_signals(_interrupt)
        rospy.init_node(name, disable_signals=True)
        return fly()
    except (MasterThesisError, SimulationToolsError) as error:
        rospy.logfatal(str(error))
        return 1
    except KeyboardInterrupt:  # before there was anything to report
        return 130


def end_launch() -> None:
    """Have the roslaunch that started this node end as by Ctrl-C, which ends this node; else return.

    When a required node ends by itself, roslaunch calls that a death, in red, however well the run went.
    """
    parent = os.getppid()
    words = command_line(parent)
    if not any(Path(word).name == "roslaunch" for word in words[:2]) or "-c" in words:
        return
    with contextlib.suppress(ProcessLookupError):
        os.kill(parent, signal.SIGINT)
        time.sleep(LAUNCH_ENDS_S)


class Described(Protocol):
    """What is to be flown."""

    experiment: str
    """Name of the results' folder."""


class Course(Protocol):
    """The state of a run."""

    def abort(self, why: str):
        """End the run at once, unless it is over; `why` is a sentence."""


class Leader(Protocol):
    """Leads a run by ROS messages."""

    def run(self) -> None:
        """Carry out what the run asks for until it is over or ROS shuts down; SIGINT raises in here."""

    def close(self) -> None:
        """End the run if it is not over, and hear no more."""


class Run:
    """One run's folder, its recorder, and the wall time since roslaunch was called."""

    def __init__(self, description: Described) -> None:
        self._started_s = time.perf_counter() - results.process_age_s(os.getppid())
        self._description = description
        root = scenario.absolute("results", text("results", os.path.abspath("results")))
        self.folder = results.RunFolder(root, description.experiment, datetime.now())
        rospy.loginfo(f"The results will be in {self.folder.path}.")
        record = rospy.get_param("~record", False)
        self._recorder = BagRecorder(self.folder.path / "flight.bag") if record else None
        shortage = self._recorder.shortage() if self._recorder else None
        if shortage:
            rospy.logwarn(shortage)
        self._parameters = all_parameters()
        self.interrupted = False

    def lead(self, course: Course, make_node: Callable[[], Leader]) -> Leader | None:
        """Fly to the end, or to an interruption; return the node, if there is one by then."""
        node = None
        try:
            node = make_node()
            node.run()
            self.interrupted = rospy.is_shutdown()
        except KeyboardInterrupt:
            self.interrupted = True
        finally:
            _on_signals(signal.SIG_IGN)  # until the numbers are written
            if node:
                node.close()
            else:
                course.abort(INTERRUPTED)
        return node

    def close(self, monitor: Monitor) -> tuple[RunDescription, WallMetrics]:
        """Complete the bag; return what was flown, with all parameters, and the figures of wall time."""
        wall = monitor.wall_metrics(self._started_s)
        self.complete_bag()
        parameters = self._parameters if self.interrupted else all_parameters()
        return replace(self._description, parameters=parameters), wall

    def complete_bag(self) -> None:
        """Stop recording, if there is a recorder."""
        if self._recorder:
            problem = self._recorder.close()
            if problem:
                rospy.logerr(problem)


def tell(folder: results.RunFolder, headline: str) -> None:
    """Print where the results lie and the run's figures, unless whoever launched this does so at the end."""
    if not os.environ.get("SUMMARY_FOLLOWS"):
        print(f"\n{folder.path / 'result.json'}\n{headline}\n", flush=True)


@contextmanager
def interruptible(what_is_missing: str):
    """Let Ctrl-C leave out what takes a few seconds, with a warning."""
    try:
        _on_signals(_interrupt)
        yield
    except KeyboardInterrupt:
        rospy.logwarn(f"Interrupted: the results are without {what_is_missing}.")
    finally:
        _on_signals(signal.SIG_IGN)


def _on_signals(handler) -> None:
    signal.setitimer(signal.ITIMER_REAL, 0.0)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, handler)


def _interrupt(number: int, frame) -> None:
    """Raise KeyboardInterrupt, and again until it is noticed: code that catches everything may swallow it."""
    for further in (signal.SIGINT, signal.SIGTERM):
        signal.signal(further, signal.SIG_IGN)  # once is enough
    signal.signal(signal.SIGALRM, _interrupt)
    signal.setitimer(signal.ITIMER_REAL, INSISTS_S)
    raise KeyboardInterrupt
