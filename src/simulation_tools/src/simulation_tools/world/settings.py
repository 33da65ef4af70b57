"""The settings of a world's physics: gravity, time step, and how contacts are solved."""

from __future__ import annotations

import math
from dataclasses import dataclass

from simulation_tools.geometry import Vector3
from simulation_tools.world.engine import WorldError, pybullet


@dataclass(frozen=True)
class ContactSolver:
    """Parameters of the contact solver; the defaults are PyBullet's. Raises WorldError for bad values.

    iterations: rounds in each step (Gazebo's sor_pgs_iters). residual_m_s: error of a round below which the
    solver stops early (sor_pgs_rms_error_tol). cfm: constraint force mixing, 0 is hard. erp: error reduction
    of contacts. surface_layer_m: depth to which bodies at rest sink into each other (contact_surface_layer).
    """

    iterations: int = 50
    residual_m_s: float = 1e-7
    cfm: float = 0.0
    erp: float = 0.08
    surface_layer_m: float = 1e-5

    def __post_init__(self) -> None:
        if self.iterations < 1:
            raise WorldError(f"The solver needs at least 1 iteration, not {self.iterations}.")
        for name in ("residual_m_s", "cfm", "erp", "surface_layer_m"):
            value = getattr(self, name)
            if not 0.0 <= value < math.inf:
                raise WorldError(f"The solver's {name} must be 0 or a positive number, not {value:g}.")


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
