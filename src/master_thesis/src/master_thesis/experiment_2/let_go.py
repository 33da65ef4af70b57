"""Experiment 2 without ROS: the closed loop hovers, obstacles appear, and the UAV is let go.

Before this, position setpoints hold the UAV. Afterwards CEPA's velocities steer it.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Sequence

import numpy as np

from cepa import CepaParameters
from flights.flight.closed_loop import ClosedLoop
from flights.flight.parameters import CEPA, ClosedLoopParameters
from flights.worlds.placements import R_LB_M, Obstacle, freeze_frame, placement, varied
from master_thesis.experiment_2.trial import EmergencyTrial, TrialAction, TrialParameters
from simulation_tools.publisher import PublisherParameters
from simulation_tools.simulation import SimulationParameters


@dataclass(frozen=True)
class LetGoParameters:
    """The parameters of a trial.

    variation: 0 is the placement itself; any other number shifts each obstacle a little.

    world: SDF file, with room around the origin. seed: of all sensor noise.
    """

    world: str
    scenario: str
    algorithm: str = "improved"
    variation: int = 0
    seed: int = 1
    lidar: str = "ust"
    cepa: CepaParameters = field(default_factory=lambda: replace(CEPA, r_lb=R_LB_M))
    trial: TrialParameters = field(default_factory=TrialParameters)

    @property
    def obstacles(self) -> tuple[Obstacle, ...]:
        """The obstacles that will appear; raises ScenarioError for an unknown scenario."""
        nominal = placement(self.scenario)
        return varied(nominal, np.random.default_rng(self.variation)) if self.variation else nominal


def let_go(parameters: LetGoParameters) -> EmergencyTrial:
    """Fly one run; the log begins with the take-off."""
    simulated = SimulationParameters(parameters.world, lidar=parameters.lidar, seed=parameters.seed)
    flown = ClosedLoopParameters(
        simulated,
        goal_xyz_m=None,
        algorithm=parameters.algorithm,
        cepa=parameters.cepa,
        publisher=PublisherParameters(use_position_setpoint=True),
    )
    obstacles = parameters.obstacles
    with ClosedLoop(flown) as loop:
        trial = EmergencyTrial(parameters.trial, loop.simulation.uav_name)
        while not trial.finished:
            for action in _step(loop, trial):
                if action is TrialAction.FREEZE:
                    _place(loop, trial, obstacles)
        _take_over_log(loop, trial)
    return trial


def _step(loop: ClosedLoop, trial: EmergencyTrial) -> list[TrialAction]:
    output = loop.step()
    t_s, actions = 1e-6 * output.time_us, []
    trial.on_ready(loop.publisher.ready)
    if output.scan is not None and loop.newest_scan is not None:
        actions += trial.on_scan(t_s, loop.newest_scan)
    for contact in output.contacts:
        trial.on_contact(t_s, contact.collision_1, contact.collision_2)
    if output.ground_truth is not None:
        actions += trial.on_truth(t_s, output.ground_truth.pose)
    return actions


def _place(loop: ClosedLoop, trial: EmergencyTrial, obstacles: Sequence[Obstacle]) -> None:
    world = loop.simulation.world
    uav = world.get_state(loop.simulation.uav_name).pose
    frame = freeze_frame(uav)
    for obstacle in obstacles:
        world.spawn(obstacle.model(), obstacle.name, obstacle.pose(frame))
    loop.publisher.use_position_setpoints(False)
    trial.on_placed(loop.time_s, uav, obstacles)


def _take_over_log(loop: ClosedLoop, trial: EmergencyTrial) -> None:
    for name in ("odometry", "v_ref", "v_safe", "v_final", "decisions"):
        setattr(trial.log, name, getattr(loop.log, name))
