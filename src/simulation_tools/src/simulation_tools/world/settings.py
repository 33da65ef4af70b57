"""The settings of a world's physics: gravity, time step, and how contacts are solved."""

from __future__ import annotations

import math
from dataclasses import dataclass

from flight_basics.checks import check_limits, limited
from simulation_tools.geometry import Vector3
from simulation_tools.world.engine import WorldError, pybullet


@dataclass(frozen=True)
class ContactSolver:
    """How contacts and joints are solved; the defaults are PyBullet's.

    Raises:
        WorldError: a value makes no sense.
    """

    iterations: int = limited(50, 1, live=(1, 500))
    """Rounds of the solver in each step (Gazebo's sor_pgs_iters). More hold high stacks."""
    residual_m_s: float = limited(1e-7, 0.0, live=(0.0, 1.0))
    """Error of a round, m/s, below which the solver stops early (sor_pgs_rms_error_tol)."""
    cfm: float = limited(0.0, 0.0, live=(0.0, 0.01))
    """Constraint force mixing: softness of contacts. 0 is hard."""
    erp: float = limited(0.08, 0.0, live=(0.0, 0.8))
    """Error reduction: how fast bodies that overlap are pushed apart. 0 leaves them as they are."""
    surface_layer_m: float = limited(1e-5, 0.0, live=(0.0, 0.05))
    """Depth to which bodies at rest sink into each other, m (contact_surface_layer)."""

    def __post_init__(self) -> None:
        check_limits(self, WorldError, "The solver's {}")


class PhysicsSettings:
    """The settings of one PyBullet client.

    A change between two steps counts from the next step on. A bad value raises WorldError and changes
    nothing.
    """

    def __init__(self, client: int, gravity_m_s2: Vector3, time_step_s: float):
        self._client = client
        self._solver = ContactSolver()
        self.gravity_m_s2 = gravity_m_s2
        self.time_step_s = time_step_s

    def apply(self) -> None:
        """Send all settings to PyBullet. This is necessary after its reset."""
        self.gravity_m_s2, self.time_step_s = self._gravity_m_s2, self._time_step_s
        self.solver = self._solver

    @property
    def gravity_m_s2(self) -> Vector3:
        """Acceleration of gravity, world frame."""
        return self._gravity_m_s2

    @gravity_m_s2.setter
    def gravity_m_s2(self, value: Vector3) -> None:
        if not all(map(math.isfinite, value)):
            raise WorldError(f"Gravity must be finite, not {value}.")
        x, y, z = map(float, value)
        self._gravity_m_s2 = x, y, z
        pybullet.setGravity(x, y, z, physicsClientId=self._client)

    @property
    def time_step_s(self) -> float:
        """Length of a step."""
        return self._time_step_s

    @time_step_s.setter
    def time_step_s(self, value: float) -> None:
        if not 0.0 < value <= 0.1:
            raise WorldError(f"The time step must be positive and at most 0.1 s, not {value:g} s.")
        self._time_step_s, self.time_step_us = value, round(1e6 * value)
        pybullet.setTimeStep(value, physicsClientId=self._client)

    @property
    def solver(self) -> ContactSolver:
        """How contacts are solved."""
        return self._solver

    @solver.setter
    def solver(self, value: ContactSolver) -> None:
        self._solver = value
        pybullet.setPhysicsEngineParameter(
            numSolverIterations=value.iterations,
            solverResidualThreshold=value.residual_m_s,
            globalCFM=value.cfm,
            contactERP=value.erp,
            contactSlop=value.surface_layer_m,
            physicsClientId=self._client,
        )
