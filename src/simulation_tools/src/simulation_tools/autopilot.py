"""The interface of a flight controller: the vehicle's state in, rotor commands out."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from simulation_tools.errors import SimulationToolsError
from simulation_tools.geometry import IDENTITY, ORIGIN, Pose, Vector3
from simulation_tools.vehicle.energy.battery import BatteryReading


class AutopilotError(SimulationToolsError):
    """The flight controller cannot do what it was asked for."""


class Px4Error(AutopilotError):
    """PX4, or its stand-in, cannot do what it was asked for."""


class VehicleState(NamedTuple):
    """The true state of the vehicle at one instant.

    time_us: simulation time. pose: body (FLU, origin at the centre of mass or the model frame) in the world
    (ENU). velocity_world_m_s: ENU. angular_velocity_body_rad_s, specific_force_body_m_s2: FLU; the specific
    force is what an accelerometer feels, (0, 0, +g) at rest. battery: what its monitor tells; None: there is
    no monitor.
    """

    time_us: int
    pose: Pose = IDENTITY
    velocity_world_m_s: Vector3 = ORIGIN
    angular_velocity_body_rad_s: Vector3 = ORIGIN
    specific_force_body_m_s2: Vector3 = (0.0, 0.0, 9.8)
    battery: BatteryReading | None = None


class Autopilot(Protocol):
    """A flight controller in lockstep with the physics."""

    def is_ready(self) -> bool:
        """Whether simulated time may begin. The simulator asks repeatedly while it waits at t = 0."""
        ...

    def begin(self, state: VehicleState) -> None:
        """Start to compute the answer to a state.

        `step` takes the answer after the simulator's other work. An autopilot may do nothing here, and the
        simulator need not call it.
        """
        ...

    def step(self, state: VehicleState) -> np.ndarray:
        """Return the rotor commands, (n,) in 0..1, to hold from `state.time_us` to the next step."""
        ...

    def reset(self) -> None:
        """Go back to the state after power-on; simulation time may start again from any value."""
        ...

    def close(self) -> None:
        """Release sockets and processes."""
        ...
