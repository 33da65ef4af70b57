"""dynamic_reconfigure of the node `gazebo`: pace, gravity, wind and contacts while it flies."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Callable

import rospy

from node_tools.tuning_server import TuningServer
from simulation_tools.cfg import PhysicsConfig
from simulation_tools.errors import SimulationToolsError
from simulation_tools.running.run_loop import RunLoop
from simulation_tools.simulation import Simulation
from simulation_tools.world.settings import ContactSolver

FACTOR, RATE = 1, 2  # levels of Physics.cfg


class PhysicsTuning:
    """Keeps the simulation and its values in rqt_reconfigure equal. pause: stops simulated time.

    At the start the simulation's own gravity, wind and contacts replace those on the parameter server, which
    may be from an earlier world.
    """

    def __init__(self, simulation: Simulation, loop: RunLoop, pause: Callable[[bool], None]):
        self._simulation = simulation
        self._loop = loop
        self._pause = pause
        for name, value in self._in_force().items():
            rospy.set_param(f"~{name}", value)
        self._server = TuningServer(PhysicsConfig, self._on_change)

    def show_pause(self, paused: bool) -> None:
        """Show in the configuration that a service has paused or resumed the simulation."""
        self._server.update_configuration({"pause": paused})

    def _in_force(self) -> dict[str, float]:
        """Return the present settings of the world's physics by the parameters' names."""
        settings = self._simulation.world.settings
        solver = settings.solver
        by_axis = zip("xyz", settings.gravity_m_s2, self._simulation.wind_m_s)
        vectors = {
            f"{what}_{axis}": float(value)
            for axis, gravity, wind in by_axis
            for what, value in (("gravity", gravity), ("wind", wind))
        }
        return {
            **vectors,
            "sor_pgs_iters": solver.iterations,
            "sor_pgs_rms_error_tol": solver.residual_m_s,
            "cfm": solver.cfm,
            "erp": solver.erp,
            "contact_surface_layer": solver.surface_layer_m,
        }

    def _on_change(self, config: Any, level: int) -> Any:
        try:
            self._loop.call(lambda: self._apply(config, level))
        except SimulationToolsError as error:
            rospy.logerr(str(error))
        applied_s = self._simulation.time_step_s
        if abs(applied_s - config.time_step) > 1e-9:
            rospy.logwarn(
                f"time_step {config.time_step:g} s is rounded to whole milliseconds: {applied_s:g} s."
            )
        factor = self._loop.pacing.real_time_factor
        config.update(
            self._in_force(), time_step=applied_s, real_time_factor=factor, max_update_rate=factor / applied_s
        )
        return config

    def _apply(self, config: Any, level: int) -> None:
        """Apply a whole configuration, between two steps."""
        simulation = self._simulation
        simulation.set_time_step(round(config.time_step, 3))
        by_rate = level & RATE and not level & FACTOR
        factor = config.max_update_rate * simulation.time_step_s if by_rate else config.real_time_factor
        self._loop.set_pacing(replace(self._loop.pacing, real_time_factor=factor))
        simulation.wind_m_s = (config.wind_x, config.wind_y, config.wind_z)
        settings = simulation.world.settings
        settings.gravity_m_s2 = (config.gravity_x, config.gravity_y, config.gravity_z)
        settings.solver = ContactSolver(
            iterations=config.sor_pgs_iters,
            residual_m_s=config.sor_pgs_rms_error_tol,
            cfm=config.cfm,
            erp=config.erp,
            surface_layer_m=config.contact_surface_layer,
        )
        self._pause(config.pause)
