"""Rotors with lag, thrust, reaction torque and drag: rotor commands in, force and torque on the body out.

Two kinds of rotor, each described by a plugin of the model's SDF:

- ``libgazebo_motor_model.so``, PX4's model for Gazebo: a propeller of speed w with thrust k w^2, reaction
  torque k w^2 times the moment constant, and rotor drag -|w| c v, where v is the air's velocity across the
  rotor axis (Martin and Salaun, "The true role of accelerometer feedback in quadrotor control", ICRA 2010). A
  command u in (0, 1] turns it at idle + (top - idle) u; a command of 0 stops it.
- ``libsimulation_tools_linear_rotor.so``: thrust and torque proportional to the lagged command.

``libsimulation_tools_body_drag.so`` adds a drag -c |v| v of the whole body. All rotor axes are along the
body's z. Forces act at the centre of mass, frame FLU (x forward, y left, z up).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Sequence

import numpy as np
from numba import njit

from simulation_tools.errors import SimulationToolsError
from simulation_tools.geometry import Vector3
from simulation_tools.sdf.elements import Model, Plugin

MOTOR_MODEL = "libgazebo_motor_model.so"
LINEAR_ROTOR = "libsimulation_tools_linear_rotor.so"
BODY_DRAG = "libsimulation_tools_body_drag.so"
ARMED_IDLE_RAD_S = 100.0  # PX4's zero_position_armed: the speed of an armed propeller at command 0+

_TURNING_DIRECTIONS = {"ccw": 1.0, "cw": -1.0}


class AirframeError(SimulationToolsError):
    """The model's rotors are missing or described wrongly."""


@dataclass(frozen=True)
class Rotor:
    """One rotor. Its state x is the speed (rad/s) of a propeller, or the lagged command of a linear rotor.

    position_m: from the centre of mass, FLU. direction: +1 turns counter-clockwise seen from above. The
    target of x is idle + (top - idle) u. Thrust is quadratic x^2 + linear x; the reaction torque is thrust
    times moment_m, against the direction of turning. rotor_drag, rolling_moment: per x and m/s of air across.
    """

    joint: str
    position_m: Vector3
    direction: float
    idle: float
    top: float
    time_constant_up_s: float
    time_constant_down_s: float
    thrust_quadratic: float
    thrust_linear: float
    moment_m: float
    rotor_drag: float = 0.0
    rolling_moment: float = 0.0

    def __post_init__(self) -> None:
        positive = (self.top - self.idle, self.time_constant_up_s, self.time_constant_down_s)
        if not all(0.0 < value < math.inf for value in positive):
            raise AirframeError(
                f"rotor {self.joint}: top speed and time constants must be positive, got {positive}"
            )
        others = (self.thrust_quadratic, self.thrust_linear, self.moment_m, self.rotor_drag)
        if not all(0.0 <= value < math.inf for value in others) or not any(others[:2]):
            raise AirframeError(
                f"rotor {self.joint}: its thrust must be positive, torque and drag not negative"
            )

    @property
    def max_thrust_n(self) -> float:
        """Thrust at full command, still air."""
        return self.thrust_quadratic * self.top**2 + self.thrust_linear * self.top

    def command_for_thrust(self, thrust_n: float) -> float:
        """Return the steady command in 0..1 that gives a thrust (closed form; clipped)."""
        if self.thrust_quadratic:
            a, b = self.thrust_quadratic, self.thrust_linear
            x = (math.sqrt(b * b + 4.0 * a * thrust_n) - b) / (2.0 * a)
        else:
            x = thrust_n / self.thrust_linear
        return min(1.0, max(0.0, (x - self.idle) / (self.top - self.idle)))


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
def _step(rotors, commands, air, body_drag, dt, force, torque):
    """Advance every rotor by dt and sum its force and torque; air (3,): velocity through the air, FLU."""
    speed = math.sqrt(air[0] ** 2 + air[1] ** 2 + air[2] ** 2)
    for axis in range(3):
        force[axis] = -body_drag * speed * air[axis]
        torque[axis] = 0.0
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
        force[0] += drag_x
        force[1] += drag_y
        force[2] += thrust
        px, py, pz = rotor.position[0], rotor.position[1], rotor.position[2]
        torque[0] += py * thrust - pz * drag_y - x * rotor.rolling_moment * air[0]
        torque[1] += pz * drag_x - px * thrust - x * rotor.rolling_moment * air[1]
        torque[2] += px * drag_y - py * drag_x - rotor.direction * rotor.moment * thrust


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
        self._force = np.zeros(3)
        self._torque = np.zeros(3)

    @classmethod
    def from_sdf(cls, model: Model) -> Airframe:
        """Read the rotors from the model's plugins; raises AirframeError naming the file and line."""
        centre = centre_of_mass(model)
        rotors = {}
        for plugin in model.plugins:
            if plugin.filename not in (MOTOR_MODEL, LINEAR_ROTOR):
                continue
            read = _PluginReader(model, plugin)
            number = int(read.number("motorNumber"))
            if number in rotors:
                raise read.error(f"motorNumber {number} is there twice")
            rotors[number] = _read_rotor(read, model, centre)
        if sorted(rotors) != list(range(len(rotors))) or not rotors:
            raise AirframeError(
                f"{model.source or model.name}: the rotor plugins must number the motors 0, 1, 2, ... "
                f"without gaps; found {sorted(rotors)}"
            )
        drag = sum(
            _PluginReader(model, plugin).number("quadraticDrag")
            for plugin in model.plugins
            if plugin.filename == BODY_DRAG
        )
        return cls([rotors[number] for number in sorted(rotors)], drag)

    @property
    def rotor_joints(self) -> frozenset:
        """Names of the joints whose spin this class stands for; the physics treats them as fixed."""
        return frozenset(rotor.joint for rotor in self.rotors)

    @property
    def rotor_states(self) -> np.ndarray:
        """Speed of each propeller in rad/s (linear rotors: lagged command), (n,)."""
        return self._table["state"].copy()

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
        _step(self._table, commands, self._air, self.body_drag, dt_s, self._force, self._torque)
        return tuple(self._force.tolist()), tuple(self._torque.tolist())

    def reset(self) -> None:
        """Stop all rotors."""
        self._table["state"] = 0.0


