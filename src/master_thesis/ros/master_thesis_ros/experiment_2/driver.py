"""The node `experiment_2`: hover, stop time, place obstacles, let go, watch, write (thesis, 8.1)."""

from __future__ import annotations

import time
from dataclasses import replace
from enum import Enum
from typing import Iterable, Sequence

import rospy
from cepa_ros.conversions import scan_of
from cepa_ros.parameters import Choice, choice_of, config_of
from nav_msgs.msg import Odometry
from rospy.numpy_msg import numpy_msg
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Bool, Header

from cepa import CepaError, CepaParameters
from flights.errors import FlightError
from flights.flight.judging.contacts import UavParts
from flights.worlds.placements import Obstacle, placement
from flights_ros.drivers.experiment_node import SETTLE_S, ExperimentNode
from flights_ros.drivers.messages import stamp_s
from flights_ros.drivers.parameters import all_parameters
from flights_ros.drivers.run import Run
from flights_ros.drivers.simulator_services import SimulatorServices, pose_of
from master_thesis.experiment_2.request import Trial, read
from master_thesis.experiment_2.summary import headline
from master_thesis.experiment_2.trial import EmergencyTrial, TrialAction
from master_thesis.experiment_2.trial_files import complete_trial, write_numbers
from node_tools.ending import Ending
from node_tools.node import RunNode

LET_GO_S = 0.3
"""Wall time after which, in lockstep, mavros_publisher has taken the order."""


class Experiment2Node(ExperimentNode):
    """Freezes the flight, places obstacles around the UAV, and lets it go.

    Subscribes to every `ExperimentNode`'s topics; scan: CEPA's input, filtered and padded.
    Publishes: use_pos_setpoint (std_msgs/Bool, latched): false when the UAV is let go.
    Calls: the services of `SimulatorServices`.
    Parameters: see doc/reference.md.

    In lockstep it acknowledges the scan of the stop of time after it has placed everything.
    """

    scan_class = numpy_msg(LaserScan)

    def __init__(
        self, trial: EmergencyTrial, obstacles: Sequence[Obstacle], uav: str, look_s: float, lockstep: bool
    ) -> None:
        self._trial, self._obstacles, self._uav, self._look_s = trial, obstacles, uav, look_s
        self._ready = False
        self._frozen_at: Header | None = None
        self._use_positions = rospy.Publisher("use_pos_setpoint", Bool, queue_size=1, latch=True)
        self._simulator = SimulatorServices()
        super().__init__(trial, lockstep)

    def _carry_out(self, action: Enum) -> None:
        try:
            self._freeze() if action is TrialAction.FREEZE else self._look()
        except (rospy.ServiceException, rospy.ROSException, FlightError) as error:
            with self._lock:
                self._take(self._trial.abort(f"A service of the simulator failed: {error}"))

    def _freeze(self) -> None:
        """Stop time, place the obstacles around the UAV, and let it go."""
        self._simulator.pause()
        frozen_s, uav = self._simulator.place(self._uav, self._obstacles)
        with self._lock:
            self._trial.on_placed(frozen_s, uav, self._obstacles)
        self._use_positions.publish(False)
        rospy.loginfo(f"{len(self._obstacles)} obstacles stand around the UAV; it is let go.")
        if self._lockstep:
            time.sleep(LET_GO_S)
        self._simulator.unpause()
        if self._frozen_at is not None:
            self._acknowledge(self._frozen_at)

    def _look(self) -> None:
        """Stop time again, so that the user can look at CEPA's proposals."""
        if self._look_s > 0.0:
            self._simulator.pause()
            time.sleep(self._look_s)  # wall time, because simulated time stands still
            self._simulator.unpause()

    def _hears_everybody(self) -> bool:
        log = self._trial.log
        return super()._hears_everybody() and len(log.truth) > 0 and len(log.v_safe) > 0

    def _decide_at(self, header: Header) -> bool:
        time.sleep(SETTLE_S)
        with self._lock:
            self._trial.on_ready(self._ready)
            actions = self._trial.decide()
            freezes = TrialAction.FREEZE in actions
            if freezes:
                self._frozen_at = header
            self._take(actions)
        return not freezes

    def _on_ready(self, message: Bool) -> None:
        self._ready = message.data
        if not self._lockstep:
            self._trial.on_ready(message.data)

    def _on_ground_truth(self, message: Odometry) -> Iterable[Enum]:
        return self._trial.on_truth(stamp_s(message), pose_of(message.pose.pose), decide=not self._lockstep)

    def _on_scan(self, message: LaserScan) -> Iterable[Enum]:
        if self._trial.freeze is None or self._trial.first_scan is not None:
            return ()
        try:
            return self._trial.on_scan(stamp_s(message), scan_of(message))
        except CepaError as error:
            raise ValueError(str(error)) from None


def make() -> RunNode:
    """Read and check the request. Return the function that flies it and writes the results."""
    asked, everything = rospy.get_param("~", {}), all_parameters()
    try:
        cepa = choice_of({**config_of(Choice("improved", CepaParameters())), **everything.get("cepa", {})})
    except CepaError as error:
        raise FlightError(str(error)) from None
    trial = read(asked, cepa.parameters)
    trial = replace(trial, description=replace(trial.description, parameters=everything))
    lockstep = asked.get("lockstep", False) is True
    return lambda ending: _fly(trial, lockstep, ending)


def _fly(asked: Trial, lockstep: bool, ending: Ending) -> int:
    """Return the exit code."""
    description = asked.description
    obstacles = placement(description.scenario)
    run = Run(description.experiment, ending)
    uav = UavParts.load(description.model).model
    trial = EmergencyTrial(asked.limits, uav)
    run.lead(trial, lambda: Experiment2Node(trial, obstacles, uav, asked.look_s, lockstep))
    run.complete_bag()
    numbers = write_numbers(run.folder, description, trial)
    return run.finish(
        numbers, headline, lambda _: complete_trial(run.folder, description, trial), "clearance or pictures"
    )
