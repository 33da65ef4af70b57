"""One run from its folder to its summary. Ctrl-C ends it in every phase; the data so far is written."""

from __future__ import annotations

import os
import threading
import time
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import Any, Callable

import rospy

from flights.errors import FlightsError, ResultsError
from flights.flight.bag_recorder import BagRecorder
from flights.flight.description import RunDescription
from flights.flight.judging.wall_metrics import WallMetrics
from flights.flight.monitor import Monitor
from flights.graph.processes import age_s
from flights.launch_arguments.results_folder import results_path
from flights.results.run_folder import RunFolder, cannot
from flights_ros.drivers.experiment_node import INTERRUPTED, ExperimentNode, WatchedRun
from flights_ros.drivers.parameters import all_parameters
from flights_ros.drivers.simulator_services import slow_down
from flights_ros.launch.end import end_launch
from node_tools.ending import Ending, leave
from node_tools.node import RunNode, run
from node_tools.parameters import read_values
from simulation_tools.errors import SimulationToolsError

LOOK_S = 0.05
"""Wall time between two checks whether the run is over."""
WRITING_S = 0.3
"""Wall time to finish writing a file after Ctrl-C."""
NAMED_IN = "RESULTS_NAMED_IN"
"""Environment variable: the file into which a caller of roslaunch wants the folder's path. It prints the
summary itself.
"""


def drive(make: Callable[[], RunNode], ending: Ending) -> None:
    """Run an experiment's node.

    An error of the libraries gives one sentence and exit code 1. Does not return.
    """
    run("experiment", make, ending, (FlightsError, SimulationToolsError), explain=str)


class Run:
    """One run's folder, its recorder, and the wall time since roslaunch was called."""

    def __init__(self, experiment: str, ending: Ending) -> None:
        """Make the experiment's folder and start recording. From now on this object handles Ctrl-C.

        Raises:
            FlightsError: the folder cannot be made.
        """
        ending.main_thread_closes(within_s=None)
        self._ending = ending
        self._started_s = time.perf_counter() - age_s(os.getppid())
        given = read_values({"results": os.path.abspath("results"), "record": False})
        root = results_path(given["results"])
        self.folder = RunFolder(root, experiment, datetime.now())
        rospy.loginfo(f"The results will be in {self.folder.path}.")
        if NAMED_IN in os.environ:
            _write_name(Path(os.environ[NAMED_IN]), self.folder.path)
        self._recorder = BagRecorder(self.folder.path / "flight.bag") if given["record"] else None
        shortage = self._recorder.shortage() if self._recorder else None
        if shortage:
            rospy.logwarn(shortage)
        self._parameters = all_parameters()
        self.interrupted = False

    def lead(self, watched: WatchedRun, make_node: Callable[[], ExperimentNode]) -> None:
        """Fly to the end, or to an interruption.

        The node runs in a separate thread, so that the run can end while the node still waits.

        Raises:
            the errors of `make_node` and of the node's `run`.
        """
        flight = _Flight(make_node)
        flight.start()
        while flight.is_alive() and not self._ending.wait(LOOK_S):
            pass
        self.interrupted = self._ending.received or rospy.is_shutdown()
        if flight.node:
            flight.node.close()
        else:
            watched.abort(INTERRUPTED)
        if flight.error and not self.interrupted:
            raise flight.error

    def close(self, description: RunDescription, monitor: Monitor) -> tuple[RunDescription, WallMetrics]:
        """Complete the bag. Return the description with all parameters, and the metrics of wall time."""
        wall = monitor.wall_metrics(self._started_s)
        self.complete_bag()
        parameters = self._parameters if self.interrupted else all_parameters()
        return replace(description, parameters=parameters), wall

    def complete_bag(self) -> None:
        """Stop recording, if there is a recorder. A bag that is not whole is missing in the results."""
        problem = self._recorder.close() if self._recorder else None
        if problem:
            rospy.logerr(problem)
            self.folder.lacks(problem)

    def finish(
        self,
        content: dict,
        headline: Callable[[dict], str],
        complete: Callable[[dict], dict],
        what: str,
        tell_how: Callable[[], None] = lambda: None,
    ) -> int:
        """Add the slow part of the results, print the headline, and end the launch if the run succeeded.

        Args:
            content: the present content of result.json.
            headline: turns the content into a few lines for a terminal.
            complete: writes the rest and returns the whole content of result.json.
            what: the missing parts after Ctrl-C, in words.
            tell_how: tells after Ctrl-C how to get them.

        Returns:
            the exit code.
        """

        def leave_it_out() -> int:
            rospy.logwarn(f"Interrupted: the results are without {what}.")
            tell_how()
            try:
                told = self.folder.seal(WRITING_S, what)
            except ResultsError as error:
                rospy.logfatal("%s", error)
                return 1
            self._tell(headline(told))
            return _exit_code(told)

        if not self.interrupted:
            self._ending.closes_by(lambda: leave(leave_it_out()), 1)
            if self._ending.received:
                return leave_it_out()
            slow_down()
            content = self._completed(complete, content)
            self._ending.main_thread_closes(within_s=None)
        content = self.folder.write_result(content, is_whole=True)
        self._tell(headline(content))
        if content["success"]:
            end_launch(self._ending)
        return _exit_code(content)

    def _completed(self, complete: Callable[[dict], dict], content: dict) -> dict:
        """Return the whole content of result.json; raises ResultsError if a file cannot be written."""
        try:
            return complete(content)
        except OSError as error:
            raise ResultsError(cannot(f"complete the results in {self.folder.path}", error)) from error

    def _tell(self, headline: str) -> None:
        """Print the results' folder and the headline, unless the caller of roslaunch prints them."""
        if NAMED_IN not in os.environ:
            print(f"\n{self.folder.path / 'result.json'}\n{headline}\n", flush=True)


def _write_name(file: Path, folder: Path) -> None:
    """Tell the caller of roslaunch the run's folder; raises ResultsError."""
    try:
        file.write_text(f"{folder}\n", encoding="utf-8")
    except OSError as error:
        raise ResultsError(f"Cannot write {file}: {error.strerror}; free some space there.") from error


def _exit_code(content: dict[str, Any]) -> int:
    return 0 if content["success"] else 1


class _Flight(threading.Thread):
    """Makes a node and lets it run."""

    def __init__(self, make_node: Callable[[], ExperimentNode]) -> None:
        super().__init__(name="flight", daemon=True)
        self._make_node = make_node
        self.node: ExperimentNode | None = None
        self.error: Exception | None = None

    def run(self) -> None:
        """Fly to the end."""
        try:
            self.node = self._make_node()
            self.node.run()
        except Exception as error:  # the main thread raises it
            self.error = error