def centre_of_mass(model: Model) -> Vector3:
    """Return the model's centre of mass in the model frame, metres."""
    total = sum(link.inertial.mass_kg for link in model.links)
    if not total > 0.0:
        raise AirframeError(f"{model.source or model.name}: the model has no mass")
    places = [(link.pose @ link.inertial.pose).position_m for link in model.links]
    return tuple(
        sum(link.inertial.mass_kg * place[axis] for link, place in zip(model.links, places)) / total
        for axis in range(3)
    )


class _PluginReader:
    """Typed access to a plugin's parameters, with errors that say where."""

    def __init__(self, model: Model, plugin: Plugin) -> None:
        self._where = f"{model.source or model.name}:{plugin.line}"
        self._plugin = plugin

    def error(self, text: str) -> AirframeError:
        return AirframeError(f"{self._where}: plugin {self._plugin.name!r}: {text}")

    def text(self, key: str) -> str:
        value = self._plugin.parameters.get(key)
        if value is None:
            raise self.error(f"<{key}> is missing")
        return value

    def number(self, key: str, default: float | None = None) -> float:
        if default is not None and key not in self._plugin.parameters:
            return default
        try:
            value = float(self.text(key))
        except ValueError:
            raise self.error(f"<{key}> must be a number, got {self.text(key)!r}") from None
        if not math.isfinite(value):
            raise self.error(f"<{key}> must be finite, got {value}")
        return value


def _read_rotor(read: _PluginReader, model: Model, centre: Vector3) -> Rotor:
    """Build one rotor from its plugin; raises AirframeError."""
    try:
        link = model.link(read.text("linkName"))
        joint = model.joint(read.text("jointName"))
    except KeyError as error:
        raise read.error(f"the model has no link or joint {error}") from None
    turning = read.text("turningDirection")
    if turning not in _TURNING_DIRECTIONS:
        raise read.error(f"<turningDirection> must be cw or ccw, got {turning!r}")
    common = {
        "joint": joint.name,
        "position_m": tuple(p - c for p, c in zip(link.pose.position_m, centre)),
        "direction": _TURNING_DIRECTIONS[turning],
    }
    if read._plugin.filename == LINEAR_ROTOR:
        thrust, lag = read.number("maxThrust"), read.number("timeConstant")
        return Rotor(
            idle=0.0,
            top=1.0,
            time_constant_up_s=lag,
            time_constant_down_s=lag,
            thrust_quadratic=0.0,
            thrust_linear=thrust,
            moment_m=read.number("maxTorque") / thrust if thrust else 0.0,
            **common,
        )
    return Rotor(
        idle=read.number("idleRotVelocity", ARMED_IDLE_RAD_S),
        top=read.number("maxRotVelocity"),
        time_constant_up_s=read.number("timeConstantUp"),
        time_constant_down_s=read.number("timeConstantDown"),
        thrust_quadratic=read.number("motorConstant"),
        thrust_linear=0.0,
        moment_m=read.number("momentConstant"),
        rotor_drag=read.number("rotorDragCoefficient", 0.0),
        rolling_moment=read.number("rollingMomentCoefficient", 0.0),
        **common,
    )
