"""The rotors and the drag that a model's SDF describes in its plugins.

- ``libgazebo_motor_model.so``, PX4's model of a propeller for Gazebo.
- ``libsimulation_tools_linear_rotor.so``: thrust and torque proportional to the lagged command.
- ``libsimulation_tools_body_drag.so``: a drag -c |v| v of the whole body.
"""

from __future__ import annotations

from simulation_tools.geometry import Vector3
from simulation_tools.sdf.elements import Model
from simulation_tools.sdf.plugins import PluginReader
from simulation_tools.vehicle.rotor import AirframeError, Rotor

MOTOR_MODEL = "libgazebo_motor_model.so"
LINEAR_ROTOR = "libsimulation_tools_linear_rotor.so"
BODY_DRAG = "libsimulation_tools_body_drag.so"
ARMED_IDLE_RAD_S = 100.0  # PX4's zero_position_armed: the speed of an armed propeller at command 0+

_TURNING_DIRECTIONS = {"ccw": 1.0, "cw": -1.0}


def read_rotors(model: Model) -> tuple[list[Rotor], float]:
    """Return the rotors in the order of their motor numbers, and the body's drag coefficient, N s2/m2.

    Raises:
        AirframeError: names the file and line of a plugin that is wrong.
    """
    source, centre = model.source or model.name, centre_of_mass(model)
    rotors: dict[int, Rotor] = {}
    for plugin in model.plugins:
        if plugin.filename not in (MOTOR_MODEL, LINEAR_ROTOR):
            continue
        read = PluginReader(source, plugin, AirframeError)
        number = int(read.number("motorNumber"))
        if number in rotors:
            raise read.error(f"motorNumber {number} is there twice")
        rotors[number] = _read_rotor(read, model, centre)
    if sorted(rotors) != list(range(len(rotors))) or not rotors:
        raise AirframeError(
            f"{source}: the rotor plugins must number the motors 0, 1, 2, ... "
            f"without gaps; found {sorted(rotors)}"
        )
    drag = sum(
        PluginReader(source, plugin, AirframeError).number("quadraticDrag")
        for plugin in model.plugins
        if plugin.filename == BODY_DRAG
    )
    return [rotors[number] for number in sorted(rotors)], drag


def rotor_links(model: Model) -> frozenset[str]:
    """Return the names of the links that are rotors; none for a model without rotor plugins.

    Raises:
        AirframeError: names the file and line of a plugin without a link.
    """
    plugins = (plugin for plugin in model.plugins if plugin.filename in (MOTOR_MODEL, LINEAR_ROTOR))
    source = model.source or model.name
    return frozenset(PluginReader(source, plugin, AirframeError).text("linkName") for plugin in plugins)


def centre_of_mass(model: Model) -> Vector3:
    """Return the model's centre of mass in the model frame, metres."""
    total = sum(link.inertial.mass_kg for link in model.links)
    if not total > 0.0:
        raise AirframeError(f"{model.source or model.name}: the model has no mass")
    places = [(link.pose @ link.inertial.pose).position_m for link in model.links]
    x, y, z = (
        sum(link.inertial.mass_kg * place[axis] for link, place in zip(model.links, places)) / total
        for axis in range(3)
    )
    return x, y, z


def _read_rotor(read: PluginReader, model: Model, centre: Vector3) -> Rotor:
    """Build one rotor from its plugin; raises AirframeError."""
    try:
        link = model.link(read.text("linkName"))
        joint = model.joint(read.text("jointName"))
    except KeyError as error:
        raise read.error(f"the model has no link or joint {error}") from None
    turning = read.text("turningDirection")
    if turning not in _TURNING_DIRECTIONS:
        raise read.error(f"<turningDirection> must be cw or ccw, got {turning!r}")
    (x, y, z), (cx, cy, cz) = link.pose.position_m, centre
    place, direction = (x - cx, y - cy, z - cz), _TURNING_DIRECTIONS[turning]
    if read.filename == LINEAR_ROTOR:
        thrust, lag = read.number("maxThrust"), read.number("timeConstant")
        return Rotor(
            joint.name,
            place,
            direction,
            idle=0.0,
            top=1.0,
            time_constant_up_s=lag,
            time_constant_down_s=lag,
            thrust_quadratic=0.0,
            thrust_linear=thrust,
            moment_m=read.number("maxTorque") / thrust if thrust else 0.0,
        )
    return Rotor(
        joint.name,
        place,
        direction,
        idle=read.number("idleRotVelocity", ARMED_IDLE_RAD_S),
        top=read.number("maxRotVelocity"),
        time_constant_up_s=read.number("timeConstantUp"),
        time_constant_down_s=read.number("timeConstantDown"),
        thrust_quadratic=read.number("motorConstant"),
        thrust_linear=0.0,
        moment_m=read.number("momentConstant"),
        rotor_drag=read.number("rotorDragCoefficient", 0.0),
        rolling_moment=read.number("rollingMomentCoefficient", 0.0),
    )
