"""All rotors of a multirotor in the air: rotor commands in, force and torque on the body out.

The propellers follow PX4's model for Gazebo: thrust k w^2 at the speed w, reaction torque k w^2 times the
moment constant, and rotor drag -|w| c v, where v is the air's velocity across the rotor axis (Martin and
Salaun, "The true role of accelerometer feedback in quadrotor control", ICRA 2010). A command u in (0, 1]
turns a propeller at idle + (top - idle) u; a command of 0 stops it.

All rotor axes are along the body's z. Forces act at the centre of mass, frame FLU (x forward, y left, z up).
"""

from __future__ import annotations

import math
from typing import Sequence

import numpy as np

from kernel_cache.compiler import njit
from simulation_tools.geometry import Vector3
from simulation_tools.sdf.elements import Model
from simulation_tools.vehicle.rotor import AirframeError, Rotor
from simulation_tools.vehicle.rotor_plugins import read_rotors

_ROTOR_DTYPE = np.dtype(
    [
        ("position", np.float64, (3,)),
        ("direction", np.float64),
        ("idle", np.float64),
        ("top", np.float64),
        ("time_constant_up", np.float64),
        ("time_constant_down", np.float64),
        ("quadratic", np.float64),
        ("linear", np.float64),
        ("moment", np.float64),
        ("drag", np.float64),
        ("rolling_moment", np.float64),
        ("state", np.float64),
    ]
)


@njit(cache=True)
def _step(
    rotors: np.ndarray,
    commands: np.ndarray,
    air: np.ndarray,
    body_drag: float,
    dt: float,
) -> tuple[Vector3, Vector3]:
    """Advance every rotor by dt; return the sum of forces and of torques.

    air (3,): velocity through the air, FLU.
    """
    speed = math.sqrt(air[0] ** 2 + air[1] ** 2 + air[2] ** 2)
    force_x = -body_drag * speed * air[0]
    force_y = -body_drag * speed * air[1]
    force_z = -body_drag * speed * air[2]
    torque_x = torque_y = torque_z = 0.0
    for i in range(rotors.shape[0]):
        rotor = rotors[i]
        command = commands[i]
        target = 0.0
        if command > 0.0:  # false for NaN: a rotor without a valid command stops
            target = rotor.idle + (rotor.top - rotor.idle) * min(command, 1.0)
        lag = rotor.time_constant_up if target > rotor.state else rotor.time_constant_down
        rotor.state += (target - rotor.state) * (1.0 - math.exp(-dt / lag))

        x = rotor.state
        thrust = (rotor.quadratic * x + rotor.linear) * x
        drag_x = -x * rotor.drag * air[0]
        drag_y = -x * rotor.drag * air[1]
        force_x += drag_x
        force_y += drag_y
        force_z += thrust
        px, py, pz = rotor.position[0], rotor.position[1], rotor.position[2]
        torque_x += py * thrust - pz * drag_y - x * rotor.rolling_moment * air[0]
        torque_y += pz * drag_x - px * thrust - x * rotor.rolling_moment * air[1]
        torque_z += px * drag_y - py * drag_x - rotor.direction * rotor.moment * thrust
    return (force_x, force_y, force_z), (torque_x, torque_y, torque_z)


class Airframe:
    """The rotors and the air of one multirotor. Units SI; body frame FLU at the centre of mass."""

    def __init__(self, rotors: Sequence[Rotor], body_drag: float = 0.0) -> None:
        """rotors: in the order of the commands. body_drag: c of -c |v| v, N s2/m2."""
        if not rotors:
            raise AirframeError("an airframe needs at least one rotor")
        if not 0.0 <= body_drag < math.inf:
            raise AirframeError(f"the body's drag coefficient must not be negative, got {body_drag}")
        self.rotors = tuple(rotors)
        self.body_drag = float(body_drag)
        self._table = np.array(
            [
                (
                    r.position_m,
                    r.direction,
                    r.idle,
                    r.top,
                    r.time_constant_up_s,
                    r.time_constant_down_s,
                    r.thrust_quadratic,
                    r.thrust_linear,
                    r.moment_m,
                    r.rotor_drag,
                    r.rolling_moment,
                    0.0,
                )
                for r in self.rotors
            ],
            dtype=_ROTOR_DTYPE,
        )
        self._air = np.zeros(3)

    @classmethod
    def from_sdf(cls, model: Model) -> Airframe:
        """Read the rotors from the model's plugins; raises AirframeError naming the file and line."""
        return cls(*read_rotors(model))

    @property
    def rotor_joints(self) -> frozenset[str]:
        """Names of the rotor joints. This class models their spin; the physics treats them as fixed."""
        return frozenset(rotor.joint for rotor in self.rotors)

    @property
    def rotor_states(self) -> np.ndarray:
        """Speed of each propeller in rad/s (linear rotors: lagged command), (n,)."""
        return self._table["state"].copy()

    @property
    def thrusts_n(self) -> np.ndarray:
        """Thrust of each rotor, N, (n,)."""
        table = self._table
        x = table["state"]
        return (table["quadratic"] * x + table["linear"]) * x

    def hover_command(self, mass_kg: float, gravity_m_s2: float = 9.8) -> float:
        """Return the command at which equal rotors carry the mass in still air (closed form, 0..1)."""
        return self.rotors[0].command_for_thrust(mass_kg * gravity_m_s2 / len(self.rotors))

    def step(
        self,
        commands: np.ndarray,
        velocity_body_m_s: Sequence[float],
        dt_s: float,
        wind_body_m_s: Sequence[float] = (0.0, 0.0, 0.0),
    ) -> tuple[Vector3, Vector3]:
        """Advance the rotors and return (force N, torque N m) on the body for this step.

        commands: (n,) 0..1, held during the step. velocity_body_m_s: of the centre of mass in the world,
        given in the body frame, as is the wind.
        """
        vx, vy, vz = velocity_body_m_s
        wx, wy, wz = wind_body_m_s
        self._air[0] = vx - wx
        self._air[1] = vy - wy
        self._air[2] = vz - wz
        return _step(self._table, commands, self._air, self.body_drag, dt_s)

    def reset(self) -> None:
        """Stop all rotors."""
        self._table["state"] = 0.0
